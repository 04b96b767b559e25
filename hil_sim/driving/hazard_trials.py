"""Trials of what is put in the way of a robot that drives: what, where, and what came of it."""

import math
from dataclasses import dataclass, field
from typing import Literal

from hil_sim.simulation.body import PERSON_HEIGHT_M, PERSON_RADIUS_M

SLOWEST_MPS = 0.15  # of the speeds that are drawn for a search
SEEN_PX = 200  # of it in an image: then it is in view
REACT_S = 0.3  # camera, wire and control, as `docs/safety.md` allows them
TOLD_S = 0.1  # within which zero is to be told
Kind = Literal["box", "leg", "person"]
SIZES: dict[Kind, tuple[tuple[float, float, float], ...]] = {
    "box": ((0.4, 0.3, 0.3), (0.3, 0.3, 0.6), (0.5, 0.3, 0.9)),
    "leg": ((0.04, 0.04, 0.72), (0.06, 0.06, 0.9)),
    "person": ((2 * PERSON_RADIUS_M, 2 * PERSON_RADIUS_M, PERSON_HEIGHT_M),),
}


def halting_m(v_mps: float, brake_mps2: float, react_s: float = REACT_S) -> float:
    """The way to a halt of a robot that brakes so much later."""
    v_mps = max(0.0, v_mps)
    return v_mps * react_s + v_mps * v_mps / (2 * brake_mps2)


@dataclass
class HazardTrial:
    """One of them: how far before the body's rim it appeared, m, at which speed, m/s, in which
    search; most pixels of it that one image showed within the sensor's range while the robot drove;
    how near the body came to it, m, whether and how fast it ran into it, and how long it was driven
    on against it then. Seconds from the image that showed it first until a command that lets the
    robot halt before it, and until zero; from its appearance until zero; and until a robot that
    stood went on once it was gone (None: did not). `due`: when it was shown first it was so near
    that only zero halted the robot."""

    kind: Kind
    ahead_m: float
    high_m: float
    v_mps: float
    search: int = 0
    pixels: int = 0
    gap_m: float = math.inf
    touched: bool = False
    touch_mps: float = 0.0
    pushed_s: float = 0.0
    due: bool = False
    slow_s: float | None = None
    shown_zero_s: float | None = None
    zero_s: float | None = None
    resumed_s: float | None = None

    def avoidable(self, brake_mps2: float) -> bool:
        """Whether braking allows it, and the camera shows it."""
        return self.pixels >= SEEN_PX and halting_m(self.v_mps, brake_mps2) < self.ahead_m


@dataclass
class HazardTrials:
    """As many of each kind as are wanted, over as many searches as that takes; `ahead_m`: from the
    body's rim to what appears, the least and the most; `brake_mps2`: the runtime's."""

    wanted: int
    kinds: tuple[Kind, ...]
    seed: int
    ahead_m: tuple[float, float] = (0.5, 1.5)
    brake_mps2: float = 0.5
    done: list[HazardTrial] = field(default_factory=list)

    def next_kind(self) -> Kind | None:
        """The one that was tried least; None when all are done."""
        counts = {kind: sum(t.kind == kind for t in self.done) for kind in self.kinds}
        kind = min(counts, key=counts.__getitem__)
        return kind if counts[kind] < self.wanted else None
