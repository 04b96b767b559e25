"""Bytes <-> values of what a robot may have beside its camera: laser, bumper, cliff sensors,
battery, sticks. As in `wire`, whatever bytes come, nothing but SensorError leaves this module."""

import math
import re
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Final

import numpy as np
from rosbags.typesys import get_types_from_msg

from runtime.core.types import F32
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.wire import Stamped

LASER_SCAN: Final = "sensor_msgs/msg/LaserScan"
RANGE: Final = "sensor_msgs/msg/Range"
BATTERY_STATE: Final = "sensor_msgs/msg/BatteryState"
BOOL: Final = "std_msgs/msg/Bool"
HAZARDS: Final = "irobot_create_msgs/msg/HazardDetectionVector"
_HAZARD: Final = "irobot_create_msgs/msg/HazardDetection"

# As a Create 3 puts them on the wire; our own words, for no package of types has them.
wire.STORE.register(get_types_from_msg("std_msgs/Header header\nuint8 type\n", _HAZARD))
wire.STORE.register(
    get_types_from_msg(
        "std_msgs/Header header\nirobot_create_msgs/HazardDetection[] detections\n", HAZARDS
    )
)
_T: Final = wire.STORE.types
_CHARGING: Final = 1  # POWER_SUPPLY_STATUS_CHARGING
_MAX_BEAMS: Final = 100_000  # more is damage
_TWIST_BYTES: Final = 52  # of a Twist in CDR; a TwistStamped is longer by its header


class HazardKind(IntEnum):
    """What a Create 3 may detect."""

    BACKUP_LIMIT = 0
    BUMP = 1
    CLIFF = 2
    STALL = 3
    WHEEL_DROP = 4
    OBJECT_PROXIMITY = 5


@dataclass(frozen=True)
class Hazard:
    """One that lasts now; `sensor` is its frame: bump_front_left, cliff_side_right, ..."""

    kind: HazardKind
    sensor: str


@dataclass(frozen=True)
class Beams:
    """A scan in its laser's own frame. Beam n points at `first_rad + n * step_rad`,
    counter-clockwise about the frame's z, `step_s` after the one before it. ranges_m: (N,), 0 where
    none came back."""

    frame: str
    first_rad: float
    step_rad: float
    step_s: float
    ranges_m: F32


# -- decoding ------------------------------------------------------------------------------------


def decode_scan(payload: bytes, topic: str) -> Stamped[Beams]:
    """LaserScan -> the beams that met something within the laser's range."""
    message = wire.decode(payload, LASER_SCAN, topic)
    told = message.angle_min, message.angle_increment, message.time_increment
    first, step, step_s = (float(value) for value in told)
    near, far = float(message.range_min), float(message.range_max)
    ranges = np.array(message.ranges, np.float32)
    shown = f"{topic}: {ranges.size} beams from {first:g} rad, {step:g} rad and {step_s:g} s apart"
    if not 0 < ranges.size <= _MAX_BEAMS or not step or not all(map(math.isfinite, told)):
        raise SensorError(f"{shown}: publish a scan with beams and finite, unequal angles")
    if not (0 <= near < far) or abs(step) * (ranges.size - 1) > 2 * math.tau or step_s < 0:
        raise SensorError(f"{shown}, of {near:g} to {far:g} m: is no scan of one turn")
    met = np.isfinite(ranges) & (ranges >= near) & (ranges <= far) & (ranges > 0)
    beams = Beams(
        message.header.frame_id.lstrip("/"),
        first,
        step,
        step_s,
        np.where(met, ranges, np.float32(0)).astype(np.float32),
    )
    return Stamped(wire.header_stamp(message, topic), beams)


def decode_range(payload: bytes, topic: str) -> Stamped[float]:
    """Range -> how far away what is under a sensor is, m; inf where nothing was in range, 0 where a
    sensor that only tells near from far (REP 117) says near."""
    try:
        message = wire.decode(payload, RANGE, topic)
    except SensorError:
        message = wire.decode(payload[:-4], RANGE, topic)  # since Iron a variance comes last
    value, far = float(message.range), float(message.max_range)
    if math.isnan(value):
        raise SensorError(f"{topic}: range is not a number: publish inf where nothing is in range")
    if math.isfinite(far) and far > 0 and value >= far:
        value = math.inf
    return Stamped(wire.header_stamp(message, topic), max(0.0, value))


def decode_flag(payload: bytes, topic: str) -> bool:
    """Bool."""
    return bool(wire.decode(payload, BOOL, topic).data)


def decode_hazards(payload: bytes, topic: str) -> Stamped[tuple[Hazard, ...]]:
    """HazardDetectionVector -> what is detected now, but for kinds that nobody knows."""
    message = wire.decode(payload, HAZARDS, topic)
    known = {kind.value for kind in HazardKind}
    found = [
        Hazard(HazardKind(one.type), str(one.header.frame_id).lstrip("/"))
        for one in message.detections
        if one.type in known
    ]
    return Stamped(wire.header_stamp(message, topic), tuple(found))


def decode_battery(payload: bytes, topic: str) -> Stamped[float | None]:
    """BatteryState -> its percentage as it was told (of 1 by the standard, of 100 by many); None
    where it is not known. A voltage says nothing of that."""
    message = wire.decode(payload, BATTERY_STATE, topic)
    told = float(message.percentage)
    if math.isnan(told):
        return Stamped(wire.header_stamp(message, topic), None)
    if not 0 <= told <= 100:
        raise SensorError(f"{topic}: percentage {told:g}: publish 0 to 1, or NaN when unknown")
    return Stamped(wire.header_stamp(message, topic), told)


def decode_charging(payload: bytes, topic: str) -> bool:
    """BatteryState -> whether it says that it charges."""
    return int(wire.decode(payload, BATTERY_STATE, topic).power_supply_status) == _CHARGING


def check_sticks(payload: bytes, topic: str) -> str:
    """The type of a Twist or TwistStamped; SensorError when it is neither."""
    kind = wire.TWIST if len(payload) <= _TWIST_BYTES else wire.TWIST_STAMPED
    message = wire.decode(payload, kind, topic)
    twist = message if kind == wire.TWIST else message.twist
    speeds = float(twist.linear.x), float(twist.angular.z)
    if not all(map(math.isfinite, speeds)):
        raise SensorError(f"{topic}: velocity {speeds} is not finite")
    return kind


def bearing_named(sensor: str) -> float:
    """Where a sensor of that name is on the body, rad to the left of straight ahead: front_left,
    bump_right, cliff_side_left, ...; what says nothing of it is ahead."""
    words = set(re.split(r"[^a-z]+", sensor.lower()))
    left = bool(words & {"left", "l"}) - bool(words & {"right", "r"})
    if words & {"rear", "back"}:
        return left * 0.75 * math.pi if left else math.pi
    aside = 0.35 if words & {"front", "center", "centre"} else 1.1
    return left * aside


# -- encoding ------------------------------------------------------------------------------------


def encode_range(range_m: float, stamp_ns: int, far_m: float, frame: str) -> bytes:
    """How far away what is under a cliff sensor is -> Range, inf beyond `far_m`."""
    told = range_m if range_m < far_m else math.inf
    infrared, cone_rad, near_m = 1, 0.1, 0.0
    return wire.encode(
        _T[RANGE](wire.header(stamp_ns, frame), infrared, cone_rad, near_m, far_m, told)
    )


def encode_battery(percent: float, stamp_ns: int, frame: str = "base_link") -> bytes:
    """0 to 100 -> BatteryState, all else of it unknown."""
    nan, unknown, none = math.nan, 0, np.zeros(0, np.float32)
    values: tuple[Any, ...] = (nan, nan, nan, nan, nan, nan, percent / 100, unknown, unknown)
    return wire.encode(
        _T[BATTERY_STATE](wire.header(stamp_ns, frame), *values, unknown, True, none, none, "", "")
    )
