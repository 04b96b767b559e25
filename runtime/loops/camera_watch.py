"""Whether a camera lives: what it shows from elsewhere is something else."""

import math
from dataclasses import dataclass

import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.motion.safety import Halt, HaltKind
from runtime.core.types import Observation

MOVED_M, MOVED_RAD = 0.05, 0.05  # since the first of equal images: it is none of here any more


@dataclass
class CameraWatch:
    """Of one search, frame by frame. `repeated`: frames that showed nothing new, although the robot
    had moved."""

    repeated: int = 0
    _first: Observation | None = None  # of all that show the same as the newest
    _first_s: float = 0.0

    def note(self, obs: Observation, frame_s: float) -> Halt | None:
        """A frame that arrived at `frame_s`: why nothing is driven by it; None where it is news, or
        may be."""
        first = self._first
        if first is None or not _shows_the_same(first, obs):
            self._first, self._first_s = obs, frame_s
            return None
        a, b = first.pose, obs.pose
        moved_m = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
        turned_rad = abs(wrap_angle(b.yaw_rad - a.yaw_rad))
        if moved_m <= MOVED_M and turned_rad <= MOVED_RAD:
            return None
        self.repeated += 1
        what = f"the camera has repeated itself for {frame_s - self._first_s:.1f} s"
        return Halt(
            HaltKind.FRAME,
            f"{what}, although the base moved by {moved_m:.2f} m, {turned_rad:.2f} rad",
        )


def _shows_the_same(a: Observation, b: Observation) -> bool:
    return np.array_equal(a.depth_m, b.depth_m) and np.array_equal(a.rgb, b.rgb)
