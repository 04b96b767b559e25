"""A velocity as each autopilot takes it."""

import math

import pytest
from mavlink_messages import ARDUPILOT, GUIDED, OFFBOARD, PX4, heard, heartbeat, parameter

from runtime.core.types import Twist
from runtime.robot.mavlink.set_points import STAND_MPS, TURN_MPS, set_point
from runtime.robot.mavlink.vehicle import Vehicle


def asked(autopilot: int, v_mps: float, w_radps: float, gain: float | None = None):
    vehicle = Vehicle()
    mode = OFFBOARD if autopilot == PX4 else GUIDED
    vehicle.hear(heartbeat(mode, True, autopilot, system=5), 0.0)
    if gain is not None:
        vehicle.hear(parameter_of(5, gain), 0.0)
    point = set_point(vehicle, Twist(v_mps, w_radps), 1234)
    message = heard(point.message)
    assert (message.time_boot_ms, message.target_system) == (1234, 5)
    assert message.coordinate_frame == 8  # MAV_FRAME_BODY_NED
    return point, message


def parameter_of(system: int, gain: float):
    return heard(parameter("RO_YAW_P", gain), system=system)


@pytest.mark.parametrize(
    ("v_mps", "w_radps"), [(0.4, 0.0), (0.3, 0.5), (0.2, -0.5), (0.0, 1.0), (-0.1, 0.0), (0.0, 0.0)]
)
def test_ardupilot_takes_forward_speed_and_yaw_rate_which_is_positive_to_the_right(v_mps, w_radps):
    point, message = asked(ARDUPILOT, v_mps, w_radps)
    assert message.type_mask == 1511
    assert (message.vx, message.vy) == (pytest.approx(v_mps), 0.0)
    assert message.yaw_rate == pytest.approx(-w_radps)
    assert (point.twist, point.why) == (Twist(v_mps, w_radps), "")


@pytest.mark.parametrize("gain", [None, 2.0])
def test_px4_heads_where_the_velocity_points(gain):
    point, message = asked(PX4, 0.4, 0.5, gain)
    assert message.type_mask == 3527  # velocity alone
    assert math.hypot(message.vx, message.vy) == pytest.approx(0.4)
    left_rad = -math.atan2(message.vy, message.vx)
    assert left_rad == pytest.approx(0.5 / (gain or 5.0))
    assert point.twist == Twist(0.4, 0.5)


@pytest.mark.parametrize("gain", [math.nan, 0.0, -3.0])
def test_a_gain_that_is_none_is_not_used(gain):
    _, message = asked(PX4, 0.4, 0.5, gain)
    assert -math.atan2(message.vy, message.vx) == pytest.approx(0.1)


def test_px4_turns_on_the_spot_by_a_direction_to_the_side_at_no_speed():
    for w_radps, gain in ((1.0, 5.0), (-1.0, 5.0), (3.0, 1.0)):
        _, message = asked(PX4, 0.0, w_radps, gain)
        assert math.hypot(message.vx, message.vy) == pytest.approx(TURN_MPS)
        left_rad = -math.atan2(message.vy, message.vx)
        assert left_rad == pytest.approx(max(-math.pi / 2, min(math.pi / 2, w_radps / gain)))


def test_px4_stands_looking_ahead_for_a_zero_vector_points_north():
    point, message = asked(PX4, 0.0, 0.0)
    assert (message.vx, message.vy) == (pytest.approx(STAND_MPS), 0.0)
    assert (point.twist, point.why) == (Twist(), "")


def test_px4_does_not_back_and_says_so():
    point, message = asked(PX4, -0.2, 0.0)
    assert message.vx == pytest.approx(STAND_MPS)
    assert point.twist == Twist()
    assert "backwards" in point.why


# -- to the number ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("autopilot", "mask"), [(ARDUPILOT, 1511), (PX4, 3527)])
def test_all_of_a_message(autopilot: int, mask: int):
    vehicle = Vehicle()
    vehicle.hear(heartbeat(GUIDED, True, autopilot, system=5, component=3), 0.0)
    point = set_point(vehicle, Twist(0.5, 0.0), (1 << 32) + 7)  # after 50 days
    told = heard(point.message).to_dict()
    zeros = ("x", "y", "z", "vy", "vz", "afx", "afy", "afz", "yaw", "yaw_rate")
    assert {name: told[name] for name in zeros} == dict.fromkeys(zeros, 0.0)
    assert (told["vx"], told["type_mask"], told["coordinate_frame"]) == (0.5, mask, 8)
    assert (told["target_system"], told["target_component"]) == (5, 3)
    assert told["time_boot_ms"] == 7


@pytest.mark.parametrize(
    ("gain", "used"), [(0.1, 5.0), (0.125, 0.125), (1.0, 1.0), (math.inf, 5.0)]
)
def test_a_gain_is_used_from_a_tenth_on(gain: float, used: float):
    vehicle = Vehicle()
    vehicle.hear(heartbeat(OFFBOARD, True, PX4), 0.0)
    vehicle.parameters["RO_YAW_P"] = gain
    message = set_point(vehicle, Twist(0.4, 0.1), 0).message
    assert -math.atan2(message.vy, message.vx) == pytest.approx(0.1 / used)


@pytest.mark.parametrize("w_radps", [3.0, -3.0])
def test_no_direction_is_farther_to_a_side_than_that(w_radps: float):
    _, message = asked(PX4, 0.4, w_radps, gain=1.0)
    left_rad = math.copysign(math.pi / 2, w_radps)
    assert -math.atan2(message.vy, message.vx) == pytest.approx(left_rad, abs=1e-6)


def test_px4_turns_while_it_is_to_back_and_turn():
    point, message = asked(PX4, -0.2, 0.5)
    assert math.hypot(message.vx, message.vy) == pytest.approx(TURN_MPS)
    assert point.twist == Twist(0.0, 0.5)
    assert point.why == "PX4 takes no velocity backwards"
