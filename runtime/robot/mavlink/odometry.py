"""Odometry from a vehicle's estimator: north, east, down -> the map frame. No clock, no socket.

The estimator's frame is turned to where the vehicle stood when it was heard first: x forward, y
left, yaw counter-clockwise from there.
"""

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Any, Final

from pymavlink.dialects.v20 import common as mavlink

from runtime.core.geometry import wrap_angle
from runtime.core.types import Pose

WINDOW_NS: Final = 10_000_000_000  # in which the fastest message tells the offset of the clocks
TURN_GAP_S: Final = 0.2  # between a position and the attitude that is taken with it
SILENT_NS: Final = 1_000_000_000  # ODOMETRY does not come any more
FRAMES: Final = (mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_LOCAL_FRD)


class BootTime:
    """The vehicle's time since it was switched on, as that of our wall clock. Messages are late by
    different amounts: the least of the last ten seconds is taken for none."""

    def __init__(self) -> None:
        self._offsets: deque[tuple[int, int]] = deque()  # arrival, offset: least first
        self._last_ns = -1

    def stamp_ns(self, boot_ns: int, arrival_ns: int) -> int:
        """`arrival_ns`: by the wall clock."""
        if boot_ns < self._last_ns - WINDOW_NS // 10:
            self._offsets.clear()  # it was switched off and on
        self._last_ns = boot_ns
        offset = arrival_ns - boot_ns
        while self._offsets and self._offsets[-1][1] >= offset:
            self._offsets.pop()
        self._offsets.append((arrival_ns, offset))
        while self._offsets[0][0] < arrival_ns - WINDOW_NS:
            self._offsets.popleft()
        return boot_ns + self._offsets[0][1]


@dataclass
class VehicleOdometry:
    """ODOMETRY where it comes, else LOCAL_POSITION_NED with the yaw of ATTITUDE."""

    _time: BootTime = field(default_factory=BootTime)
    _start: tuple[float, float, float] | None = None  # north m, east m, yaw rad
    _attitude: tuple[float, float, float] | None = None  # boot s, yaw rad, rad/s
    _whole_ns: int | None = None  # when ODOMETRY came last

    def hear(self, message: Any, arrival_ns: int) -> tuple[Pose, int] | None:
        """The pose that a message tells, and its stamp by our wall clock; None when it tells none.
        What is not finite is dropped."""
        kind = message.get_type()
        if kind == "ATTITUDE" and math.isfinite(message.yaw + message.yawspeed):
            self._attitude = message.time_boot_ms / 1e3, message.yaw, message.yawspeed
        elif kind == "ODOMETRY" and message.frame_id in FRAMES:
            yaw_rad = _yaw(*message.q)
            if math.isfinite(message.x + message.y + yaw_rad):
                self._whole_ns = arrival_ns
                place = message.x, message.y, yaw_rad
                return self._told(*place, message.time_usec * 1000, arrival_ns)
        elif kind == "LOCAL_POSITION_NED" and self._attitude is not None:
            if self._whole_ns is not None and arrival_ns - self._whole_ns < SILENT_NS:
                return None
            at_s, yaw_rad, turn_radps = self._attitude
            ahead_s = message.time_boot_ms / 1e3 - at_s
            if abs(ahead_s) <= TURN_GAP_S and math.isfinite(message.x + message.y):
                place = message.x, message.y, yaw_rad + turn_radps * ahead_s
                return self._told(*place, message.time_boot_ms * 1_000_000, arrival_ns)
        return None

    def _told(
        self, north_m: float, east_m: float, yaw_rad: float, boot_ns: int, arrival_ns: int
    ) -> tuple[Pose, int]:
        self._start = self._start or (north_m, east_m, yaw_rad)
        north, east = north_m - self._start[0], east_m - self._start[1]
        c, s = math.cos(self._start[2]), math.sin(self._start[2])
        ahead, right = c * north + s * east, c * east - s * north
        pose = Pose(ahead, -right, wrap_angle(self._start[2] - yaw_rad))
        return pose, self._time.stamp_ns(boot_ns, arrival_ns)


def _yaw(w: float, x: float, y: float, z: float) -> float:
    """Of a quaternion, clockwise from north; NaN when it is none."""
    if not 0.9 < w * w + x * x + y * y + z * z < 1.1:
        return math.nan
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
