"""Odometry out of an estimator's north, east, down."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mavlink_messages import attitude, heard, position
from pymavlink.dialects.v20 import common as mavlink

from runtime.core.types import Pose
from runtime.robot.mavlink.odometry import BootTime, VehicleOdometry

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
