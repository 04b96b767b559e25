"""The computer: processor, memory, disk, and what the system grants the control loop."""

import os
import shutil
import tempfile
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from runtime.config import Config
from runtime.doctor.diagnosis import Diagnosis, ok, unknown, warning
from runtime.loops.goal_request import searches_directory
from runtime.loops.process import go_first, may_lock
from runtime.tracing.budgets import LoopBudget

CORES: Final = 2  # that everything was measured on
FREE_MB: Final = 500.0  # of the disk: some hundred searches, no recording
CPUS: Final = Path("/sys/devices/system/cpu")
CGROUP: Final = Path("/sys/fs/cgroup")
_MB: Final = 1e6


@dataclass(frozen=True)
class MachineState:
    """`governors`: of the processors that may be used, none where the system has none; `memory_mb`:
    available, by the system and by the limit of the process's group; `refused`: why the state
    directory cannot be written, "" where it can; `fifo`, `locked`: what is told where they are not
    granted, else ""."""

    cores: int
    governors: tuple[str, ...]
    memory_mb: float | None
    state: Path
    free_mb: float
    refused: str
    fifo: str
    locked: str


def machine() -> MachineState:
    """As it is now."""
    cores, state = os.sched_getaffinity(0), searches_directory()
    free_mb, refused = _disk(state)
    told: list[str] = []
    trial = threading.Thread(target=lambda: told.append(go_first()))
    trial.start()
    trial.join()
    return MachineState(
        len(cores), _governors(cores), available_mb(), state, free_mb, refused, told[0], may_lock()
    )


def _governors(cores: set[int]) -> tuple[str, ...]:
    found = set()
    for core in cores:
        try:
            path = CPUS / f"cpu{core}" / "cpufreq" / "scaling_governor"
            found.add(path.read_text(encoding="ascii").strip())
        except (OSError, ValueError):
            continue  # a virtual machine has none
    return tuple(sorted(found))


def available_mb(meminfo: Path = Path("/proc/meminfo"), cgroup: Path = CGROUP) -> float | None:
    """Available: of the machine, and of what the group of this process may still take."""
    found = []
    try:
        for line in meminfo.read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                found.append(float(line.split()[1]) * 1024 / _MB)
    except (OSError, ValueError, IndexError):
        pass  # told as not known
    try:
        most = int((cgroup / "memory.max").read_text(encoding="ascii"))
        used = int((cgroup / "memory.current").read_text(encoding="ascii"))
        found.append((most - used) / _MB)
    except (OSError, ValueError):
        pass  # "max": no limit; or no group of its own
    return min(found, default=None)


def _disk(folder: Path) -> tuple[float, str]:
    """MB free where the folder is or would be, and why nothing can be written there."""
    there = next(path for path in (folder, *folder.parents) if path.exists())
    try:
        free_mb = shutil.disk_usage(there).free / _MB
        with tempfile.TemporaryFile(dir=there) as file:
            file.write(b"\0" * 4096)
            file.flush()
        return free_mb, ""
    except OSError as error:
        return 0.0, f"{there}: {error.strerror or error}"


def judge_machine(state: MachineState, config: Config, budget: LoopBudget) -> Iterator[Diagnosis]:
    """Against what the runtime takes."""
    yield _processor(state, config)
    yield _governor(state.governors)
    yield _memory(state, budget)
    yield _state_directory(state)
    yield from _granted(state)


def _processor(state: MachineState, config: Config) -> Diagnosis:
    told = f"{state.cores} cores"
    if state.cores < CORES:
        return warning(
            "processor",
            f"{told} for rfnav; it was measured on {CORES}",
            "give it more (CPUAffinity, taskset, the container's limit), or see rfnav bench",
        )
    if config.models.threads > state.cores:
        threads = ("models.threads", str(state.cores))
        return warning("processor", f"{told}, models.threads is {config.models.threads}",
                       f"{threads[0]} = {threads[1]}", threads)  # fmt: skip
    return ok("processor", f"{told}; models take {config.models.threads} threads each")


def _governor(governors: Sequence[str]) -> Diagnosis:
    if not governors:
        return unknown("governor", "this system has no cpufreq (a virtual machine?)")
    if set(governors) <= {"performance"}:
        return ok("governor", "performance")
    return warning(
        "governor",
        f"{', '.join(governors)}: a core that slept wakes slowly",
        "sudo cpupower frequency-set --governor performance",
    )


def _memory(state: MachineState, budget: LoopBudget) -> Diagnosis:
    if state.memory_mb is None:
        return unknown("memory", "neither /proc/meminfo nor a group tells")
    told = f"{state.memory_mb:.0f} MB available; with all models rfnav takes {budget.memory_mb:.0f}"
    if state.memory_mb < budget.memory_mb:
        return warning("memory", told, "end what is not needed, or name smaller models in [models]")
    return ok("memory", told)


def _state_directory(state: MachineState) -> Diagnosis:
    told = f"{_short(state.state)}: {state.free_mb:.0f} MB free"
    if state.refused:
        return warning(
            "disk",
            f"{_short(state.state)}: cannot be written ({state.refused})",
            "journal and map of a search would be lost: set XDG_STATE_HOME to where it can",
        )
    if state.free_mb < FREE_MB:
        return warning("disk", told, "make room: what does not fit is lost, and said once")
    return ok("disk", told)


def _short(path: Path) -> str:
    """As a person would write it."""
    home = Path.home()
    return f"~/{path.relative_to(home)}" if path.is_relative_to(home) else str(path)


def _granted(state: MachineState) -> Iterator[Diagnosis]:
    if state.fifo:
        yield warning(
            "real time", state.fifo, "LimitRTPRIO=21 in its systemd unit, or ulimit -r 21"
        )
    else:
        yield ok("real time", "SCHED_FIFO is granted")
    if state.locked:
        yield warning(
            "memory lock", state.locked, "LimitMEMLOCK=infinity in its systemd unit, or ulimit -l"
        )
    else:
        yield ok("memory lock", "granted")
