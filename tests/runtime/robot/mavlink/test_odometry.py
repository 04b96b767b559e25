"""Odometry out of an estimator's north, east, down."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mavlink_messages import attitude, heard, position
from pymavlink.dialects.v20 import common as mavlink

from runtime.core.types import Pose
from runtime.robot.mavlink.odometry import BootTime, VehicleOdometry, _yaw

ANGLES = st.floats(-math.pi, math.pi)
METRES = st.floats(-50.0, 50.0)
T0 = 1_700_000_000_000_000_000


def ned(pose: Pose, start: tuple[float, float, float]) -> tuple[float, float, float]:
    """Where a pose of the map frame is for an estimator: north m, east m, yaw rad."""
    c, s = math.cos(start[2]), math.sin(start[2])
    ahead, right = pose.x_m, -pose.y_m
    return (
        start[0] + c * ahead - s * right,
        start[1] + s * ahead + c * right,
        start[2] - pose.yaw_rad,
    )


def quaternion(yaw: float) -> list[float]:
    return [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]


def odometry(boot_us: int, place: tuple[float, float, float], frame: int = 1, q=None):
    zeros = [0.0] * 21
    still = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    q = quaternion(place[2]) if q is None else q
    return heard(
        mavlink.MAVLink_odometry_message(
            boot_us, frame, 12, place[0], place[1], 0.0, q, *still, zeros, zeros
        )
    )


def close(a: Pose, b: Pose) -> bool:
    turn = math.remainder(a.yaw_rad - b.yaw_rad, math.tau)
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m) < 1e-3 and abs(turn) < 1e-3


@given(METRES, METRES, ANGLES, METRES, METRES, ANGLES)
def test_the_map_frame_is_where_it_stood_first(north, east, heading, x, y, yaw):
    start, pose = (north, east, heading), Pose(x, y, yaw)
    for ahead in (False, True):
        estimator = VehicleOdometry()
        for n, at in enumerate((Pose(0.0, 0.0, 0.0), pose)):
            place = ned(at, start)
            if ahead:
                told = estimator.hear(odometry(n * 100_000, place), T0)
            else:
                assert estimator.hear(attitude(n * 100, place[2]), T0) is None
                told = estimator.hear(position(n * 100, *place[:2]), T0)
            assert told is not None
            assert close(told[0], at)


def test_a_turn_to_the_right_is_negative():
    estimator = VehicleOdometry()
    estimator.hear(attitude(0, 1.0), T0)
    estimator.hear(position(0), T0)
    estimator.hear(attitude(100, 1.3), T0)
    told = estimator.hear(position(100), T0)
    assert told[0].yaw_rad == pytest.approx(-0.3, abs=1e-6)


def test_the_attitude_is_turned_on_to_the_position_or_waited_for():
    estimator = VehicleOdometry()
    assert estimator.hear(position(0), T0) is None  # no attitude yet
    estimator.hear(attitude(1000, 0.0), T0)
    estimator.hear(position(1000), T0)
    estimator.hear(attitude(1100, 0.1, yawspeed=1.0), T0)
    told = estimator.hear(position(1150), T0)
    assert told[0].yaw_rad == pytest.approx(-0.15, abs=1e-6)
    assert estimator.hear(position(1400), T0) is None  # too old


def test_what_is_not_finite_or_of_another_frame_is_dropped():
    estimator = VehicleOdometry()
    estimator.hear(attitude(0, math.nan), T0)
    assert estimator.hear(position(0), T0) is None
    estimator.hear(attitude(0, 0.0), T0)
    assert estimator.hear(position(0, north=math.inf), T0) is None
    assert estimator.hear(odometry(0, (math.nan, 0.0, 0.0)), T0) is None
    assert estimator.hear(odometry(0, (0.0, 0.0, 0.0), frame=4), T0) is None  # ENU
    assert estimator.hear(odometry(0, (0.0, 0.0, 0.0), q=[0.0, 0.0, 0.0, 0.0]), T0) is None
    assert estimator.hear(position(0), T0) is not None


def test_odometry_is_preferred_where_it_comes():
    estimator = VehicleOdometry()
    estimator.hear(odometry(0, (0.0, 0.0, 0.0)), T0)
    estimator.hear(attitude(0, 0.0), T0)
    assert estimator.hear(position(0), T0) is None
    assert estimator.hear(position(0), T0 + 2_000_000_000) is not None  # and no longer


@given(st.lists(st.tuples(st.integers(1, 500), st.integers(0, 80)), min_size=1, max_size=200))
def test_stamps_are_as_regular_as_the_vehicle_s_clock_however_late_messages_are(steps):
    time, boot_ms, offset = BootTime(), 5000, T0
    for n, (step_ms, late_ms) in enumerate([(10, 0), *steps]):
        boot_ms += step_ms
        arrival = offset + (boot_ms + late_ms) * 1_000_000
        stamp = time.stamp_ns(boot_ms * 1_000_000, arrival)
        assert stamp <= arrival
        if n < 18:  # the first, which was not late, is still in the window
            assert stamp == offset + boot_ms * 1_000_000


def test_the_fastest_message_counts_for_ten_seconds():
    time, second = BootTime(), 1_000_000_000
    assert time.stamp_ns(5 * second, T0) == T0
    late_ns = 300_000_000
    assert time.stamp_ns(15 * second, T0 + 10 * second + late_ns) == T0 + 10 * second + late_ns
    assert time.stamp_ns(16 * second, T0 + 11 * second + 2 * late_ns) == T0 + 11 * second + late_ns


def test_a_vehicle_that_was_switched_off_and_on_is_timed_anew():
    time = BootTime()
    assert time.stamp_ns(100_000_000_000, T0) == T0
    later = T0 + 5_000_000_000
    assert time.stamp_ns(1_000_000_000, later) == later


# -- to the number ---------------------------------------------------------------------------------

SECOND = 1_000_000_000


def test_a_stamp_is_the_vehicle_s_own_time_on_our_clock():
    estimator = VehicleOdometry()
    assert estimator.hear(odometry(5_000_000, (0.0, 0.0, 0.0)), T0)[1] == T0
    later = estimator.hear(odometry(5_250_001, (0.0, 0.0, 0.0)), T0 + SECOND)
    assert later[1] == T0 + 250_001_000
    estimator = VehicleOdometry()
    estimator.hear(attitude(5000, 0.0), T0)
    assert estimator.hear(position(5000), T0)[1] == T0
    assert estimator.hear(position(5125), T0 + SECOND)[1] == T0 + 125_000_000


def test_an_attitude_is_taken_with_a_position_just_before_and_after_it():
    for begin_ms, at_ms, told in ((0, 200, True), (0, 201, False), (400, 250, True)):
        estimator = VehicleOdometry()
        estimator.hear(attitude(begin_ms, 0.0), T0)
        assert bool(estimator.hear(position(at_ms), T0)) is told
    estimator = VehicleOdometry()
    estimator.hear(attitude(400, 0.0), T0)
    assert estimator.hear(position(100), T0) is None
    estimator.hear(attitude(400, 0.5, yawspeed=1.0), T0)
    estimator.hear(position(400), T0)
    assert estimator.hear(position(300), T0)[0].yaw_rad == pytest.approx(0.1, abs=1e-6)


def test_odometry_that_did_not_come_for_a_second_has_ended():
    estimator = VehicleOdometry()
    estimator.hear(odometry(0, (0.0, 0.0, 0.0)), T0)
    estimator.hear(attitude(0, 0.0), T0)
    assert estimator.hear(position(0), T0 + SECOND - 1) is None
    assert estimator.hear(position(0), T0 + SECOND) is not None


def test_odometry_with_something_in_it_that_is_not_finite_is_none():
    for place in ((math.inf, 0.0, 0.0), (0.0, math.inf, 0.0)):
        assert VehicleOdometry().hear(odometry(0, place), T0) is None
    spoilt = [math.nan, 0.0, 0.0, 0.0]
    assert VehicleOdometry().hear(odometry(0, (1.0, 2.0, 0.0), q=spoilt), T0) is None


def test_odometry_in_both_of_its_frames_is_heard():
    for frame in (1, 20):
        assert VehicleOdometry().hear(odometry(0, (0.0, 0.0, 0.0), frame), T0) is not None


@pytest.mark.parametrize("roll", [-0.7, 0.0, 0.6])
@pytest.mark.parametrize("pitch", [-0.6, 0.0, 0.7])
@pytest.mark.parametrize("yaw", [-2.5, -0.4, 0.0, 1.1, 3.0])
def test_the_yaw_of_a_vehicle_that_leans(roll: float, pitch: float, yaw: float):
    """MAVLink's order: about down, then right, then ahead."""
    a, b, c = (math.cos(angle / 2) for angle in (roll, pitch, yaw))
    d, e, f = (math.sin(angle / 2) for angle in (roll, pitch, yaw))
    w, x = a * b * c + d * e * f, d * b * c - a * e * f
    y, z = a * e * c + d * b * f, a * b * f - d * e * c
    assert _yaw(w, x, y, z) == pytest.approx(yaw)
    for factor in (0.9, 1.1):  # squared, the bounds are passed
        assert math.isnan(_yaw(factor * w, factor * x, factor * y, factor * z))
    for factor in (0.97, 1.03):
        assert not math.isnan(_yaw(factor * w, factor * x, factor * y, factor * z))


def test_a_clock_that_goes_back_by_a_second_goes_on_and_by_more_begins_anew():
    for back_ns, stamp in ((SECOND, T0 - SECOND), (SECOND + 1, T0 + SECOND)):
        time = BootTime()
        time.stamp_ns(100 * SECOND, T0)
        assert time.stamp_ns(100 * SECOND - back_ns, T0 + SECOND) == stamp
    time = BootTime()
    assert time.stamp_ns(0, T0) == T0


def test_the_fastest_message_counts_to_the_nanosecond():
    for after_ns, late_ns in ((10 * SECOND, 0), (10 * SECOND + 1, 7)):
        time = BootTime()
        assert time.stamp_ns(SECOND, T0) == T0
        arrival = T0 + after_ns
        assert time.stamp_ns(SECOND + after_ns - 7, arrival) == arrival - 7 + late_ns


def test_of_messages_that_are_as_fast_the_last_counts():
    time = BootTime()
    time.stamp_ns(SECOND, T0)
    time.stamp_ns(6 * SECOND, T0 + 5 * SECOND)
    assert time.stamp_ns(15 * SECOND, T0 + 14 * SECOND + 9) == T0 + 14 * SECOND
