"""The service that a simulated robot lives beside: of systemd, or, where there is none, a child
that is started again whenever it ends."""

import os
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final
from typing import Protocol as Port

from hil_sim.driving.child import end, spawn
from hil_sim.driving.link import HarnessError

AGAIN_S: Final = 1.0  # between an end and the start that follows
ASKED_S: Final = 30.0
FILLER: Final = "filler"
MOST_BYTES: Final = 1 << 30


class Service(Port):
    """What a soak does to a service."""

    full_disk: Path | None  # a folder of its state that may be filled, as seen from here

    def signal(self, number: signal.Signals) -> None:
        """To its main process; without one nothing happens."""
        ...

    def restart(self) -> None:
        """In order. Returns at once."""
        ...

    def memory_mb(self) -> float | None:
        """Resident; None while there is no process."""
        ...

    def starts(self) -> int:
        """How often it was started, as far as was looked."""
        ...


class Child:
    """A process that is started again `AGAIN_S` after it has ended, until `close`. Its output goes
    to LOG-1, LOG-2, ..."""

    full_disk: Path | None = None

    def __init__(self, command: Sequence[str], log: Path) -> None:
        self._command, self._log, self._ending = tuple(command), log, threading.Event()
        self._process, self._starts = self._spawned(1), 1
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def signal(self, number: signal.Signals) -> None:
        with suppress(ProcessLookupError):
            os.kill(self._process.pid, number)

    def restart(self) -> None:
        self.signal(signal.SIGTERM)

    def memory_mb(self) -> float | None:
        try:
            return resident_mb(Path(f"/proc/{self._process.pid}/status").read_text())
        except OSError:
            return None

    def starts(self) -> int:
        return self._starts

    def close(self) -> None:
        """End it for good. Idempotent."""
        self._ending.set()
        self._thread.join()
        self.signal(signal.SIGCONT)
        end(self._process)

    def _spawned(self, number: int) -> subprocess.Popen[bytes]:
        return spawn(self._command, self._log.with_name(f"{self._log.name}-{number}"))

    def _watch(self) -> None:
        while not self._ending.wait(0.1):
            if self._process.poll() is not None and not self._ending.wait(AGAIN_S):
                self._process = self._spawned(self._starts + 1)
                self._starts += 1


class Unit:
    """A unit of systemd, told by `systemctl`. `within`: what goes before every command, such as
    ("nsenter", "-t", PID, "-a") for a container's."""

    def __init__(
        self, name: str, within: Sequence[str] = (), full_disk: Path | None = None
    ) -> None:
        self._name, self._within, self.full_disk = name, tuple(within), full_disk
        self._invocations: set[str] = set()

    def signal(self, number: signal.Signals) -> None:
        with suppress(HarnessError):  # it is not up
            self._run("systemctl", "kill", "--kill-whom=main", f"--signal={number}", self._name)

    def restart(self) -> None:
        self._run("systemctl", "restart", "--no-block", self._name)

    def memory_mb(self) -> float | None:
        pid = self._shown("MainPID")
        with suppress(HarnessError):
            return resident_mb(self._run("cat", f"/proc/{pid}/status")) if pid != "0" else None
        return None

    def starts(self) -> int:
        self._invocations.add(self._shown("InvocationID"))
        return len(self._invocations - {""})

    def _shown(self, what: str) -> str:
        return self._run("systemctl", "show", "--value", f"--property={what}", self._name).strip()

    def _run(self, *command: str) -> str:
        words = [*self._within, *command]
        try:
            done = subprocess.run(words, capture_output=True, text=True, timeout=ASKED_S)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise HarnessError(f"{words[0]}: {error}") from error
        if done.returncode:
            raise HarnessError(f"{' '.join(command)}: {done.stderr.strip() or done.returncode}")
        return done.stdout


def resident_mb(status: str) -> float | None:
    """Of /proc/PID/status."""
    for line in status.splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return None


def fill(directory: Path, block: int = 1 << 20) -> None:
    """Write until nothing more can be written; HarnessError on a disk that is not for this."""
    if shutil.disk_usage(directory).total > MOST_BYTES:
        raise HarnessError(
            f"{directory}: is on a large disk, which is not filled: a tmpfs is meant"
        )
    with suppress(OSError), (directory / FILLER).open("wb", buffering=0) as file:
        while True:
            file.write(b"\0" * block)


def check_small(directory: Path) -> None:
    """HarnessError for a directory on a disk that must not be filled."""
    if shutil.disk_usage(directory).total > MOST_BYTES:
        raise HarnessError(f"{directory}: is on a large disk, which is not filled: use a tmpfs")


def empty(directory: Path) -> None:
    """Take away what `fill` wrote. Idempotent."""
    (directory / FILLER).unlink(missing_ok=True)


def put_aside(state: Path) -> int:
    """How many of a service's saved files it could not read."""
    return sum(1 for _ in state.rglob("*.aside-*"))


def beside(service: Service, name: str, lasts_s: float) -> None:
    """Do to the service what a trouble of that name is (`soak_plan.PROCESS`), to its end."""
    if name == "restart":
        service.restart()
    elif name == "kill":
        service.signal(signal.SIGKILL)
    elif name == "freeze":
        service.signal(signal.SIGSTOP)
        time.sleep(lasts_s)
        service.signal(signal.SIGCONT)  # where no watchdog has ended it
    elif name == "disk-full" and service.full_disk is not None:
        fill(service.full_disk)
        time.sleep(lasts_s)
        empty(service.full_disk)
