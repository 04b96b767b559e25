"""The bus as a base, and odometry that comes to it by another wire."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest
from manual_clock import ManualClock
from places import ROOT

from hil_sim.driving.link import free_port
from runtime.clock import SystemClock
from runtime.core.motion.caution import FREE
from runtime.core.settings import NavigateConfig
from runtime.core.types import Pose, Twist
from runtime.errors import BusError
from runtime.robot import wire
from runtime.robot.base import ORDER_S, WELL, DriveOrder, Sent
from runtime.robot.bus import Bus, BusConfig
from runtime.robot.reflex import Reflex
from runtime.robot.session import open_session

CLOCK, PATIENCE_S = SystemClock(), 20.0
EMPTY = 0.0, 0.0


@pytest.fixture
def heard() -> Iterator[tuple[Bus, list[tuple[float, float]]]]:
    """A bus that takes no odometry from the wire, and what is heard on cmd_vel."""
    endpoint, heard = f"tcp/127.0.0.1:{free_port()}", []
    session: Any = open_session(BusConfig(listen=(endpoint,)))
    session.declare_subscriber(
        "cmd_vel", lambda s: heard.append(wire.decode_twist(s.payload.to_bytes(), "cmd_vel"))
    )
    bus = Bus(BusConfig(connect=(endpoint,)), CLOCK, odometry=False)
    by_s = time.monotonic() + PATIENCE_S
    while not heard:  # the first moments of a link lose what is sent
        assert time.monotonic() < by_s
        bus.drive(order(Twist()))
        time.sleep(0.01)
    yield bus, heard
    bus.close()
    with suppress(BusError):
        session.close()


def order(twist: Twist, worth_s: float = ORDER_S) -> DriveOrder:
    return DriveOrder(twist, 0, CLOCK.now_s() + worth_s)


def test_an_order_in_time_is_sent_and_one_that_is_late_is_not(heard):
    bus, twists = heard
    assert bus.drive(order(Twist(0.2, 0.1))) == Sent(Twist(0.2, 0.1))
    late = bus.drive(order(Twist(0.4, 0.1), worth_s=-0.1))
    assert (late.twist, late.why[:14]) == (None, "the order came")
    assert bus.drive(order(Twist(0.3, 0.1))) == Sent(Twist(0.3, 0.1))
    by_s = time.monotonic() + PATIENCE_S
    while twists[-1] != (0.3, 0.1):
        assert time.monotonic() < by_s
        time.sleep(0.01)
    assert [t for t in twists if t != EMPTY] == [(0.2, 0.1), (0.3, 0.1)]
    assert bus.condition() == WELL


LISTENS = """
import sys, time
from runtime.robot.session import BusConfig, open_session
session = open_session(BusConfig(listen=(sys.argv[1],)))
session.declare_subscriber("**", lambda sample: print(sample.key_expr, flush=True))
time.sleep(600)
"""


def test_a_wire_that_is_full_holds_up_no_order():
    """The other side of the link stands still, and takes nothing."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    other = subprocess.Popen(
        [sys.executable, "-c", LISTENS, endpoint], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert other.stdout is not None
    bus = Bus(BusConfig(connect=(endpoint,)), CLOCK)
    arrived = threading.Thread(target=other.stdout.readline)
    arrived.start()
    try:
        by_s = time.monotonic() + PATIENCE_S
        while arrived.is_alive():
            assert time.monotonic() < by_s
            bus.drive(order(Twist()))
            time.sleep(0.01)
        os.kill(other.pid, signal.SIGSTOP)
        for _ in range(40):
            bus.publish_state({"ballast": "a" * 1_000_000})

        def drive() -> None:
            for _ in range(5):
                assert bus.drive(order(Twist(0.1, 0.0))).twist is not None

        driving = threading.Thread(target=drive, daemon=True)
        driving.start()
        driving.join(3.0)  # a message that waits does so for 5 s, then the link is closed
        assert not driving.is_alive()
    finally:
        other.kill()
        other.communicate()
        bus.close()


def test_the_last_order_comes_after_all_before_it(heard):
    bus, twists = heard
    for n in range(1, 50):
        bus.drive(order(Twist(n / 100, 0.3)))
    bus.drive(DriveOrder(Twist(), 0, math.inf, last=True))
    by_s = time.monotonic() + PATIENCE_S
    while (0.01, 0.3) not in twists or twists[-1] != EMPTY:
        assert time.monotonic() < by_s
        time.sleep(0.01)
    time.sleep(0.2)  # nothing comes after it
    assert twists[-1] == EMPTY
    told = [t for t in twists if t != EMPTY]  # so soon after each other some may be dropped
    assert told == sorted(told)


def test_odometry_by_another_wire_is_as_if_it_had_come_over_the_bus(heard):
    bus, _ = heard
    assert bus.pose() is None
    bus.file_odometry(Pose(1.0, 2.0, 0.5), 123_000_000_000)
    newest = bus.pose()
    assert newest is not None
    assert newest[0].stamp_ns == 123_000_000_000
    assert newest[0].value.x_m == 1.0
    assert newest[0].value.yaw_rad == pytest.approx(0.5)
    assert bus.health()["odom"].received == 1


def test_what_is_near_is_held_against_where_the_base_is_by_now(monkeypatch):
    """Where odometry comes seldom, that is not where it was told last."""
    asked: list[Pose | None] = []
    look = lambda self, twist, pose: asked.append(pose) or FREE  # noqa: E731
    monkeypatch.setattr(Reflex, "caution", look)
    clock, ahead = ManualClock(100.0), Twist(0.25, 0.0)
    with Bus(BusConfig(), clock, odometry=False, reflex=NavigateConfig()) as bus:
        assert (bus.caution(ahead), asked) == (FREE, [None])
        for n in range(8):
            bus.file_odometry(Pose(0.1 * n, 0.0, 0.0), round(clock.now_s() * 1e9))
            clock.advance(0.4)
        bus.doubt(ahead)
        bus.caution(ahead)
        assert asked[-1] is not None
        assert asked[-1].x_m == pytest.approx(0.8)
