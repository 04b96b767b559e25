"""Odometry that no robot can have driven to is not used, unless it stays there."""

import math

import pytest
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


# -- to the number ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("to", "dt_s", "taken"),
    [
        (Pose(1.5, 2.0, 0.3), 0.0, True),  # as far as a wheel slips
        (Pose(1.51, 2.0, 0.3), 0.0, False),
        (Pose(1.0, 1.5, 0.3), 0.0, True),
        (Pose(1.0, 1.49, 0.3), 0.0, False),
        (Pose(1.3, 2.4, 0.3), 0.0, True),
        (Pose(1.4, 2.4, 0.3), 0.0, False),
        (Pose(1.99, 2.0, 0.3), 0.125, True),
        (Pose(2.01, 2.0, 0.3), 0.125, False),
        (Pose(1.0, 2.0, -0.69), 0.0, True),
        (Pose(1.0, 2.0, -0.71), 0.0, False),
        (Pose(1.0, 2.0, 2.29), 0.125, True),
        (Pose(1.0, 2.0, 2.31), 0.125, False),
        (Pose(5.49, 2.0, 0.3), 1.0, True),
        (Pose(5.49, 2.0, 0.3), 100.0, True),
        (Pose(5.51, 2.0, 0.3), 100.0, False),
        (Pose(1.5, 2.0, 0.3), -1.0, True),  # arrivals that come in another order
        (Pose(1.51, 2.0, 0.3), -1.0, False),
    ],
)
def test_how_far_a_robot_may_be_from_where_it_was(to: Pose, dt_s: float, taken: bool):
    steady = SteadyOdometry()
    assert steady.takes(HERE, 10.0)
    assert steady.takes(to, 10.0 + dt_s) is taken


def test_a_turn_is_taken_the_short_way_round():
    steady = SteadyOdometry()
    assert steady.takes(Pose(0.0, 0.0, 3.0), 10.0)
    assert steady.takes(Pose(0.0, 0.0, -3.0), 10.0)


def test_what_slipped_is_made_good_by_standing_and_what_stands_saves_up_no_more_than_that():
    steady = SteadyOdometry()
    assert steady.takes(Pose(0.0, 0.0, 0.0), 10.0)
    assert steady.takes(Pose(0.5, 0.0, 0.0), 10.0)
    assert not steady.takes(Pose(0.51, 0.0, 0.0), 10.0)
    assert steady.takes(Pose(0.5, 0.0, 0.0), 10.0625)  # 0.25 m of it
    assert not steady.takes(Pose(0.76, 0.0, 0.0), 10.0625)
    assert steady.takes(Pose(0.74, 0.0, 0.0), 10.0625)
    for n in range(20):
        assert steady.takes(Pose(0.74, 0.0, 0.0), 10.5 + n)
    assert not steady.takes(Pose(5.3, 0.0, 0.0), 29.5)


def test_the_same_holds_for_turns():
    steady = SteadyOdometry()
    assert steady.takes(Pose(0.0, 0.0, 0.0), 10.0)
    assert steady.takes(Pose(0.0, 0.0, 1.0), 10.0)
    assert not steady.takes(Pose(0.0, 0.0, 1.01), 10.0)
    assert steady.takes(Pose(0.0, 0.0, 1.0), 10.0625)
    assert not steady.takes(Pose(0.0, 0.0, 1.51), 10.0625)
    assert steady.takes(Pose(0.0, 0.0, 1.49), 10.0625)


def test_time_that_has_passed_once_does_not_pass_again():
    steady = SteadyOdometry()
    assert steady.takes(Pose(0.0, 0.0, 0.0), 10.0)
    assert steady.takes(Pose(0.5, 0.0, 0.0), 9.0)
    assert not steady.takes(Pose(0.6, 0.0, 0.0), 10.0)


def test_it_is_elsewhere_after_just_a_second_there_on_end():
    steady, there = SteadyOdometry(), Pose(50.0, 2.0, 0.3)
    assert steady.takes(HERE, 9.0)
    assert not steady.takes(there, 10.0)
    assert not steady.takes(there, 10.99)
    assert steady.takes(HERE, 10.995)  # not on end
    assert not steady.takes(there, 11.0)
    assert not steady.takes(there, 11.999)
    assert steady.takes(there, 12.0)
    assert not steady.takes(HERE, 12.01)
    assert not steady.takes(HERE, 12.5)
    assert steady.takes(HERE, 13.01)
