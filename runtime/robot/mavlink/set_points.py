"""A velocity as each autopilot takes it: SET_POSITION_TARGET_LOCAL_NED in the body's frame.

ArduPilot's Rover takes forward speed and yaw rate (type mask 1511, ArduPilot's "Rover Commands in
Guided Mode"). PX4 ignores a differential rover's yaw rate and heads where the velocity points
(PX4's "Offboard Mode", MAVLink, Rover), so that a turn is a direction, and standing still is one
too: a zero vector points north.
"""

import math
from typing import Any, Final, NamedTuple

from pymavlink.dialects.v20 import common as mavlink

from runtime.core.types import Twist
from runtime.robot.mavlink.vehicle import YAW_GAIN, Autopilot, Vehicle

SPEED_AND_YAW_RATE: Final = 1511
VELOCITY: Final = 0b110111000111  # neither position, acceleration, yaw nor yaw rate
YAW_GAIN_1PS: Final = 5.0  # rad/s a rad, where the vehicle does not tell its own
WIDEST_RAD: Final = math.pi / 2  # that a direction is to the side
STAND_MPS: Final = 0.001  # PX4: straight ahead, below any speed that it drives
TURN_MPS: Final = 0.01  # PX4: on the spot


class SetPoint(NamedTuple):
    """A message, what it really asks of the base, and why that is not what was ordered."""

    message: Any
    twist: Twist
    why: str = ""


def set_point(vehicle: Vehicle, twist: Twist, time_ms: int) -> SetPoint:
    """`time_ms`: since we began."""
    if vehicle.autopilot is Autopilot.PX4:
        return _direction(vehicle, twist, time_ms)
    # Down is positive: what turns us left is negative there.
    message = _message(vehicle, SPEED_AND_YAW_RATE, time_ms, twist.v_mps, 0.0, -twist.w_radps)
    return SetPoint(message, twist)


def _direction(vehicle: Vehicle, twist: Twist, time_ms: int) -> SetPoint:
    why = ""
    if twist.v_mps < 0:
        twist, why = Twist(0.0, twist.w_radps), "PX4 takes no velocity backwards"
    gain = vehicle.parameters.get(YAW_GAIN, 0.0)
    gain = gain if math.isfinite(gain) and gain > 0.1 else YAW_GAIN_1PS
    right_rad = max(-WIDEST_RAD, min(WIDEST_RAD, -twist.w_radps / gain))
    speed_mps = twist.v_mps or (TURN_MPS if twist.w_radps else STAND_MPS)
    x, y = speed_mps * math.cos(right_rad), speed_mps * math.sin(right_rad)
    return SetPoint(_message(vehicle, VELOCITY, time_ms, x, y, 0.0), twist, why)


def _message(
    vehicle: Vehicle, mask: int, time_ms: int, x_mps: float, y_mps: float, yaw_radps: float
) -> Any:
    frame = mavlink.MAV_FRAME_BODY_NED
    to = time_ms & 0xFFFFFFFF, vehicle.system, vehicle.component, frame, mask
    still = 0.0, 0.0, 0.0
    velocity = x_mps, y_mps, 0.0
    return mavlink.MAVLink_set_position_target_local_ned_message(
        *to, *still, *velocity, *still, 0.0, yaw_radps
    )
