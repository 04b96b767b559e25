"""A Debian with a systemd of its own, booted beside this one. It shares the network and nothing
else; what is written in it is gone afterwards."""

import os
import shutil
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Self

BOOT_S = 60.0
LOOK_S = 0.1
ENVIRONMENT = {
    "PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
    "TERM": "dumb",
}


def root_file_system() -> Path:
    """Where scripts/debian-root has left one, or will."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return cache / "rf-nav" / "roots" / "bookworm"


def why_not() -> str:
    """What is missing for a machine; "" where there can be one."""
    if os.geteuid() != 0:
        return "only root may boot a system"
    if shutil.which("systemd-nspawn") is None or not root_file_system().is_dir():
        return "scripts/debian-root has not been run"
    return ""


class Machine:
    """`sees`: folders of this computer by their place in it, read-only. OSError where it cannot be
    booted."""

    def __init__(self, work: Path, sees: Mapping[str, Path]) -> None:
        self._root, self._log = work / "root", work / "console"
        for name in ("root", "changed", "work"):
            (work / name).mkdir()
        (work / "changed").chmod(0o755)  # its mode is that of the machine's /
        layers = f"lowerdir={root_file_system()},upperdir={work}/changed,workdir={work}/work"
        command = ["mount", "-t", "overlay", "overlay", "-o", layers, str(self._root)]
        mounted = subprocess.run(command, capture_output=True, text=True, check=False)
        if mounted.returncode != 0:
            raise OSError(mounted.stderr.strip())
        shown = [f"--bind-ro={place}:{path}" for path, place in sees.items()]
        own = f"--machine=rf-nav-{os.getpid()}"
        with self._log.open("wb") as log:
            self._nspawn = subprocess.Popen(
                ["systemd-nspawn", "-D", str(self._root), "--boot", "--register=no", "--keep-unit",
                 "--quiet", own, *shown],
                stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                start_new_session=True,
            )  # fmt: skip

    def __enter__(self) -> Self:
        by_s = time.monotonic() + BOOT_S
        while time.monotonic() < by_s and self._nspawn.poll() is None:
            if self._init() and self.told("systemctl", "is-system-running") in (
                "running",
                "degraded",
            ):
                return self
            time.sleep(LOOK_S)
        self.__exit__()
        raise OSError(f"it does not boot: {self._log.read_text(errors='replace')[-300:]}")

    def __exit__(self, *_: object) -> None:
        self._nspawn.terminate()  # which has it power off
        try:
            self._nspawn.wait(30)
        except subprocess.TimeoutExpired:
            self._nspawn.kill()
            self._nspawn.wait()
        subprocess.run(["umount", "-l", str(self._root)], check=False)

    def _init(self) -> int:
        """Its first process, by its number here; 0 when there is none yet."""
        nspawn = self._nspawn.pid
        try:
            words = Path(f"/proc/{nspawn}/task/{nspawn}/children").read_text().split()
        except OSError:
            return 0
        return int(words[0]) if words else 0

    @property
    def within(self) -> tuple[str, ...]:
        """What goes before a command that is to run in it."""
        return ("nsenter", "-t", str(self._init()), "-m", "-u", "-i", "-p", "-r", "-w")

    def seen(self, path: str) -> Path:
        """A path in it, from here."""
        return Path(f"/proc/{self._init()}/root{path}")

    def run(self, *command: str, timeout: float = 900.0) -> subprocess.CompletedProcess[str]:
        """A command in it, as root, to its end."""
        return subprocess.run(
            [*self.within, *command], capture_output=True, text=True, timeout=timeout, check=False,
            env=ENVIRONMENT, stdin=subprocess.DEVNULL,
        )  # fmt: skip

    def told(self, *command: str) -> str:
        """What it prints."""
        return self.run(*command).stdout.strip()

    def shell(self, script: str) -> str:
        """What a script prints; AssertionError where it fails."""
        done = self.run("bash", "-euc", script)
        assert done.returncode == 0, (script, done.stdout, done.stderr)
        return done.stdout.strip()

    def until(self, what: str, seconds: float = 60.0) -> None:
        """Wait for a line of shell to succeed."""
        by_s = time.monotonic() + seconds
        while self.run("bash", "-c", what).returncode != 0:
            assert time.monotonic() < by_s, (what, self.journal())
            time.sleep(LOOK_S)

    def journal(self) -> str:
        """The end of what it has logged."""
        return self.told("journalctl", "--no-pager", "-n", "40")

    def here(self, pid: int) -> int:
        """The number, here, of one of its processes. ProcessLookupError when there is none."""
        space = os.stat(f"/proc/{self._init()}/ns/pid").st_ino
        for place in Path("/proc").glob("[0-9]*"):
            try:
                ours = os.stat(place / "ns" / "pid").st_ino == space
                lines = (place / "status").read_text().splitlines()
            except OSError:  # it has ended meanwhile
                continue
            told = next(line.split() for line in lines if line.startswith("NSpid:"))
            if ours and int(told[-1]) == pid:
                return int(place.name)
        raise ProcessLookupError(pid)
