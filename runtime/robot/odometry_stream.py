"""Odometry as it comes: which of it images go by, how often it comes, and where the base was."""

from typing import Final

from runtime.core.motion.courses import STILL
from runtime.core.motion.pace import Pace
from runtime.core.types import Pose, Twist
from runtime.robot.odometry import BaseOdometry
from runtime.robot.steady import SteadyOdometry
from runtime.robot.sync import RawMessage, Rings, interpolate
from runtime.robot.wire import Stamped

GAP_S: Final = 0.25  # longest span that is interpolated over; more where it comes seldom


class OdometryStream:
    """Of one robot; its messages are in `rings`. Nothing is locked."""

    def __init__(self, told: BaseOdometry, rings: Rings, lockstep: bool) -> None:
        self._told, self._rings, self._lockstep = told, rings, lockstep
        self._steady, self._pace = SteadyOdometry(), Pace()
        self.sent: Twist = STILL
        """What the base was sent last, by which it has gone on since odometry that comes seldom."""
        self.newest: tuple[Stamped[Pose], float] | None = None
        """The last message and when it arrived, monotonic s, as old as its stamp says."""

    def pose(self, raw: RawMessage) -> Stamped[Pose]:
        """SensorError for one that cannot be read."""
        return self._told.read(raw)[0]

    def takes(self, raw: RawMessage, arrival_s: float) -> bool:
        """Whether a message is used for images. The newest is told of whether or not it is: who
        drives has to know of a jump. SensorError as `pose`."""
        pose = self.pose(raw)
        self.newest = pose, raw.arrival_s
        if self._lockstep:
            return True
        self._pace.note(raw.arrival_s)
        self._rings.odometry_gap_ns = int(self._pace.patience_s(GAP_S) * 1e9)
        return self._steady.takes(pose.value, arrival_s)

    def at(self, stamp_ns: int, alone: bool = False) -> Pose | None:
        """Where the base was, by the odometry on both sides; `alone`: or by the newest, where that
        is no older than what is interpolated over. None where there is none."""
        odom, sides = self._rings.odom, self._rings.around(stamp_ns)
        if sides is not None:
            return interpolate(self.pose(sides[0]), self.pose(sides[1]), stamp_ns)
        late_ns = stamp_ns - odom[-1].stamp_ns if alone and odom else -1
        if not 0 <= late_ns < self._rings.odometry_gap_ns:
            return None
        return self._pace.here(self.pose(odom[-1]).value, self.sent, late_ns / 1e9)

    def here(self, now_s: float) -> Pose | None:
        """Where the base is by now; None before the first message."""
        if self.newest is None:
            return None
        told, arrival_s = self.newest
        return self._pace.here(told.value, self.sent, now_s - arrival_s)
