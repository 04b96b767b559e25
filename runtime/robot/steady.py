"""Which odometry can be where the robot is. No clock, no I/O."""

import math
from typing import Final

from runtime.core.geometry import wrap_angle
from runtime.core.types import Pose

FASTEST_MPS: Final = 4.0  # than which no robot in a home drives
FASTEST_RADPS: Final = 8.0
SLACK_M: Final = 0.5  # of a wheel that slips, of a SLAM that corrects itself
SLACK_RAD: Final = 1.0
LONGEST_S: Final = 1.0  # between two messages: what came after longer has moved no more than that
STEADY_S: Final = 1.0  # so long it is elsewhere on end, and then it is there


class SteadyOdometry:
    """Told of each message, says whether it can be used. One that a robot cannot have driven to is
    not; unless what comes after it is there, too, and nothing is where it was before."""

    def __init__(self) -> None:
        self._here: _Track | None = None
        self._elsewhere: _Track | None = None

    def takes(self, pose: Pose, arrival_s: float) -> bool:
        """`arrival_s` is monotonic."""
        if self._here is None or self._here.leads_to(pose, arrival_s):
            self._here, self._elsewhere = self._here or _Track(pose, arrival_s), None
            return True
        if self._elsewhere is None or not self._elsewhere.leads_to(pose, arrival_s):
            self._elsewhere = _Track(pose, arrival_s)
        if arrival_s - self._elsewhere.began_s < STEADY_S:
            return False
        self._here, self._elsewhere = self._elsewhere, None
        return True


class _Track:
    """Where messages have led, and how far the next may be: what was not driven is saved up, to a
    bound, so that many small steps come to no more than one that is driven."""

    def __init__(self, pose: Pose, arrival_s: float) -> None:
        self.began_s = self._last_s = arrival_s
        self._pose, self._left_m, self._left_rad = pose, SLACK_M, SLACK_RAD

    def leads_to(self, pose: Pose, arrival_s: float) -> bool:
        """Whether a robot may be there now; it is then."""
        last = self._pose
        moved_m = math.hypot(pose.x_m - last.x_m, pose.y_m - last.y_m)
        turned_rad = abs(wrap_angle(pose.yaw_rad - last.yaw_rad))
        dt_s = min(LONGEST_S, max(0.0, arrival_s - self._last_s))
        left_m = min(self._left_m, SLACK_M) + FASTEST_MPS * dt_s - moved_m
        left_rad = min(self._left_rad, SLACK_RAD) + FASTEST_RADPS * dt_s - turned_rad
        if left_m < 0 or left_rad < 0:
            return False
        self._pose, self._last_s = pose, max(self._last_s, arrival_s)
        self._left_m, self._left_rad = left_m, left_rad
        return True
