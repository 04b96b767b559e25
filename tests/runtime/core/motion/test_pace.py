"""How often odometry comes, and what follows for a robot that drives by it."""

import math

import pytest

from runtime.core.motion.pace import BETWEEN_M, BETWEEN_RAD, LONGEST_S, Pace, driven
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
