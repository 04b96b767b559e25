"""How often odometry comes, and what follows for a robot that drives by it."""

import math
from dataclasses import astuple

import pytest

from runtime.core.motion.pace import BETWEEN_M, BETWEEN_RAD, BRISK_S, LONGEST_S, Pace, driven
from runtime.core.types import Pose, Twist


def pace(*intervals_s: float) -> Pace:
    made, now_s = Pace(), 100.0
    made.note(now_s)
    for interval_s in intervals_s:
        now_s += interval_s
        made.note(now_s)
    return made


def test_at_20_hz_nothing_is_another():
    usual = pace(*[0.05] * 20)
    twist, pose = Twist(0.9, 1.5), Pose(1.0, 2.0, 0.5)
    assert usual.patience_s(0.3) == 0.3
    assert usual.allowed(twist) is twist
    assert usual.here(pose, twist, 0.05) is pose


def test_at_3_hz_the_next_message_is_waited_for_and_the_robot_is_slower():
    slow = pace(*[1 / 3] * 9)
    assert slow.patience_s(0.3) == pytest.approx(0.6)
    allowed = slow.allowed(Twist(0.6, 0.3))
    assert allowed.v_mps / 3 == pytest.approx(BETWEEN_M)
    assert allowed.w_radps / allowed.v_mps == pytest.approx(0.5)  # on the same arc
    assert slow.allowed(Twist(0.0, -2.0)).w_radps / 3 == pytest.approx(-BETWEEN_RAD)
    still = Twist(0.0, 0.0)
    assert slow.allowed(still) == still


def test_what_comes_more_seldom_is_not_waited_for_longer():
    assert pace(*[0.6] * 20).patience_s(0.3) == LONGEST_S
    assert pace(*[2.0] * 20).patience_s(0.3) == 0.3  # that is no rate


def test_an_outage_or_two_do_not_make_it_slow():
    assert pace(*[0.05] * 9, 0.5, 0.5, 0.5).patience_s(0.3) == 0.3
    assert pace(0.4).patience_s(0.3) == 0.3  # too few to know


def test_between_two_messages_the_robot_is_where_its_command_has_led_it():
    slow, pose = pace(*[1 / 3] * 9), Pose(1.0, 0.0, math.pi / 2)
    ahead = slow.here(pose, Twist(0.3, 0.0), 0.2)
    assert (ahead.x_m, ahead.y_m) == pytest.approx((1.0, 0.06))
    far = slow.here(pose, Twist(0.3, 0.0), 9.0)
    assert far.y_m == pytest.approx(0.3 * LONGEST_S)


def test_an_arc_ends_where_its_circle_is():
    end = driven(Pose(0.0, 0.0, 0.0), Twist(math.pi / 2, math.pi / 2), 1.0)  # a quarter, radius 1
    assert (end.x_m, end.y_m, end.yaw_rad) == pytest.approx((1.0, 1.0, math.pi / 2))
    back = driven(Pose(0.0, 0.0, math.pi), Twist(-0.5, 0.0), 1.0)
    assert (back.x_m, back.y_m) == pytest.approx((0.5, 0.0))


# -- to the number ---------------------------------------------------------------------------------


def to_and_fro(interval_s: float, count: int = 9) -> Pace:
    """Intervals of just that, which none is that is the difference of two times."""
    made = Pace()
    for _ in range(count):
        made.note(0.0)
        made.note(interval_s)
    return made


def test_four_intervals_are_enough_to_know_and_three_are_not():
    assert pace(0.5, 0.5, 0.5).period_s == 0.0
    assert pace(0.5, 0.5, 0.5, 0.5).period_s == 0.5


def test_what_comes_at_one_time_or_after_too_long_is_no_interval():
    assert pace(*[0.5, 0.0] * 6).period_s == 0.5
    assert to_and_fro(LONGEST_S).period_s == LONGEST_S
    assert to_and_fro(LONGEST_S + 1e-9).period_s == 0.0


def test_just_brisk_is_brisk():
    brisk, twist, pose = to_and_fro(BRISK_S), Twist(0.9, 1.5), Pose(1.0, 2.0, 0.5)
    assert brisk.allowed(twist) is twist
    assert brisk.here(pose, twist, 0.1) is pose
    slower = to_and_fro(BRISK_S + 1e-6)
    assert slower.allowed(twist) != twist
    assert slower.here(pose, twist, 0.1) != pose


def test_what_is_slow_enough_stays_as_it_is():
    slow = pace(*[0.5] * 9)
    for twist in (Twist(0.2, 0.5), Twist(-0.2, -0.5), Twist(0.1, 0.0), Twist(0.0, 0.1)):
        assert slow.allowed(twist) is twist
    assert astuple(slow.allowed(Twist(-0.4, 0.1))) == pytest.approx((-0.2, 0.05))
    assert astuple(slow.allowed(Twist(0.4, 2.0))) == pytest.approx((0.1, 0.5))  # by the stricter


def test_nobody_is_where_he_was_before():
    slow, pose = pace(*[0.5] * 9), Pose(1.0, 2.0, 0.5)
    assert slow.here(pose, Twist(0.3, 0.2), -1.0) == pose


def test_an_arc_begins_where_the_robot_looks():
    end = driven(Pose(1.0, 2.0, 3.0), Twist(0.5, -0.5), 2.0)  # radius 1, to the right
    x = 1.0 + math.sin(3.0) - math.sin(2.0)
    y = 2.0 - math.cos(3.0) + math.cos(2.0)
    assert (end.x_m, end.y_m, end.yaw_rad) == pytest.approx((x, y, 2.0))
    on = driven(Pose(0.0, 0.0, 3.0), Twist(0.0, 1.0), 1.0)
    assert astuple(on) == pytest.approx((0.0, 0.0, 4.0 - math.tau))


def test_of_many_intervals_the_last_nine_count():
    assert pace(*[0.5] * 40, *[0.25] * 5).period_s == 0.25
    assert pace(*[0.5] * 40, *[0.25] * 4).period_s == 0.5
