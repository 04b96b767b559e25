"""The watchdog: a process that is told of the control loop's turns, and a base that it stops.

How soon it does is tried in tests/latency."""

import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from other_half import slam_pose

from hil_sim.driving.link import free_port
from hil_sim.driving.robot_wire import RobotWire
from runtime import guard
from runtime.core.types import Pose
from runtime.guard import BLIND_S, LEAST_S, LONGEST_S, REST_S, SILENCE_S, Rest, place
from runtime.robot import wire
from runtime.robot.pulse import orders
from runtime.robot.session import BusConfig, TopicsConfig, open_session

PATIENCE_S = 30.0


@given(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.floats(-3.1, 3.1), st.text(max_size=9))
def test_a_place_is_read_as_the_runtime_reads_it(x_m, y_m, yaw_rad, frame):
    payload = wire.encode_odometry(Pose(x_m, y_m, yaw_rad), 5)
    told = wire.decode(payload, wire.ODOMETRY, "odom")
    told.header.frame_id = told.child_frame_id = frame.replace("\0", "")
    at = told.pose.pose
    q = at.orientation
    where = place(wire.encode(told), child=True)
    assert where == (at.position.x, at.position.y, 0.0, q.x, q.y, q.z, q.w)


def test_a_slam_pose_is_read_too():
    payload = slam_pose(Pose(1.0, 2.0, 0.0), 7)
    assert place(payload, child=False)[:2] == (1.0, 2.0)


@given(st.binary(max_size=200), st.booleans())
def test_whatever_comes_is_read_or_refused(payload, child):
    with suppress(struct.error, IndexError):
        assert len(place(payload, child)) == 7


HERE, THERE = (0.0,) * 6 + (1.0,), (1.0,) + (0.0,) * 5 + (1.0,)


def test_zeros_end_when_the_base_is_at_rest_and_not_before():
    rest = Rest()
    for n in range(40):
        now_s = 10.0 + 0.05 * n
        rest.note(HERE if n >= 20 else (0.1 * n, *HERE[1:]), now_s)
        began_s = 10.0
        assert rest.over(now_s, now_s - began_s) == (now_s >= 11.0 + REST_S - 1e-9)


def test_zeros_end_though_nothing_is_known_of_the_base_or_it_does_not_obey():
    rest = Rest()
    assert not rest.over(10.0, BLIND_S - 0.01)
    assert rest.over(10.0, BLIND_S)
    for n in range(300):
        now_s = 10.0 + 0.05 * n
        rest.note((0.1 * n, *HERE[1:]), now_s)
        assert rest.over(now_s, now_s - 10.0) == (now_s - 10.0 >= LONGEST_S)
    still = Rest()
    still.note(HERE, 0.0)
    still.note(HERE, 9.9)
    assert not still.over(10.0, LEAST_S - 0.01)
    assert still.over(10.0, LEAST_S)


class Base:
    """What hears zeros."""

    def __init__(self) -> None:
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.session: Any = open_session(BusConfig(listen=(self.endpoint,)))
        self.heard: list[float] = []
        self.session.declare_subscriber("cmd_vel", self._obey)
        self.bus = BusConfig(connect=(self.endpoint,))

    def _obey(self, sample: Any) -> None:
        assert wire.decode_twist(sample.payload.to_bytes(), "cmd_vel") == (0.0, 0.0)
        self.heard.append(time.monotonic())

    def quiet(self) -> bool:
        """Whether nothing was commanded for four times as long as is between two zeros."""
        heard = len(self.heard)
        time.sleep(4 * guard.AGAIN_S)
        return len(self.heard) == heard


@pytest.fixture
def base() -> Iterator[Base]:
    base = Base()
    yield base
    base.session.close()


@contextmanager
def guarded(base: Base) -> Iterator[tuple[socket.socket, subprocess.Popen[bytes]]]:
    """A guard that is ready, and this side of its link."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    words = [sys.executable, "-m", "runtime.guard", "--fd", str(theirs.fileno())]
    process = subprocess.Popen(words, pass_fds=(theirs.fileno(),), stderr=subprocess.PIPE)
    theirs.close()
    ours.settimeout(PATIENCE_S)
    ours.send(orders(base.bus).told())
    assert ours.recv(99) == guard.READY
    time.sleep(0.5)  # a link of Zenoh's loses what is sent in its first moments
    try:
        yield ours, process
    finally:
        ours.close()
        process.kill()
        process.communicate()


def until(what: Any) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.01)


def test_a_pulse_that_stops_while_the_base_moves_is_zero_and_one_that_goes_on_ends_that(base):
    with guarded(base) as (link, process):
        for _ in range(10):
            link.send(guard.MOVING)
            time.sleep(SILENCE_S / 8)
        until(lambda: base.heard)
        link.send(guard.STILL)
        until(base.quiet)
        assert process.poll() is None


def test_a_pulse_that_stops_while_the_base_stands_is_nothing(base):
    with guarded(base) as (link, _):
        link.send(guard.MOVING)
        link.send(guard.STILL)
        time.sleep(5 * SILENCE_S)
        assert base.heard == []


def test_a_runtime_that_is_gone_is_zero_until_there_is_enough_then_the_guard_ends(base):
    with guarded(base) as (link, process):
        link.send(guard.MOVING)
        link.close()
        _, said = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    assert b"the control loop ended: zero is commanded" in said
    assert base.heard[-1] - base.heard[0] >= LEAST_S


def test_a_base_that_is_at_rest_is_not_told_any_longer(base):
    ended = threading.Event()

    def tell() -> None:
        while not ended.wait(0.02):
            base.session.put("odom", wire.encode_odometry(Pose(1.0, 2.0, 0.3), time.time_ns()))

    teller = threading.Thread(target=tell)
    with guarded(base) as (link, process):
        teller.start()
        link.send(guard.MOVING)
        link.close()
        process.communicate(timeout=PATIENCE_S)
        ended.set()
        teller.join()
    assert len(base.heard) < BLIND_S / guard.AGAIN_S / 1.5


def test_a_hand_on_the_sticks_is_not_talked_over(base):
    with guarded(base) as (link, _):
        ended = threading.Event()

        def steer() -> None:
            while not ended.wait(0.02):
                base.session.put("cmd_vel_teleop", wire.encode_twist(0.2, 0.0))

        hand = threading.Thread(target=steer)
        hand.start()
        time.sleep(0.3)
        link.send(guard.MOVING)
        time.sleep(5 * SILENCE_S)
        ended.set()
        hand.join()
        assert base.heard == []
        until(lambda: base.heard)  # the hand has let go, and nobody else drives


def test_a_runtime_that_ends_properly_ends_its_guard_without_a_word(base):
    with guarded(base) as (link, process):
        link.send(guard.MOVING)
        link.send(guard.BYE)
        _, said = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, said, base.heard) == (0, b"", [])


def test_who_ends_all_of_a_group_does_not_end_the_guard(base):
    with guarded(base) as (link, process):
        for name in (signal.SIGTERM, signal.SIGINT):
            os.kill(process.pid, name)
        link.send(guard.MOVING)
        until(lambda: base.heard)


def test_orders_that_are_none_are_said(base):
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    said: list[str] = []
    with ours, theirs:
        ours.send(b'{"session": 3}')
        guard.watch(theirs, said.append)
    assert said[0].startswith("rfnav guard: cannot guard: ")


def test_a_guard_of_its_own_serves_one_runtime_after_the_other(base, tmp_path: Path):
    path = tmp_path / "run" / "guard"
    words = [sys.executable, "-m", "runtime.guard", "--socket", str(path)]
    process = subprocess.Popen(words, stderr=subprocess.DEVNULL)
    try:
        for n in range(2):
            until(path.exists)
            with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as link:
                until(lambda link=link: link.connect_ex(str(path)) == 0)
                link.settimeout(PATIENCE_S)
                link.send(orders(base.bus).told())
                assert link.recv(99) == guard.READY
                time.sleep(0.5)
                link.send(guard.MOVING)
                heard = len(base.heard)
                until(lambda heard=heard: len(base.heard) > heard)
                if n:
                    link.send(guard.BYE)
        assert path.stat().st_mode & 0o777 == 0o600
        assert process.poll() is None
    finally:
        process.kill()
        process.wait()


def test_who_is_met_at_the_runtimes_port_meets_its_guard_at_the_next():
    told = guard.Orders.read(orders(BusConfig(listen=("tcp/127.0.0.1:7450",))).told())
    assert told.session["listen/endpoints"] == ["tcp/127.0.0.1:7451"]
    told = guard.Orders.read(orders(BusConfig()).told())
    assert told.session["listen/endpoints"] == ["tcp/127.0.0.1:7448"]


def test_what_the_guard_is_told_is_of_the_bus_and_it_listens_nowhere():
    topics = TopicsConfig(pose="slam", teleop="")
    bus = BusConfig(listen=("tcp/127.0.0.1:1",), connect=("tcp/127.0.0.1:2",), prefix="r1",
                    cmd_vel_type="TwistStamped", topics=topics)  # fmt: skip
    told = guard.Orders.read(orders(bus).told())
    assert told.session["listen/endpoints"] == []
    assert told.session["connect/endpoints"] == ["tcp/127.0.0.1:2"]
    assert (told.cmd_vel, told.odom, told.teleop) == ("r1/cmd_vel", "r1/slam", "")
    assert not told.child
    zero = wire.decode(bytes.fromhex(told.zero), wire.TWIST_STAMPED, "cmd_vel")
    assert zero.twist.linear.x == zero.twist.angular.z == zero.header.stamp.sec == 0


def test_zero_is_commanded_as_nodes_of_rmw_zenoh_read_it():
    """With what goes along with it, and by somebody whom they see."""
    robot, endpoint = RobotWire("rmw_zenoh"), f"tcp/127.0.0.1:{free_port()}"
    session: Any = open_session(BusConfig(listen=(endpoint,)))
    zeros: list[tuple[Any, ...]] = []

    def obey(sample: Any) -> None:
        assert wire.decode_twist(sample.payload.to_bytes(), "cmd_vel") == (0.0, 0.0)
        zeros.append(struct.unpack("<qqB16s", sample.attachment.to_bytes()))

    session.declare_subscriber(robot.key("cmd_vel"), obey)
    seen: list[str] = []
    session.liveliness().declare_subscriber(
        "@ros2_lv/0/**", lambda sample: seen.append(str(sample.key_expr))
    )
    base = SimpleNamespace(bus=BusConfig(connect=(endpoint,), dialect="rmw_zenoh"))
    with guarded(base) as (link, _):  # type: ignore[arg-type]
        link.send(guard.MOVING)
        until(lambda: len(zeros) > 3)
        link.send(guard.BYE)
    numbers = [number for number, *_ in zeros]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert len({(length, gid) for *_, length, gid in zeros}) == 1
    assert zeros[0][2] == 16
    kinds = {key.split("/")[5]: key for key in seen}
    assert set(kinds) == {"NN", "MP", "MS"}
    assert "/rfnav_guard/%cmd_vel/geometry_msgs::msg::dds_::Twist_/" in kinds["MP"]
    assert "{" not in kinds["MP"]
    session.close()


def test_behind_the_bridge_nothing_goes_along_with_zero():
    told = guard.Orders.read(orders(BusConfig()).told())
    assert (told.gid, told.tokens) == ("", [])
