"""Two versions of the code that drive in turns, and how their times compare."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from runtime.bench import synthetic
from runtime.core.types import Mount, Observation

WORKLOAD = Path(__file__).with_name("workload.py")
FRAMES, SKIPPED = 32, 6  # the first of a drive are of a map that hardly is one


def observations(mount: Mount, frames: int = FRAMES) -> list[Observation]:
    """The first part of a round in the made-up room."""
    found = []
    for n in range(frames):
        pose = synthetic._pose(n * synthetic.FRAME_S)
        rgb, depth = synthetic._frame(pose, mount)
        found.append(Observation((n + 1) * 100_000_000, rgb, depth, pose, synthetic.LENS))
    return found


class Version:
    """A process that drives with the code in `root`, each stage slowed by the share `slow`."""

    def __init__(self, root: Path, images: Path, slow: float = 0.0) -> None:
        self.slow = slow
        path = os.pathsep.join((str(root), *filter(None, [os.environ.get("PYTHONPATH")])))
        self._process = subprocess.Popen(
            [sys.executable, str(WORKLOAD), str(images)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": path},
        )

    def frame(self, n: int) -> dict[str, float]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps({"frame": n, "slow": self.slow}) + "\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        assert answer, "the process that is timed has ended"
        return json.loads(answer)

    def close(self) -> None:
        self._process.kill()
        self._process.communicate()


@contextmanager
def versions(*them: Version) -> Iterator[tuple[Version, ...]]:
    try:
        yield them
    finally:
        for version in them:
            version.close()


def drive(ours: Version, theirs: Version) -> dict[str, tuple[float, float]]:
    """By stage the median ratio of ours to theirs, and the median of theirs, ms."""
    pairs: dict[str, list[tuple[float, float]]] = {}
    for n in range(FRAMES):
        first, second = (ours, theirs) if n % 2 else (theirs, ours)
        times = {first: first.frame(n)}
        times[second] = second.frame(n)
        for stage in times[ours].keys() & times[theirs].keys() if n >= SKIPPED else ():
            pairs.setdefault(stage, []).append((times[ours][stage], times[theirs][stage]))
    return {
        stage: (median(a / b for a, b in times), 1e3 * median(b for _, b in times))
        for stage, times in pairs.items()
    }
