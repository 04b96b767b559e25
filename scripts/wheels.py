"""See scripts/wheels. pip is asked what it would install there, and installs nothing."""

import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Final

from sbom import installed, of_a_robot

ROOT = Path(__file__).resolve().parent.parent
GLIBC: Final = ("2_17", "2_27", "2_28", "2_34", "2_35")  # of manylinux; Debian 12 has 2.36
WHEEL, SOURCE = "wheel", "compiled"
NONE_SUCH: Final = "No matching distribution found"


def main() -> int:
    if len(sys.argv) > 3:
        print("wheels: say scripts/wheels [aarch64] [3.11]", file=sys.stderr)
        return 2
    processor, python = [*sys.argv[1:], *("aarch64", "3.11")[len(sys.argv) - 1 :]]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = installed(of_a_robot(project))
    pins = [f"{name}=={package.version}" for name, (package, _) in found.items()]
    try:
        told = table(pins, lambda pin: ask(pin, processor, python))
    except OSError as error:
        print(f"wheels: {error}", file=sys.stderr)
        return 2
    print("\n".join([f"{processor}, Python {python}:", *told]))
    return 0


def table(pins: Iterable[str], ask: Callable[[str], str]) -> list[str]:
    """A line for each package, those to compile first; then how many."""
    kinds = {pin: ask(pin) for pin in pins}
    rows = sorted((kind != SOURCE, pin, kind) for pin, kind in kinds.items())
    of = list(kinds.values())
    return [
        *(f"{kind:9} {pin}" for _, pin, kind in rows),
        f"{of.count(WHEEL)} have wheels, {of.count(SOURCE)} are compiled",
    ]


def ask(pin: str, processor: str, python: str) -> str:
    """Whether there is a wheel; OSError when pip cannot tell."""
    there = [f"--platform=manylinux_{glibc}_{processor}" for glibc in GLIBC]
    there += [f"--platform=manylinux2014_{processor}", f"--python-version={python}"]
    with tempfile.TemporaryDirectory() as nowhere:
        command = [sys.executable, "-m", "pip", "install", "--disable-pip-version-check", "--quiet"]
        command += ["--dry-run", "--no-deps", "--ignore-installed", "--only-binary=:all:"]
        command += [*there, f"--target={nowhere}", pin]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return WHEEL
    if NONE_SUCH in done.stderr:
        return SOURCE
    raise OSError(f"{pin}: {(done.stderr.strip().splitlines() or ['pip says nothing'])[-1]}")


if __name__ == "__main__":
    sys.exit(main())
