"""The watchdog turn by turn, on a clock of its own and a bus that nobody else is on. As a process:
test_guard.py."""

import json
import os
import signal
import socket
import struct
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import zenoh

from runtime import guard
from runtime.core.types import Pose
from runtime.guard import (
    AGAIN_S,
    BLIND_S,
    BYE,
    HAND_S,
    LEAST_S,
    LONGEST_S,
    LOOK_S,
    MOVING,
    READY,
    REST_M,
    REST_S,
    REST_SHARE,
    SILENCE_S,
    STILL,
    Rest,
    place,
)
from runtime.robot import wire

ORDERS = guard.Orders(
    {"mode": "peer", "listen/endpoints": ["tcp/127.0.0.1:1"]}, "r1/cmd_vel", "00ff", "r1/odom",
    "r1/cmd_vel_teleop", True, "", [],
)  # fmt: skip
ZERO = b"\x00\xff"


class World:
    """Time, the bus, and a runtime that says what a test has it say."""

    def __init__(self) -> None:
        self.now_s = Fraction(100)  # so that what is just so long is
        self.peers, self.routers = [1], list[int]()  # who else is on the bus
        self.heard: dict[str, Any] = {}
        self.zeros: list[float] = []
        self.attached: list[bytes | None] = []
        self.tokens: list[str] = []
        self.how: dict[str, Any] = {}
        self.config: Any = None
        self.broken = False
        self.closed = 0
        self.turns: Iterator[Any] = iter(())
        self.timeout: float | None = -1.0
        self.waited: list[float | None] = []
        self.sent: list[bytes] = []
        self.said: list[str] = []
        peers = SimpleNamespace(peers_zid=lambda: self.peers, routers_zid=lambda: self.routers)
        self.info = peers

    # -- time

    def monotonic(self) -> Fraction:
        return self.now_s

    def time_ns(self) -> int:
        return int(self.now_s * 10**9)

    def sleep(self, seconds: float) -> None:
        self.now_s += Fraction(str(seconds))

    # -- a session

    def open(self, config: Any) -> "World":
        self.config = config
        return self

    def declare_publisher(self, key: str, **how: Any) -> "World":
        self.how = {"key": key, **how}
        return self

    def declare_subscriber(self, key: str, take: Any) -> None:
        self.heard[key] = take

    def zid(self) -> str:
        return "f00"

    def liveliness(self) -> "World":
        return self

    def declare_token(self, token: str) -> str:
        self.tokens.append(token)
        return token

    def put(self, payload: bytes, attachment: bytes | None) -> None:
        assert payload == ZERO
        self.attached.append(attachment)
        self.zeros.append(float(self.now_s - 100))
        if self.broken:
            raise zenoh.ZError("no link")

    def close(self) -> None:
        self.closed += 1
        if self.broken:
            raise zenoh.ZError("no link")

    # -- a link

    def settimeout(self, seconds: float | None) -> None:
        self.timeout = seconds

    def recv(self, most: int) -> bytes:
        """None is silence, a function what happens before the next; at the end it is gone."""
        assert most == 1 << 16
        self.waited.append(self.timeout)
        for turn in self.turns:
            if callable(turn):
                turn()
            elif isinstance(turn, Exception):
                raise turn
            elif turn is not None:
                return bytes(turn)
            elif self.timeout is not None:  # else nobody minds
                self.sleep(self.timeout)
                raise TimeoutError
        return b""

    def send(self, payload: bytes) -> None:
        self.sent.append(payload)

    # -- a test

    def watch(self, *turns: Any, orders: guard.Orders = ORDERS) -> None:
        self.turns = iter((orders.told(), *turns))
        guard.watch(self, self.said.append)

    def moves(self, x_m: float = 0.0) -> None:
        self.hears("r1/odom", wire.encode_odometry(Pose(x_m, 0.0, 0.0), 1))

    def hears(self, key: str, payload: bytes = b"") -> None:
        told = SimpleNamespace(payload=SimpleNamespace(to_bytes=lambda: payload))
        self.heard[key](told)


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> World:
    made = World()
    monkeypatch.setattr(guard, "time", made)
    monkeypatch.setattr(guard.zenoh, "open", made.open)
    return made


SILENT = "rfnav guard: the control loop gave no sign for 0.2 s: zero is commanded"
ENDED = "rfnav guard: the control loop ended: zero is commanded"
ENOUGH, GOES_ON = "rfnav guard: enough of zero", "rfnav guard: it goes on"


def every(first_s: float, end_s: float, step_s: float = AGAIN_S) -> list[float]:
    """Seconds from `first_s` until just before `end_s`."""
    return [round(first_s + step_s * n, 6) for n in range(round((end_s - first_s) / step_s))]


def test_credentials_are_where_systemd_put_its_own(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", "/run/credentials/guard")
    ca = "transport/link/tls/root_ca_certificate"
    told = {**ORDERS.session, ca: "$CREDENTIALS_DIRECTORY/ca.pem"}
    guard.Brake(replace(ORDERS, session=told))
    assert json.loads(world.config.get_json(ca)) == "/run/credentials/guard/ca.pem"


def test_it_is_a_session_of_its_own_that_speaks_before_all_and_holds_up_nothing(world: World):
    world.watch(BYE)
    assert json.loads(world.config.get_json("listen/endpoints")) == ["tcp/127.0.0.1:1"]
    assert json.loads(world.config.get_json("mode")) == "peer"
    assert world.how == {
        "key": "r1/cmd_vel",
        "congestion_control": zenoh.CongestionControl.DROP,
        "priority": zenoh.Priority.INTERACTIVE_HIGH,
        "express": True,
    }
    assert set(world.heard) == {"r1/odom", "r1/cmd_vel_teleop"}
    assert (world.closed, world.said, world.zeros) == (1, [], [])


def test_what_it_has_no_key_of_it_does_not_listen_to(world: World):
    orders = guard.Orders({}, "cmd_vel", "00ff", "", "", True, "", [])
    world.watch(BYE, orders=orders)
    assert world.heard == {}


def test_where_messages_tell_no_source_zeros_do_not_either(world: World):
    world.watch(MOVING, None, BYE)
    assert (world.attached, world.tokens) == ([None], [])


def test_where_they_do_zeros_are_numbered_and_say_by_whom_and_when(world: World):
    gid, tokens = "0123456789abcdef" * 2, ["@ros2_lv/0/{zid}/0/0/NN", "@ros2_lv/0/{zid}/0/1/MP"]
    world.watch(MOVING, None, None, BYE, orders=replace(ORDERS, gid=gid, tokens=tokens))
    first_ns = 100_200_000_000
    assert [struct.unpack("<qqB16s", told or b"") for told in world.attached] == [
        (1, first_ns, 16, bytes.fromhex(gid)),
        (2, first_ns + 50_000_000, 16, bytes.fromhex(gid)),
    ]
    assert world.tokens == ["@ros2_lv/0/f00/0/0/NN", "@ros2_lv/0/f00/0/1/MP"]


@pytest.mark.parametrize("told", [b"", BYE])
def test_without_orders_nothing_is_opened(world: World, told: bytes):
    world.turns = iter((told,))
    guard.watch(world, world.said.append)
    assert (world.config, world.said, world.waited) == (None, [], [None])


def test_it_is_ready_once_when_it_reaches_somebody_and_waits_no_longer_than_it_has_to(world):
    world.peers = []
    appear = lambda: world.routers.append(1)  # noqa: E731
    world.watch(None, STILL, appear, None, STILL, STILL, MOVING, MOVING, STILL, BYE)
    assert world.sent == [READY]
    assert world.waited == [None, *[LOOK_S] * 3, *[None] * 3, *[SILENCE_S] * 2, None]
    assert world.zeros == []


def test_a_link_that_breaks_when_it_is_told_to_be_ready_is_none(world: World):
    def broken(payload: bytes) -> None:
        raise OSError

    world.send = broken  # type: ignore[method-assign]
    world.watch(MOVING, BYE)
    assert world.zeros == []


def test_without_odometry_it_is_zero_for_a_while_and_then_it_waits_for_the_next_turn(world):
    world.watch(MOVING, *[None] * 41, STILL, BYE)
    assert world.zeros == every(SILENCE_S, SILENCE_S + BLIND_S)
    assert world.said == [SILENT, ENOUGH]
    assert world.waited[2:4] == [SILENCE_S, AGAIN_S]
    assert world.waited[-2:] == [None, None]  # the base stands: no turn is due


@pytest.mark.parametrize(("turn", "then"), [(MOVING, SILENCE_S), (STILL, None)])
def test_a_control_loop_that_goes_on_ends_that(world: World, turn: bytes, then: float | None):
    world.watch(MOVING, None, None, None, turn, BYE)
    assert world.zeros == every(SILENCE_S, SILENCE_S + 3 * AGAIN_S)
    assert world.said == [SILENT, GOES_ON]
    assert world.waited[-1] == then


def test_one_that_ends_properly_after_a_silence_ends_its_guard(world: World):
    world.watch(MOVING, None, None, BYE, MOVING, None)
    assert world.zeros == every(SILENCE_S, SILENCE_S + 2 * AGAIN_S)
    assert world.said == [SILENT, GOES_ON]
    assert world.closed == 1


@pytest.mark.parametrize("end", [b"", OSError("reset")])
def test_a_runtime_that_is_gone_while_the_base_moves_is_zero_until_there_is_enough(world, end):
    world.watch(MOVING, end)
    assert world.zeros == every(0.0, BLIND_S)
    assert world.said == [ENDED, ENOUGH]
    assert world.closed == 1


def test_a_runtime_that_is_gone_while_the_base_stands_is_nothing(world: World):
    world.watch(MOVING, STILL)
    assert (world.zeros, world.said, world.closed) == ([], [], 1)


def test_what_nobody_says_to_a_guard_is_no_turn(world: World):
    world.watch(MOVING, b"what", BYE)
    assert world.zeros[0] == 0.0
    assert world.said[0] == SILENT


def test_a_base_that_its_odometry_tells_at_rest_is_told_no_longer(world: World):
    """0.3 s of the same place; and no less than half a second of zeros."""
    turns: list[Any] = [MOVING]
    for n in range(30):
        turns += [lambda n=n: world.moves(0.1 * min(n, 8)), None]
    world.watch(*turns, orders=ORDERS)
    came_to_rest_s = SILENCE_S + 7 * AGAIN_S
    assert world.zeros == every(SILENCE_S, came_to_rest_s + REST_S)
    assert world.said == [SILENT, ENOUGH]


def test_what_is_no_odometry_tells_nothing(world: World):
    junk = b"", b"\x00\x01", b"\x00\x01\x00\x00" + 99 * b"\xff"
    turns = [lambda payload=payload: world.hears("r1/odom", payload) for payload in junk]
    world.watch(MOVING, *turns, None)
    assert len(world.zeros) == round(BLIND_S / AGAIN_S)


def test_odometry_is_read_as_what_it_is_told_to_be(world: World, monkeypatch):
    noted: list[Any] = []
    monkeypatch.setattr(Rest, "note", lambda rest, where, now_s: noted.append((where, now_s)))
    world.watch(lambda: world.moves(1.5), BYE)
    assert noted == [((1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), 100)]


def test_a_slam_s_pose_is_read_where_that_is_what_it_is_told_of(world: World):
    slam = b"\x00\x01\x00\x00" + struct.pack("<iII", 1, 2, 4) + b"map\0" + bytes(4)
    slam += struct.pack("<7d", 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    orders = guard.Orders({}, "c", "00ff", "r1/odom", "", False, "", [])
    turns: list[Any] = [MOVING]
    for _ in range(20):
        turns += [lambda: world.hears("r1/odom", slam), None]
    world.watch(*turns, orders=orders)
    assert world.zeros == every(SILENCE_S, SILENCE_S + LEAST_S)


def test_while_a_hand_speaks_it_is_silent_and_then_it_is_not(world: World):
    hand = lambda: world.hears("r1/cmd_vel_teleop")  # noqa: E731
    world.watch(MOVING, hand, None, *[None] * 40)
    spoken_until_s = HAND_S + 1e-9
    assert world.zeros == [at for at in every(0.0, SILENCE_S + BLIND_S) if at > spoken_until_s]


def test_a_link_that_stands_ends_nothing(world: World):
    world.broken = True
    world.watch(MOVING, *[None] * 41, BYE)
    assert len(world.zeros) == round(BLIND_S / AGAIN_S)
    assert world.closed == 1


def test_orders_that_cannot_be_kept_are_said_in_a_line(world: World, monkeypatch):
    def refused(config: Any) -> None:
        raise zenoh.ZError("no\n  way " + "x" * 400)

    monkeypatch.setattr(guard.zenoh, "open", refused)
    world.watch(MOVING)
    assert world.said == ["rfnav guard: cannot guard: " + ("no way " + "x" * 400)[:200]]
    assert world.closed == 0


def test_where_zenoh_failed_in_its_source_is_not_said(world: World, monkeypatch):
    def refused(config: Any) -> None:
        raise zenoh.ZError("nobody there!  at /src/zenoh.rs:447.")

    monkeypatch.setattr(guard.zenoh, "open", refused)
    world.watch(MOVING)
    assert world.said == ["rfnav guard: cannot guard: nobody there!"]


def test_a_mistake_closes_the_session_too(world: World):
    world.turns = iter((ORDERS.told(), MOVING, RuntimeError("mistake")))
    with pytest.raises(RuntimeError, match="mistake"):
        guard.watch(world, world.said.append)
    assert world.closed == 1


def test_orders_are_read_as_they_were_told():
    assert guard.Orders.read(ORDERS.told()) == ORDERS


# -- at rest ---------------------------------------------------------------------------------------

HERE = (0.0,) * 6 + (1.0,)


def shifted(axis: int, by: float) -> tuple[float, ...]:
    return tuple(v + by * (n == axis) for n, v in enumerate(HERE))


@pytest.mark.parametrize(
    ("axis", "most"), [(0, REST_M), (1, REST_M), (2, REST_M), (3, REST_SHARE), (5, REST_SHARE)]
)
def test_the_same_place_is_within_what_odometry_trembles_by(axis: int, most: float):
    for by, at_rest in ((most, True), (-most, True), (1.01 * most, False), (-1.01 * most, False)):
        rest = Rest()
        rest.note(HERE, 0.0)
        rest.note(shifted(axis, by), 1.0)
        assert rest.over(1.2, LEAST_S) is at_rest


def test_a_place_that_creeps_away_is_another():
    """It is held against where it was when it came to rest."""
    rest = Rest()
    rest.note(HERE, 0.0)
    rest.note(shifted(0, 0.6 * REST_M), 0.5)
    rest.note(shifted(0, 1.2 * REST_M), 1.0)
    assert not rest.over(1.2, LEAST_S)


def test_rest_is_told_by_odometry_that_speaks_and_else_by_time():
    rest = Rest()
    rest.note(HERE, 1.0)
    rest.note(HERE, 1.25)
    assert not rest.over(1.25, LEAST_S)
    assert rest.over(1.0 + REST_S, LEAST_S)
    assert not rest.over(1.25 + REST_S + 1e-6, LEAST_S)
    assert rest.over(1.25 + REST_S + 1e-6, BLIND_S)
    silent = Rest()
    silent.note(HERE, 0.0)
    assert silent.over(REST_S, LEAST_S)  # it spoke just now
    moving = Rest()
    moving.note(HERE, 5.0)
    assert not moving.over(5.1, LONGEST_S - 0.01)
    assert moving.over(5.1, LONGEST_S)


def test_a_message_of_the_other_byte_order_is_read_too():
    told = b"\x00\x00\x00\x00" + struct.pack(">iII", 1, 2, 5) + b"odom\0" + bytes(3)
    told += struct.pack(">I", 10) + b"base_link\0"
    told += bytes(-(len(told) - 4) % 8) + struct.pack(">7d", 1.0, -2.0, 3.0, 0.0, 0.0, 0.6, 0.8)
    assert place(told, child=True) == (1.0, -2.0, 3.0, 0.0, 0.0, 0.6, 0.8)


def test_a_length_beyond_all_bounds_is_no_way_back_in_a_message():
    told = b"\x00\x01\x00\x00" + bytes(8) + struct.pack("<I", 2**32 - 16) + bytes(200)
    with pytest.raises(struct.error):
        place(told, child=False)


# -- where it waits --------------------------------------------------------------------------------


def test_runtimes_that_come_to_a_socket_are_served_one_after_the_other(tmp_path: Path):
    path = tmp_path / "state" / "run" / "guard"
    for _ in range(2):  # a socket that somebody has left there is taken over
        came = guard.links(path)
        told: list[bytes] = []

        def call(told: list[bytes] = told) -> None:
            for _ in range(2):
                with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as link:
                    while link.connect_ex(str(path)) != 0:
                        pass
                    link.send(b"hello")
                    told.append(link.recv(9))

        caller = threading.Thread(target=call)
        caller.start()
        for _ in range(2):
            link = next(came)
            assert link.recv(9) == b"hello"
            assert path.stat().st_mode & 0o777 == 0o600
            link.send(b"you")
        caller.join()
        came.close()
        assert link.fileno() == -1
        assert told == [b"you", b"you"]
    assert path.parent.stat().st_mode & 0o777 == 0o700


def test_systemd_is_told_when_runtimes_can_come(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, heard = tmp_path / "guard", tmp_path / "notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(str(heard))
        systemd.settimeout(20.0)
        monkeypatch.setenv("NOTIFY_SOCKET", str(heard))
        came = guard.links(path)
        taker = threading.Thread(target=lambda: next(came), daemon=True)
        taker.start()
        assert systemd.recv(99) == b"READY=1"
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as link:
            link.connect(str(path))  # at once
            taker.join()
            came.close()


def test_a_systemd_that_reads_nothing_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(str(tmp_path / "notify"))
        systemd.settimeout(20.0)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        for _ in range(5000):
            guard.tell_systemd("WATCHDOG=1")
        assert systemd.recv(99) == b"WATCHDOG=1"
    guard.tell_systemd("WATCHDOG=1")  # nobody is there any more


class Started:
    """What `main` does to the process that it runs in."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.ignored: list[signal.Signals] = []
        self.scheduled: list[tuple[int, int, int]] = []
        self.watched: list[Any] = []
        monkeypatch.setattr(guard.signal, "signal", self.handle)
        monkeypatch.setattr(guard.os, "sched_setscheduler", self.schedule)
        monkeypatch.setattr(guard, "watch", self.watch)

    def watch(self, link: Any, say: Any) -> None:
        assert say is guard._say
        self.watched.append(link.fileno() if isinstance(link, socket.socket) else link)

    def handle(self, number: signal.Signals, how: Any) -> None:
        assert how is signal.SIG_IGN
        self.ignored.append(number)

    def schedule(self, process: int, policy: int, how: os.sched_param) -> None:
        self.scheduled.append((process, policy, how.sched_priority))
        raise PermissionError


def test_a_runtime_s_own_guard_serves_it_alone_and_is_ended_by_nobody_else(monkeypatch):
    started, (ours, theirs) = Started(monkeypatch), socket.socketpair()
    fd = theirs.detach()
    with ours:
        assert guard.main(["--fd", str(fd)]) == 0
    assert started.watched == [fd]
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(fd)  # closed afterwards
    assert started.ignored == [signal.SIGINT, signal.SIGTERM]
    assert started.scheduled == [(0, os.SCHED_FIFO, 21)]


def test_a_guard_that_waits_ends_by_sigterm(monkeypatch, tmp_path: Path):
    started, asked = Started(monkeypatch), []
    monkeypatch.setattr(guard, "links", lambda path: asked.append(path) or iter("ab"))
    assert guard.main(["--socket", str(tmp_path / "guard")]) == 0
    assert asked == [tmp_path / "guard"]
    assert started.watched == ["a", "b"]
    assert started.ignored == [signal.SIGINT]


@pytest.mark.parametrize("words", [[], ["--fd", "3", "--socket", "x"], ["--fd", "three"]])
def test_it_is_told_one_place_to_wait_at(monkeypatch, words: list[str]):
    Started(monkeypatch)
    with pytest.raises(SystemExit) as ended:
        guard.main(words)
    assert ended.value.code == 2


def test_its_help_says_what_it_is(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "120")
    with pytest.raises(SystemExit):
        guard.main(["--help"])
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == "usage: rfnav guard [-h] (--socket SOCKET | --fd FD)"
    assert "The watchdog of the control loop, in a process of its own: `rfnav guard`." in lines
    assert "--socket SOCKET wait there for `rfnav run --guard PATH`" in lines
    assert "--fd FD a runtime's own end, which `rfnav run` passes on" in lines


def test_what_it_says_is_read_at_once_or_by_nobody(monkeypatch):
    done: list[str] = []
    reader = SimpleNamespace(write=done.append, flush=lambda: done.append("flushed"))
    monkeypatch.setattr(sys, "stderr", reader)
    guard._say("zero")
    assert done == ["zero", "\n", "flushed"]

    def gone(text: str) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(sys, "stderr", SimpleNamespace(write=gone, flush=None))
    guard._say("zero")
