"""How often odometry comes, and what a robot may do between two messages of it. No clock: times are
arguments, monotonic seconds of arrival."""

import math
import statistics
from collections import deque
from typing import Final

from runtime.core.geometry import wrap_angle
from runtime.core.types import Pose, Twist

KEPT: Final = 9  # intervals, of which the middle one counts
LONGEST_S: Final = 0.72  # that a message is waited for; what comes more seldom is no rate
BRISK_S: Final = 0.15  # so often or more: nothing is slower for it
PATIENCE: Final = 1.8  # intervals that the next message may take
BETWEEN_M: Final = 0.1  # that a robot goes at most from one message to the next,
BETWEEN_RAD: Final = 0.25  # and turns


class Pace:
    """Told of each message, in the order in which they come."""

    def __init__(self) -> None:
        self._last_s = -math.inf
        self._intervals_s: deque[float] = deque(maxlen=KEPT)

    def note(self, arrival_s: float) -> None:
        """A message. What was missing for long is no rate."""
        interval_s, self._last_s = arrival_s - self._last_s, arrival_s
        if 0 < interval_s <= LONGEST_S:
            self._intervals_s.append(interval_s)

    @property
    def period_s(self) -> float:
        """Between two messages, usually; 0 until enough have come."""
        enough = len(self._intervals_s) >= KEPT // 2
        return statistics.median(self._intervals_s) if enough else 0.0

    def patience_s(self, least_s: float) -> float:
        """How long the next message may take: so much at least."""
        return max(least_s, min(LONGEST_S, PATIENCE * self.period_s))

    def allowed(self, twist: Twist) -> Twist:
        """As much of a velocity as leaves the robot near where odometry has it."""
        period_s = self.period_s
        if period_s <= BRISK_S:
            return twist
        most = min(1.0, BETWEEN_M / period_s / max(abs(twist.v_mps), 1e-9))
        most = min(most, BETWEEN_RAD / period_s / max(abs(twist.w_radps), 1e-9))
        return twist if most == 1.0 else Twist(most * twist.v_mps, most * twist.w_radps)

    def here(self, pose: Pose, sent: Twist, age_s: float) -> Pose:
        """Where a robot is by now that was there so long ago, going as it was told since; the pose
        itself where odometry comes often."""
        if self.period_s <= BRISK_S:
            return pose
        return driven(pose, sent, max(0.0, min(age_s, LONGEST_S)))


def driven(pose: Pose, twist: Twist, seconds: float) -> Pose:
    """Along the arc of a velocity, from a pose."""
    turned = twist.w_radps * seconds
    heading = pose.yaw_rad + turned / 2
    chord = twist.v_mps * seconds * (math.sin(turned / 2) / (turned / 2) if turned else 1.0)
    return Pose(
        pose.x_m + chord * math.cos(heading),
        pose.y_m + chord * math.sin(heading),
        wrap_angle(pose.yaw_rad + turned),
    )
