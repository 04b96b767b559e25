"""A laser scan beside an image: which one, and where its beams lie in the map."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.types import F64, Pose, Scan
from runtime.errors import SensorError
from runtime.robot.session import SensesConfig
from runtime.robot.sync import RawMessage, Rings, interpolate
from runtime.robot.wire import Stamped
from runtime.robot.wire_senses import Beams, decode_scan

BESIDE_NS: Final = 250_000_000  # between a scan and the image that it is taken with
FOREIGN_NS: Final = 2_000_000_000  # farther apart than that are clocks, not scans
KEPT: Final = 10
LEVEL_RAD: Final = math.radians(10.0)  # a laser that leans more shows no plane


@dataclass(frozen=True)
class LaserMount:
    """Where a level laser is on the base, m; where its angle 0 points, rad; and whether its angles
    run clockwise, for it hangs upside down."""

    x_m: float
    y_m: float
    yaw_rad: float
    hangs: bool = False


def as_configured(config: SensesConfig) -> LaserMount:
    """What the keys say of it."""
    return LaserMount(config.laser_x_m, config.laser_y_m, config.laser_yaw_rad)


def as_placed(placed: F64, frame: str) -> LaserMount:
    """(4, 4) from the laser's frame to the base's -> the same; SensorError for one that leans."""
    up = float(placed[2, 2])
    if abs(up) < math.cos(LEVEL_RAD):
        lean_deg = math.degrees(math.acos(min(1.0, abs(up))))
        raise SensorError(f"tf: {frame} leans by {lean_deg:.0f} degrees: mount the laser level")
    yaw_rad = math.atan2(placed[1, 0], placed[0, 0])
    return LaserMount(float(placed[0, 3]), float(placed[1, 3]), yaw_rad, up < 0)


@dataclass(frozen=True)
class ScanMatch:
    """A scan, and the odometry on both sides of its stamp."""

    scan: RawMessage
    before: RawMessage
    after: RawMessage


@dataclass
class Scans:
    """The newest scans, not decoded."""

    _kept: deque[RawMessage] = field(default_factory=lambda: deque(maxlen=KEPT))

    def file(self, raw: RawMessage) -> None:
        if self._kept and raw.stamp_ns < self._kept[-1].stamp_ns:
            self._kept.clear()  # its clock was set back
        self._kept.append(raw)

    def take(self, stamp_ns: int, rings: Rings) -> ScanMatch | None:
        """The newest that was taken about then, once, where there is odometry of its time.
        SensorError for one by another clock."""
        while self._kept:
            raw = self._kept.pop()
            if abs(raw.stamp_ns - stamp_ns) > FOREIGN_NS:
                off_s = (raw.stamp_ns - stamp_ns) / 1e9
                raise SensorError(f"scan: stamped {off_s:+.1f} s from the image: use one clock")
            sides = rings.around(raw.stamp_ns)
            if abs(raw.stamp_ns - stamp_ns) <= BESIDE_NS and sides is not None:
                self._kept.clear()
                return ScanMatch(raw, *sides)
            if raw.stamp_ns < stamp_ns - BESIDE_NS:
                self._kept.clear()
        return None


class ScanStream:
    """The scans of one laser, for the map and for the reflex. `placed`: a frame on the base's at a
    time, (4, 4), where tf tells; None: the laser is where the keys say. Nothing is locked."""

    def __init__(
        self, config: SensesConfig, topic: str, placed: Callable[[str, int], F64] | None
    ) -> None:
        self._config, self._topic, self._placed = config, topic, placed
        self._kept = {"map": Scans(), "reflex": Scans()}

    def file(self, raw: RawMessage) -> None:
        for scans in self._kept.values():
            scans.file(raw)

    def take(self, by: str, stamp_ns: int, rings: Rings) -> ScanMatch | None:
        """What is new to the map or the reflex about that time; see `Scans.take`."""
        return self._kept[by].take(stamp_ns, rings)

    def read(self, found: ScanMatch, pose: Callable[[RawMessage], Stamped[Pose]]) -> Scan:
        """A scan in the map. SensorError for one that cannot be read or placed."""
        told = decode_scan(found.scan.payload, self._topic)
        if self._placed is None:
            mount = as_configured(self._config)
        else:
            frame = told.value.frame
            mount = as_placed(self._placed(frame, told.stamp_ns), frame)
        return in_map(told, mount, pose(found.before), pose(found.after))


def in_map(
    told: Stamped[Beams], mount: LaserMount, before: Stamped[Pose], after: Stamped[Pose]
) -> Scan:
    """A scan where its beams were: each one as far turned as the base had turned by its time. The
    poses are those just before and after the scan's stamp, which is its first beam's."""
    beams = told.value
    n = np.arange(len(beams.ranges_m), dtype=np.float64)
    whole_s = beams.step_s * max(0, len(n) - 1)
    span_s = (after.stamp_ns - before.stamp_ns) / 1e9
    turned = wrap_angle(after.value.yaw_rad - before.value.yaw_rad)
    rate = turned / span_s if span_s > 0 else 0.0
    pose = interpolate(before, after, told.stamp_ns + round(whole_s / 2 * 1e9))
    angles = beams.first_rad + n * beams.step_rad
    here = mount.yaw_rad + (-angles if mount.hangs else angles)
    headings = pose.yaw_rad + here + rate * (n * beams.step_s - whole_s / 2)
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    x_m = pose.x_m + c * mount.x_m - s * mount.y_m
    return Scan((x_m, pose.y_m + s * mount.x_m + c * mount.y_m), headings, beams.ranges_m)
