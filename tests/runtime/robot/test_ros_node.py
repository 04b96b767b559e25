"""A node of each dialect over real Zenoh on loopback, and peers of plain Zenoh."""

import struct
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import zenoh

from hil_sim.driving.link import free_port
from runtime.errors import BusError, SensorError
from runtime.robot import wire
from runtime.robot.action_types import CANCEL
from runtime.robot.dialects.dialect import Dialect, Qos, RosService, RosTopic
from runtime.robot.dialects.rmw_zenoh import RmwZenoh
from runtime.robot.dialects.ros2dds import Ros2dds
from runtime.robot.ros_node import RosNode, Sending, ServiceCall
from runtime.robot.session import BusConfig, open_session

PATIENCE_S = 10.0
DIALECTS = [Ros2dds("r"), RmwZenoh("r", 0, "jazzy"), RmwZenoh("r", 4, "humble")]
TWIST = RosTopic("cmd_vel", wire.TWIST)
MAP = RosTopic("map", wire.STRING, Qos(latched=True, depth=1))


def until(what: Callable[[], Any]) -> Any:
    by_s = time.monotonic() + PATIENCE_S
    while not (found := what()):
        assert time.monotonic() < by_s
        time.sleep(0.01)
    return found


@pytest.fixture
def sessions() -> Iterator[tuple[Any, Any]]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    ours = open_session(BusConfig(listen=(endpoint,)))
    theirs: Any = open_session(BusConfig(connect=(endpoint,)))
    until(lambda: theirs.info.peers_zid())
    yield ours, theirs
    theirs.close()
    ours.close()


@pytest.mark.parametrize("dialect", DIALECTS)
def test_what_one_node_publishes_another_hears_by_its_name(sessions: Any, dialect: Dialect):
    ours, theirs = sessions
    heard: list[tuple[str, bytes]] = []
    node, other = RosNode(ours, dialect), RosNode(theirs, dialect)
    publisher = node.publisher(TWIST, Sending(urgent=True, blocks=True))
    assert not publisher.heard()
    other.subscribe(TWIST, lambda name, payload: heard.append((name, payload)))
    until(publisher.heard)
    until(lambda: publisher.put(b"velocity") or heard)
    assert heard[0] == ("r/cmd_vel", b"velocity")
    other.close()
    until(lambda: not publisher.heard())
    node.close()
    with pytest.raises(BusError, match=r"^cmd_vel: cannot be published"):
        publisher.put(b"more")


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("late", ["subscriber", "publisher"])
def test_who_joins_late_gets_the_last_of_a_latched_topic(
    sessions: Any, dialect: Dialect, late: str
):
    ours, theirs = sessions
    heard: list[bytes] = []
    node, other = RosNode(ours, dialect), RosNode(theirs, dialect)

    def listen() -> None:
        other.subscribe(MAP, lambda name, payload: heard.append(payload))

    if late == "publisher":
        listen()
        time.sleep(0.2)
    publisher = node.publisher(MAP, Sending())
    publisher.put(b"first")
    publisher.put(b"last")
    if late == "subscriber":
        listen()
    until(lambda: b"last" in heard)
    if late == "subscriber":
        assert heard == [b"last"]
    other.close()
    node.close()


def test_publications_are_numbered_and_say_by_whom_and_when(sessions: Any):
    ours, theirs = sessions
    node, came = RosNode(ours, DIALECTS[1]), []
    theirs.declare_subscriber("0/r/cmd_vel/**", lambda sample: came.append(sample))
    publisher = node.publisher(TWIST, Sending())
    began_ns = time.time_ns()
    until(lambda: publisher.put(b"x") or len(came) > 2)
    told = [struct.unpack("<qqB16s", sample.attachment.to_bytes()) for sample in came]
    numbers = [number for number, *_ in told]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert all(began_ns <= when <= time.time_ns() for _, when, *_ in told)
    assert {(length, gid) for _, _, length, gid in told} == {(16, told[0][3])}
    assert told[0][3] != bytes(16)
    other = node.publisher(RosTopic("other", wire.TWIST), Sending())
    assert other._gid != told[0][3]
    node.close()


def test_tokens_are_there_while_the_node_is(sessions: Any):
    ours, theirs = sessions

    def seen() -> set[str]:
        replies = theirs.liveliness().get("@ros2_lv/0/**", timeout=5.0)
        return {str(reply.ok.key_expr) for reply in replies if reply.ok is not None}

    node = RosNode(ours, DIALECTS[1])
    node.publisher(TWIST, Sending())
    node.subscribe(MAP, lambda name, payload: None)
    node.serve(RosService("ask", CANCEL), lambda call: None)
    until(lambda: len(seen()) == 4)
    kinds = {key.split("/")[5] for key in seen()}
    assert kinds == {"NN", "MP", "MS", "SS"}
    assert {key.split("/")[2] for key in seen()} == {str(ours.zid())}
    ids = [key.split("/")[4] for key in seen()]
    assert len(set(ids)) == 4
    node.close()
    until(lambda: not seen())


def test_what_is_of_another_type_is_told_of_and_not_handed_on(sessions: Any):
    ours, theirs = sessions
    heard: list[bytes] = []
    strange: list[int] = []
    told: list[tuple[str, SensorError]] = []
    node = RosNode(ours, DIALECTS[1], lambda name, error: told.append((name, error)))
    node.subscribe(
        TWIST, lambda name, payload: heard.append(payload), lambda: strange.append(len(told))
    )
    key = "0/r/cmd_vel/geometry_msgs::msg::dds_::Twist_/TypeHashNotSupported"
    until(lambda: theirs.put(key, b"x") or strange)
    assert strange[0] == 1  # after it was told
    assert told[0][0] == "cmd_vel"
    assert 'bus.distro = "humble"' in str(told[0][1])
    assert heard == []
    node.close()


@pytest.mark.parametrize(
    ("dialect", "key", "asked", "told"),
    [
        (DIALECTS[0], "r/ask", b"rqh" + bytes(17), False),
        (
            DIALECTS[2],
            "4/r/ask/action_msgs::srv::dds_::CancelGoal_/TypeHashNotSupported",
            struct.pack("<qqB16s", 77, 5, 16, b"who asks........"),
            True,
        ),
    ],
)
def test_a_request_is_answered_by_another_thread(
    sessions: Any, dialect: Dialect, key: str, asked: bytes, told: bool
):
    ours, theirs = sessions
    calls: list[ServiceCall] = []
    node = RosNode(ours, dialect)
    node.serve(RosService("ask", CANCEL), calls.append)
    replies: list[Any] = []

    def ask() -> None:
        for _ in range(50):
            found = list(theirs.get(key, payload=b"request", attachment=asked, timeout=PATIENCE_S))
            if found:
                replies.extend(found)
                return
            time.sleep(0.1)

    asking = threading.Thread(target=ask)
    asking.start()
    call = until(lambda: calls and calls[0])
    assert call.payload == b"request"
    call.reply(b"reply")
    call.reply(b"another")
    call.drop()
    asking.join(PATIENCE_S)
    (reply,) = replies
    assert reply.ok.payload.to_bytes() == b"reply"
    assert (reply.ok.attachment is not None) is told
    if told:
        number, when, _, gid = struct.unpack("<qqB16s", reply.ok.attachment.to_bytes())
        assert (number, gid) == (77, b"who asks........")
        assert when > 5
    node.close()


def test_a_call_that_is_dropped_has_no_reply(sessions: Any):
    ours, theirs = sessions
    node = RosNode(ours, DIALECTS[0])
    dropped: list[ServiceCall] = []

    def drop(call: ServiceCall) -> None:
        dropped.append(call)
        call.drop()

    node.serve(RosService("ask", CANCEL), drop)
    until(lambda: list(theirs.get("r/ask", timeout=1.0)) == [] and dropped)
    assert dropped[0].payload == b""
    dropped[0].reply(b"too late")
    node.close()


def test_closing_is_idempotent(sessions: Any):
    node = RosNode(sessions[0], DIALECTS[1])
    node.close()
    node.close()
    assert isinstance(sessions[0], zenoh.Session)
