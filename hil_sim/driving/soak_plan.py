"""What goes wrong in a soak, and when: one trouble after the other, of every kind before any comes
again."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hil_sim.simulation.faults import KINDS, Fault, Span

FIRST_S: Final = 15.0  # by when a first search is under way
LASTS_S: Final = (3.0, 8.0)
SENSED: Final = (
    "camera-drop", "camera-freeze", "depth-blank", "odometry-stop", "odometry-jump", "clock-step",
    "link-lost", "base-deaf", "person", "hand", "door-closes",
)  # fmt: skip
"""Of the robot, see `simulation.faults`."""
PROCESS: Final = ("kill", "freeze", "restart", "disk-full")
"""Of the service: SIGKILL, SIGSTOP, an orderly restart, a disk that is full."""
STANDS: Final = (
    "camera-drop", "camera-freeze", "depth-blank", "odometry-stop", "link-lost", "base-deaf",
    "kill", "freeze", "restart",
)  # fmt: skip
"""While these last, the base must stand."""
TURNS: Final = ("depth-blank",)
"""In these it may turn: what is nearer than a camera sees gives no depth either."""


@dataclass(frozen=True)
class Trouble:
    """One, `at_s` after the robot's begin."""

    name: str
    at_s: float
    lasts_s: float

    def fault(self) -> Fault:
        """A robot's, as `Mishaps` take it."""
        text = f"{self.name}:at={self.at_s:g}s,for={self.lasts_s:g}s"
        span = Span(self.at_s, True), Span(self.lasts_s, True)
        return Fault(self.name, *span, KINDS[self.name].size, text)


def troubles(
    seconds: float, every_s: float, seed: int, left_out: Sequence[str] = ()
) -> tuple[Trouble, ...]:
    """For a soak of so long; the last is over before its end."""
    rng = np.random.default_rng(seed)
    kinds, found = [n for n in (*SENSED, *PROCESS) if n not in left_out], list[Trouble]()
    at_s, names = FIRST_S, list[str]()
    while at_s + LASTS_S[1] < seconds:
        names = names or list(rng.permutation(kinds))
        lasts_s = round(float(rng.uniform(*LASTS_S)), 1)
        found.append(Trouble(str(names.pop()), round(at_s, 1), lasts_s))
        at_s += every_s
    return tuple(found)
