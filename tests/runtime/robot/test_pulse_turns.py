"""What the runtime tells its watchdog turn by turn; the guard's end is in the hands of a test."""

import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest

from runtime import guard
from runtime.errors import BusError
from runtime.robot import pulse as module
from runtime.robot import wire
from runtime.robot.dialects.dialect import Qos, RosTopic
from runtime.robot.dialects.rmw_zenoh import RmwZenoh
from runtime.robot.pulse import END_S, Pulse, orders
from runtime.robot.session import BusConfig, TopicsConfig, session_settings

NOWHERE = BusConfig(connect=("tcp/127.0.0.1:9",))  # a bus that nobody else is on
PATIENCE_S = 30.0


def until(what: Callable[[], object]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.01)


class Fed:
    """A pulse after which no other guard is started, and the guard's end of its link in the hands
    of a test."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.ours, self.theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.theirs.settimeout(PATIENCE_S)
        self.told: list[str] = []
        monkeypatch.setattr(module, "_connected", lambda path: self.ours)
        self.pulse = Pulse(NOWHERE, Path("somewhere"), self.told.append, ())

    def heard(self) -> bytes:
        return self.theirs.recv(guard.LARGEST)


@pytest.fixture
def fed(monkeypatch) -> Iterator[Fed]:
    fed = Fed(monkeypatch)
    yield fed
    fed.pulse.close()
    fed.theirs.close()


def test_orders_come_first_then_each_turn_and_at_the_end_a_farewell(fed: Fed):
    assert fed.heard() == orders(NOWHERE).told()
    assert fed.ours.gettimeout() == 0.0
    assert fed.pulse.beat(True) == "the guard reaches nobody"
    assert fed.pulse.beat(False) == "the guard reaches nobody"
    fed.theirs.send(guard.READY)
    assert fed.pulse.beat(True) == ""
    assert fed.pulse.beat(False) == ""
    turns = [fed.heard() for _ in range(4)]
    assert turns == [guard.MOVING, guard.STILL, guard.MOVING, guard.STILL]
    fed.pulse.close()
    assert fed.heard() == guard.BYE
    assert fed.heard() == b""
    assert fed.pulse.beat(True) == ""
    fed.pulse.close()
    assert fed.told == []


def test_a_base_that_was_left_moving_is_not_said_to_be_at_rest(fed: Fed):
    fed.pulse.beat(True)
    fed.pulse.close()
    assert [fed.heard() for _ in range(3)] == [orders(NOWHERE).told(), guard.MOVING, b""]


def test_a_guard_that_says_something_else_has_ended(fed: Fed):
    fed.theirs.send(b"what")
    assert fed.pulse.beat(True) == "the guard has ended"
    assert fed.pulse.beat(True) == "the guard has ended"
    assert [fed.heard() for _ in range(3)][1:] == [guard.MOVING, b""]
    until(lambda: fed.told)
    once_more = "once more: no other is started; see to it, then start rfnav anew"
    assert fed.told == [f"the guard has ended {once_more}"]


def test_a_guard_that_is_gone_is_said_with_how(fed: Fed):
    fed.theirs.send(guard.READY)
    assert fed.pulse.beat(False) == ""
    assert [fed.heard() for _ in range(2)][1:] == [guard.STILL]
    fed.theirs.close()
    assert fed.pulse.beat(True) == "the guard is gone (Broken pipe)"
    assert fed.pulse.beat(True) == "the guard is gone (Broken pipe)"


def within_patience(what: Callable[[], object]) -> None:
    thread = threading.Thread(target=what, daemon=True)
    thread.start()
    thread.join(PATIENCE_S)
    assert not thread.is_alive()


def test_a_guard_that_reads_nothing_is_given_orders_no_longer_than_one_may_take(monkeypatch):
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.setblocking(False)
    with suppress(BlockingIOError):
        while ours.send(b"x"):
            pass
    monkeypatch.setattr(module, "_connected", lambda path: ours)
    monkeypatch.setattr(module, "END_S", 0.05)
    made: list[Pulse] = []
    within_patience(lambda: made.append(Pulse(NOWHERE, Path("x"), lambda line: None, ())))
    assert ours.gettimeout() == 0.0
    made[0].close()
    theirs.close()


def test_what_keeps_a_guard_there_ends_with_the_process(fed: Fed):
    assert (fed.pulse._keeper.name, fed.pulse._keeper.daemon) == ("guard", True)


def test_the_end_waits_no_longer_than_a_guard_may_take(fed: Fed, monkeypatch):
    waits: list[float] = []
    monkeypatch.setattr(fed.pulse._keeper, "join", waits.append)
    monkeypatch.setattr(module, "END_S", 0.05)
    while not fed.pulse._unread:
        fed.pulse.beat(False)  # until the link is full
    within_patience(fed.pulse.close)
    assert waits == [1.05]


def test_another_guard_is_waited_for_no_longer_than_the_runtime_is_there(fed: Fed, monkeypatch):
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    monkeypatch.setattr(module, "_connected", lambda path: ours)
    told: list[str] = []
    pulse = Pulse(NOWHERE, Path("x"), told.append, (3600.0,))
    theirs.send(b"what")
    assert pulse.beat(False) == "the guard has ended"
    what = "the guard has ended: nobody watches over control; another try in 3600 s"
    until(lambda: told == [what])
    pulse.close()
    assert not pulse._keeper.is_alive()
    late, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    monkeypatch.setattr(module, "_connected", lambda path: late)
    pulse._again()  # it came when the runtime had ended
    assert late.fileno() == -1
    assert pulse.beat(False) == "the guard has ended"
    for link in (theirs, other):
        link.close()


def test_a_guard_that_was_there_for_long_is_as_good_as_the_first(monkeypatch):
    told, ends = list[str](), list[socket.socket]()

    def connected(path: Path) -> socket.socket:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        theirs.send(b"what")
        ends.append(theirs)
        return ours

    monkeypatch.setattr(module, "_connected", connected)
    monkeypatch.setattr(module, "SETTLED_S", 0.0)
    with Pulse(NOWHERE, Path("x"), told.append, (0.0,)) as pulse:
        until(lambda: (pulse.beat(False), len(told) > 2)[1])
    assert set(told) == {"the guard has ended: nobody watches over control; another try in 0 s"}
    for end in ends:
        end.close()


def test_a_guard_that_is_gone_before_its_orders_is_told_of_in_the_first_turn(monkeypatch):
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    theirs.close()
    monkeypatch.setattr(module, "_connected", lambda path: ours)
    with Pulse(NOWHERE, Path("x"), lambda line: None, ()) as pulse:
        assert pulse.beat(True) == "the guard is gone (Broken pipe)"


@pytest.mark.parametrize("is_ready", [True, False])
def test_a_guard_that_reads_nothing_for_twenty_turns_hangs_where_it_was_ready(fed: Fed, is_ready):
    if is_ready:
        fed.theirs.send(guard.READY)
    said = [fed.pulse.beat(True) for _ in range(3000)]
    well = "" if is_ready else "the guard reaches nobody"
    count = said.index("the guard does not read what it is told") if is_ready else len(said)
    assert set(said[:count]) == {well}
    fed.theirs.settimeout(0.0)
    heard = 0
    with suppress(BlockingIOError):
        while fed.heard():
            heard += 1
    if is_ready:
        assert count - (heard - 1) == module.UNREAD - 1  # and its orders
        assert set(said[count:]) == {module.HANGS}
    assert fed.pulse.beat(True) == well  # it goes on, and so is no other waited for
    assert fed.heard() == guard.MOVING
    assert fed.told == []


def test_a_guard_of_its_own_that_hangs_is_given_up(monkeypatch):
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    monkeypatch.setattr(Pulse, "_started", lambda pulse: ours)
    theirs.send(guard.READY)
    with Pulse(NOWHERE, None, lambda line: None, ()) as pulse:
        assert [pulse.beat(True) for _ in range(3000)][-1] == module.HANGS
        assert ours.fileno() == -1
    theirs.close()


class Child:
    """A process that a test has end, or not."""

    def __init__(self, words: list[str], **how: Any) -> None:
        self.words, self.how = words, how
        self.waits: list[float | None] = []
        self.killed, self.ends = 0, True

    def wait(self, timeout: float | None = None) -> None:
        self.waits.append(timeout)
        if not self.ends and not self.killed:
            raise subprocess.TimeoutExpired(self.words, timeout or 0)

    def kill(self) -> None:
        self.killed += 1


def test_a_guard_of_its_own_is_started_so_that_nothing_that_ends_us_ends_it(monkeypatch):
    monkeypatch.setattr(module.subprocess, "Popen", Child)
    for ends, killed, waits in ((True, 0, [END_S]), (False, 1, [END_S, None])):
        pulse = Pulse(NOWHERE, again_s=())
        child: Any = pulse._process
        (fd,) = child.how.pop("pass_fds")
        assert child.words == [sys.executable, "-m", "runtime.guard", "--fd", str(fd)]
        assert child.how == {"stdin": subprocess.DEVNULL, "start_new_session": True}
        with pytest.raises(OSError, match="Bad file descriptor"):
            os.fstat(fd)  # it is the child's alone
        child.ends = ends
        pulse.close()
        assert (child.killed, child.waits) == (killed, waits)
        pulse.close()
        assert (child.killed, child.waits) == (killed, waits)


def test_a_guard_of_its_own_that_is_gone_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(module.subprocess, "Popen", Child)
    with Pulse(NOWHERE, None, lambda line: None, ()) as pulse:
        child: Any = pulse._process
        assert pulse.beat(True) == "the guard is gone (Broken pipe)"
        until(lambda: child.waits)
    assert child.waits == [0.0]


def test_a_guard_that_cannot_be_started_leaves_no_link(monkeypatch):
    ends = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)

    def no_process(*_: object, **__: object) -> None:
        raise OSError("no memory")

    monkeypatch.setattr(module.socket, "socketpair", lambda *_: ends)
    monkeypatch.setattr(module.subprocess, "Popen", no_process)
    with pytest.raises(OSError, match="no memory"):
        Pulse(NOWHERE)
    assert [end.fileno() for end in ends] == [-1, -1]


def test_what_a_guard_is_to_do_is_all_of_the_bus():
    bus = BusConfig(connect=("tcp/127.0.0.1:2",), prefix="r1")
    zero = wire.encode_twist(0.0, 0.0).hex()
    settings = session_settings(bus) | {"listen/endpoints": []}
    keys = "r1/cmd_vel", zero, "r1/odom", "r1/cmd_vel_teleop", True, "", []
    assert orders(bus) == guard.Orders(settings, *keys)
    stamped = BusConfig(cmd_vel_type="TwistStamped", cmd_vel_frame="base", listen=("tcp/[::1]:7",))
    told = orders(stamped)
    assert bytes.fromhex(told.zero) == wire.encode_twist_stamped(0.0, 0.0, 0, "base")
    assert told.session["listen/endpoints"] == ["tcp/[::1]:8"]
    slam = orders(BusConfig(topics=TopicsConfig(pose="slam", odom="odometry", teleop="")))
    assert (slam.odom, slam.teleop, slam.child) == ("slam", "", False)
    client = BusConfig(mode="client", connect=("tcp/127.0.0.1:2",), listen=("tcp/127.0.0.1:4",))
    assert orders(client).session["listen/endpoints"] == []


def test_among_nodes_of_rmw_zenoh_a_guard_is_a_node_that_zeros_come_from():
    bus = BusConfig(connect=("tcp/127.0.0.1:2",), prefix="r1", dialect="rmw_zenoh", domain=7)
    told = orders(bus)
    robot = RmwZenoh("r1", 7, "jazzy", "rfnav_guard")
    cmd_vel, odom = RosTopic("cmd_vel", wire.TWIST, Qos(depth=1)), RosTopic("odom", wire.ODOMETRY)
    assert (told.cmd_vel, told.odom) == (robot.publishes_on(cmd_vel), robot.publishes_on(odom))
    assert told.teleop == robot.listens_on(RosTopic("cmd_vel_teleop", wire.TWIST))
    assert (told.cmd_vel[:12], told.teleop) == ("7/r1/cmd_vel", "7/r1/cmd_vel_teleop/*/*")
    assert len(bytes.fromhex(told.gid)) == 16
    assert told.gid != orders(bus).gid
    kinds = [token.removeprefix("@ros2_lv/7/{zid}/").split("/")[:3] for token in told.tokens]
    assert kinds == [["0", "0", "NN"], ["0", "1", "MP"], ["0", "2", "MS"]]
    assert all("rfnav_guard" in token for token in told.tokens)


def test_where_no_guard_waits_the_place_and_the_way_are_said(tmp_path: Path):
    path = tmp_path / "guard"
    with pytest.raises(BusError) as refused:
        Pulse(NOWHERE, path)
    assert str(refused.value) == (
        f"{path}: no guard waits there (No such file or directory): start "
        f"`rfnav guard --socket {path}`"
    )


def test_a_guard_that_has_no_time_for_another_runtime_is_not_waited_for(tmp_path: Path):
    path = tmp_path / "guard"
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as door, ExitStack() as others:
        door.bind(str(path))
        door.listen(0)
        with suppress(BlockingIOError):
            while True:
                other = others.enter_context(socket.socket(door.family, door.type))
                other.setblocking(False)
                other.connect(str(path))
        with pytest.raises(BusError, match=r"no guard waits there \(Resource temporarily unavail"):
            Pulse(NOWHERE, path)
