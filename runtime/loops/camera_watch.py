"""Whether a camera lives: what it shows from elsewhere is something else."""

import math
from dataclasses import dataclass

import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.motion.safety import Halt, HaltKind
from runtime.core.types import F32, U8, Observation, Pose

NOWHERE = Pose(math.inf, 0.0, 0.0)
MOVED_M, MOVED_RAD = 0.05, 0.05  # since the first of equal images: it is none of here any more
REPEATS_S = 0.5  # a driver may send an image more than once, for less
STOOD_M, STOOD_RAD = 0.01, 0.01  # a base that moves less from image to image stands
SETTLED_S = 1.0  # after which odometry, however seldom it comes, has told where


@dataclass
class CameraWatch:
    """Of one search, frame by frame. `repeated`: frames that showed nothing new, although the robot
    had moved; `doubt`: why nothing is driven, where the newest is one of too many on end."""

    repeated: int = 0
    doubt: Halt | None = None
    _from: Observation | None = None  # of all that show the same as the newest: where they are of
    _since_s: float = 0.0  # and when the first of them arrived
    _settled: bool = False  # the base stood there, so that odometry was not late
    _last: Pose = NOWHERE
    _stands_s: float = 0.0  # since when it is where it is now

    def repeats(self, obs: Observation, frame_s: float) -> bool:
        """Whether a frame that arrived at `frame_s` shows, from elsewhere, what was shown before.
        One without a difference in it is no place: nothing in range, or a lens that is covered.
        Where the base has come to rest its odometry may have come after the image: so where it
        stands is where that is of, once. What it moves from there is believed for good."""
        self.doubt, here = None, obs.pose
        if self._from is None or not _shows_the_same(self._from, obs):
            self._from, self._since_s, self._settled = obs, frame_s, False
            self._last, self._stands_s = here, frame_s
            return False
        if _apart(self._last, here, STOOD_M, STOOD_RAD):
            self._stands_s = frame_s
        self._last = here
        if not self._settled and frame_s - self._stands_s >= SETTLED_S:
            self._from, self._settled = obs, True
        if not _apart(self._from.pose, here, MOVED_M, MOVED_RAD):
            return False
        self.repeated += 1
        since_s = frame_s - self._since_s
        if since_s >= REPEATS_S:
            what = f"the camera has repeated itself for {since_s:.1f} s, although the base moved"
            self.doubt = Halt(HaltKind.FRAME, what)
        return True


def _apart(a: Pose, b: Pose, least_m: float, least_rad: float) -> bool:
    moved_m = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
    return moved_m > least_m or abs(wrap_angle(b.yaw_rad - a.yaw_rad)) > least_rad


def _shows_the_same(a: Observation, b: Observation) -> bool:
    same = np.array_equal(a.depth_m, b.depth_m) and np.array_equal(a.rgb, b.rgb)
    return same and (_differs(a.depth_m) or _differs(a.rgb))


def _differs(image: F32 | U8) -> bool:
    return bool(image.min() != image.max())
