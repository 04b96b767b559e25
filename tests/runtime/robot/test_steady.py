"""Odometry that no robot can have driven to is not used, unless it stays there."""

import math

from hypothesis import given
from hypothesis import strategies as st

from runtime.core.types import Pose
from runtime.robot.steady import FASTEST_MPS, SLACK_M, STEADY_S, SteadyOdometry

HERE = Pose(1.0, 2.0, 0.3)


@given(
    st.lists(
        st.tuples(st.floats(0.005, 1.0), st.floats(-1.5, 1.5), st.floats(-2.0, 2.0)), max_size=60
    )
)
def test_all_of_a_robot_that_drives_is_used(steps: list[tuple[float, float, float]]):
    steady, now_s, x, yaw = SteadyOdometry(), 0.0, 0.0, 0.0
    assert steady.takes(Pose(x, 0.0, yaw), now_s)
    for dt_s, v_mps, w_radps in steps:
        now_s, x, yaw = now_s + dt_s, x + v_mps * dt_s, yaw + w_radps * dt_s
        assert steady.takes(Pose(x, 0.0, math.remainder(yaw, math.tau)), now_s)


def test_single_messages_from_elsewhere_are_not_and_those_between_are():
    steady = SteadyOdometry()
    for n in range(200):
        assert steady.takes(HERE, 0.02 * n)
        assert not steady.takes(Pose(1000.0, 2.0, 0.3), 0.02 * n + 0.004)
        assert not steady.takes(Pose(1.0, 2.0, -2.8), 0.02 * n + 0.008)


def test_what_stays_elsewhere_is_there():
    steady = SteadyOdometry()
    assert steady.takes(HERE, 0.0)
    there = Pose(6.0, 2.0, 0.3)
    taken = [steady.takes(there, 0.1 + 0.05 * n) for n in range(40)]
    assert taken.index(True) == round(STEADY_S / 0.05)
    assert all(taken[taken.index(True) :])
    assert not steady.takes(HERE, 2.2)


def test_what_jumps_about_is_nowhere():
    steady = SteadyOdometry()
    assert steady.takes(HERE, 0.0)
    assert not any(steady.takes(Pose(50.0 + 3.0 * (n % 2), 2.0, 0.3), 0.05 * n) for n in range(99))


def test_many_small_steps_come_no_farther_than_is_driven():
    steady, x, n = SteadyOdometry(), 0.0, 0
    assert steady.takes(Pose(x, 0.0, 0.0), 0.0)
    while steady.takes(Pose(x + 0.2, 0.0, 0.0), 0.004 * (n + 1)):  # 50 m/s
        x, n = x + 0.2, n + 1
    assert x <= SLACK_M + FASTEST_MPS * 0.004 * (n + 1)


def test_after_a_gap_a_robot_may_be_elsewhere_but_not_anywhere():
    steady = SteadyOdometry()
    assert steady.takes(HERE, 0.0)
    assert steady.takes(Pose(4.0, 2.0, 0.3), 60.0)
    assert not steady.takes(Pose(40.0, 2.0, 0.3), 120.0)
