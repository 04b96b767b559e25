"""What a server beside the runtime costs while its clients are there."""

import os
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, NamedTuple

from runtime.bench.measure import BenchError, resident_mb

ENDS_S: Final = 60.0
SETTLES_S: Final = 2.0  # until all clients have what there is


class ServerCost(NamedTuple):
    """Its share of a core, and its memory in the end."""

    share: float
    memory_mb: float


@contextmanager
def served(
    server: Sequence[str], clients: Sequence[str], costs: list[ServerCost]
) -> Iterator[None]:
    """Both commands at work; what the server cost is told in the end. It says a line when it is up.
    BenchError when it does not come up, or one of them ends before."""
    with subprocess.Popen(server, stdout=subprocess.PIPE, text=True) as serving, _ended(serving):
        assert serving.stdout is not None
        if not serving.stdout.readline():
            raise BenchError(f"{server[2]}: did not come up")
        with subprocess.Popen(clients) as asking, _ended(asking):
            time.sleep(SETTLES_S)
            began_s, before_s = time.monotonic(), cpu_s(serving.pid)
            yield
            if asking.poll() is not None or serving.poll() is not None:
                raise BenchError(f"{server[2]}: it or its clients ended before the drive")
            share = (cpu_s(serving.pid) - before_s) / (time.monotonic() - began_s)
            costs.append(ServerCost(share, resident_mb(serving)))


@contextmanager
def _ended(child: subprocess.Popen[Any]) -> Iterator[None]:
    try:
        yield
    finally:
        child.terminate()
        child.wait(ENDS_S)


def cpu_s(pid: int) -> float:
    """What a process has used so far."""
    words = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
