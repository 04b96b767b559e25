"""MAVLink messages as they come out of a link."""

from typing import Any

from pymavlink.dialects.v20 import common as mavlink

ARDUPILOT, PX4, NOBODY = 3, 12, 8  # MAV_AUTOPILOT
ROVER, BOAT, QUADROTOR = 10, 11, 2  # MAV_TYPE
ARMED, CUSTOM = 128, 1
MANUAL, HOLD, GUIDED = 0, 4, 15
OFFBOARD, POSCTL, PX4_HOLD = 6 << 16, 3 << 16, 4 << 16 | 3 << 24


def packed(message: Any, system: int = 1, component: int = 1) -> bytes:
    return message.pack(mavlink.MAVLink(None, system, component))


def heard(message: Any, system: int = 1, component: int = 1) -> Any:
    """A message as its reader has it: with its sender."""
    (found,) = mavlink.MAVLink(None).parse_buffer(packed(message, system, component))
    return found


def heartbeat(
    mode: int = MANUAL,
    armed: bool = False,
    autopilot: int = ARDUPILOT,
    kind: int = ROVER,
    system: int = 1,
    component: int = 1,
) -> Any:
    flags = CUSTOM | (ARMED if armed else 0)
    message = mavlink.MAVLink_heartbeat_message(kind, autopilot, flags, mode, 4, 3)
    return heard(message, system, component)


def position(time_ms: int = 0, north: float = 0.0, east: float = 0.0, **source: int) -> Any:
    place = north, east, 0.0, 0.0, 0.0, 0.0
    return heard(mavlink.MAVLink_local_position_ned_message(time_ms, *place), **source)


def attitude(time_ms: int, yaw: float, yawspeed: float = 0.0) -> Any:
    turn = 0.0, 0.0, yaw, 0.0, 0.0, yawspeed
    return heard(mavlink.MAVLink_attitude_message(time_ms, *turn))


def warning(text: str, severity: int = 4) -> Any:
    return heard(mavlink.MAVLink_statustext_message(severity, text.encode()))


def status(battery: int) -> Any:
    nothing = 0, 0, 0, 0, 12000, -1
    return heard(mavlink.MAVLink_sys_status_message(*nothing, battery, 0, 0, 0, 0, 0, 0))


def parameter(name: str, value: float, kind: int = 9) -> Any:
    return heard(mavlink.MAVLink_param_value_message(name.encode(), value, kind, 1, 0))
