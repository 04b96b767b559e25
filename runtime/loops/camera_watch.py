"""Whether a camera lives: what it shows from elsewhere is something else."""

import math
from dataclasses import dataclass

import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.motion.safety import Halt, HaltKind
from runtime.core.types import F32, U8, Observation

MOVED_M, MOVED_RAD = 0.05, 0.05  # since the first of equal images: it is none of here any more
REPEATS_S = 0.5  # a driver may send an image more than once, for less


@dataclass
class CameraWatch:
    """Of one search, frame by frame. `repeated`: frames that showed nothing new, although the robot
    had moved; `doubt`: why nothing is driven, where the newest is one of too many on end."""

    repeated: int = 0
    doubt: Halt | None = None
    _first: Observation | None = None  # of all that show the same as the newest
    _first_s: float = 0.0

    def repeats(self, obs: Observation, frame_s: float) -> bool:
        """Whether a frame that arrived at `frame_s` shows, from elsewhere, what was shown before.
        One without a difference in it is no place: nothing in range, or a lens that is covered."""
        self.doubt = None
        first = self._first
        if first is None or not _shows_the_same(first, obs):
            self._first, self._first_s = obs, frame_s
            return False
        a, b = first.pose, obs.pose
        moved_m = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
        turned_rad = abs(wrap_angle(b.yaw_rad - a.yaw_rad))
        if moved_m <= MOVED_M and turned_rad <= MOVED_RAD:
            return False
        self.repeated += 1
        since_s = frame_s - self._first_s
        if since_s >= REPEATS_S:
            moved = f"although the base moved by {moved_m:.2f} m, {turned_rad:.2f} rad"
            what = f"the camera has repeated itself for {since_s:.1f} s, {moved}"
            self.doubt = Halt(HaltKind.FRAME, what)
        return True


def _shows_the_same(a: Observation, b: Observation) -> bool:
    same = np.array_equal(a.depth_m, b.depth_m) and np.array_equal(a.rgb, b.rgb)
    return same and (_differs(a.depth_m) or _differs(a.rgb))


def _differs(image: F32 | U8) -> bool:
    return bool(image.min() != image.max())
