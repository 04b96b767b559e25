"""Odometry that comes seldom: where the base is between two messages, for what must not be hit."""

import math

import numpy as np
import pytest

from runtime.core.mapping.near_memory import Nearby
from runtime.core.motion.pace import Pace
from runtime.core.motion.reflex import cautioned
from runtime.core.types import Pose, Twist
from runtime.robot import wire
from runtime.robot.odometry import BaseOdometry
from runtime.robot.odometry_stream import GAP_S, OdometryStream
from runtime.robot.sync import RawMessage, Rings
from runtime.robot.transforms import FIXED

RADIUS_M, BRAKE_MPS2, LAG_S, STEP_S = 0.18, 0.5, 0.1, 0.01
TURN_STEPS, LOOK_STEPS, DECODED_STEPS = 5, 20, 5  # 20 turns of control and 5 images a second
WIDE = np.linspace(-0.1, 0.1, 9)


class Told:
    """A stream of odometry, and what is put into it."""

    def __init__(self) -> None:
        self.rings = Rings(0, round(GAP_S * 1e9), lockstep=False)
        told = BaseOdometry("odom", False, FIXED, lambda: None)  # type: ignore[arg-type]
        self.stream = OdometryStream(told, self.rings, lockstep=False)

    def tell(self, pose: Pose, at_s: float) -> None:
        stamp_ns = round(at_s * 1e9)
        raw = RawMessage(stamp_ns, wire.encode_odometry(pose, stamp_ns), at_s)
        if self.stream.takes(raw, at_s):
            self.rings.file("odom", raw)

    def at(self, at_s: float) -> Pose | None:
        return self.stream.at(round(at_s * 1e9), alone=True)


def straight(hz: float, count: int = 8) -> Told:
    """A base that goes ahead by 0.2 m/s."""
    told = Told()
    told.stream.sent = Twist(0.2, 0.0)
    for n in range(count):
        told.tell(Pose(0.2 * n / hz, 0.0, 0.0), n / hz)
    return told


def test_between_two_messages_that_come_seldom_the_base_goes_on_as_it_was_told():
    told, last_s = straight(3.0), 7 / 3
    for later_s in (0.0, 0.1, 0.3):
        where = pytest.approx(0.2 * (last_s + later_s))
        assert told.stream.here(last_s + later_s).x_m == where  # type: ignore[union-attr]
        assert told.at(last_s + later_s).x_m == where  # type: ignore[union-attr]
    told.stream.sent = Twist(0.0, 1.0)
    assert told.stream.here(last_s + 0.25).yaw_rad == pytest.approx(0.25)  # type: ignore[union-attr]
    assert told.at(last_s + 0.73) is None
    assert told.at(last_s - 0.1).x_m == pytest.approx(0.2 * (last_s - 0.1))  # type: ignore[union-attr]


def test_where_odometry_comes_often_the_base_is_where_it_says():
    told, last_s = straight(20.0), 7 / 20
    there = Pose(0.2 * 7 / 20, 0.0, 0.0)
    assert told.stream.here(last_s + 0.2) == told.at(last_s + 0.2) == there


def test_before_the_first_message_it_is_nowhere():
    told = Told()
    assert told.stream.here(1.0) is told.at(1.0) is None


def nearest_m(hz: float, wall_m: float) -> float:
    """How near the rim comes to a wall that every image shows, with a base that follows its orders
    a tenth of a second later and brakes as it is said to."""
    told, pace, near = Told(), Pace(), None
    x = v = 0.0
    orders, images, told_s = [0.0] * round(LAG_S / STEP_S), [], -math.inf
    for n in range(1200):
        now_s = n * STEP_S
        if now_s - told_s >= 1 / hz - 1e-9:
            told_s = now_s
            told.tell(Pose(x, 0.0, 0.0), now_s)
            pace.note(now_s)
        if n % LOOK_STEPS == 3:
            images.append((n + DECODED_STEPS, now_s, wall_m - x))
        if images and images[0][0] == n and (pose := told.at(images[0][1])) is not None:
            _, at_s, ahead_m = images.pop(0)
            points = np.stack([np.full(9, pose.x_m + ahead_m), WIDE], axis=1)
            near = Nearby(
                round(at_s * 1e9), points.astype(np.float32), np.zeros((0, 2), np.float32)
            )
        if n % TURN_STEPS == 0:
            sent, here = told.stream.sent, told.stream.here(now_s)
            twist = pace.allowed(Twist(min(0.5, sent.v_mps + 0.025), 0.0))
            if near is not None and here is not None:
                twist = cautioned(twist, here, near, RADIUS_M, BRAKE_MPS2).allowed(twist)
            told.stream.sent = twist
        orders.append(told.stream.sent.v_mps)
        v = max(orders.pop(0), v - BRAKE_MPS2 * STEP_S)
        x += v * STEP_S
    return wall_m - x - RADIUS_M


@pytest.mark.parametrize("hz", [2.5, 3.0, 4.0, 6.0, 20.0])
def test_a_wall_is_not_touched_however_seldom_odometry_comes(hz: float):
    gaps = [nearest_m(hz, 2.0 + shift) for shift in (0.0, 0.03, 0.07, 0.11, 0.16)]
    assert min(gaps) > 0.0
    assert max(gaps) < 0.05  # and it was driven up to
