"""What nodes of rmw_zenoh send beside messages: keys, what goes along with requests, and requests
to an action."""

import io
import struct
from collections.abc import Callable
from contextlib import redirect_stderr
from typing import Any

from action_desk import ActionDesk
from fake_node import FakeCall, FakeNode
from fibonacci import FIBONACCI, LE

from runtime.errors import RfNavError, SensorError
from runtime.loops.goal_request import STRICT
from runtime.loops.ros_goals import RosGoals
from runtime.robot import wire
from runtime.robot.action_server import ActionServer
from runtime.robot.dialects.dialect import RosTopic
from runtime.robot.dialects.rmw_zenoh import RmwZenoh
from runtime.robot.goal_actions import goal_actions

ODOM, DIALECT = RosTopic("odom", wire.ODOMETRY), RmwZenoh("", 0, "jazzy")
ID = bytes(range(16))
KEYS = [DIALECT.publishes_on(ODOM).encode()]
ATTACHED = [DIALECT.attachment(5, 7, ID) or b""]
REQUESTS = {
    "send_goal": LE + ID + struct.pack("<i", 5),
    "cancel_goal": LE + ID + struct.pack("<iI", 3, 0),
    "get_result": LE + ID,
}


def _goals() -> dict[str, bytes]:
    """One of each action that is served."""
    find, go, navigate = goal_actions("jazzy")
    thing, place, pose = find.kind.blank("Goal"), go.kind.blank("Goal"), navigate.kind.blank("Goal")
    thing.goal, thing.time_limit_s, thing.area_room = ["mug"], 300.0, "kitchen"
    place.place, pose.pose.pose.position.x = "dock", 2.0
    told = {find.name: thing, go.name: place, navigate.name: pose}
    return {name: LE + ID + wire.encode(goal)[4:] for name, goal in told.items()}


GOALS = _goals()


def ros(data: bytes, refused: Callable[[str], None]) -> None:
    """By its first byte: a key, an attachment, a request to an action that has a goal, or a goal of
    those that are served."""
    if not data:
        return
    number, told = data[0] % (2 + len(REQUESTS) + len(GOALS)), data[1:]
    if number == 0:
        key = "/".join(
            part or "x" for part in ("a/b/c/" + told.decode("utf-8", "replace")).split("/")
        )
        try:
            DIALECT.name_of(key, ODOM)
        except SensorError as error:
            refused(str(error))
    elif number == 1:
        reply = DIALECT.reply_attachment(told, 7)
        assert reply is None or len(reply) == 33
    elif number < 2 + len(REQUESTS):
        _asked(list(REQUESTS)[number - 2], told, refused)
    else:
        _wanted(list(GOALS)[number - 2 - len(REQUESTS)], told, refused)


def _asked(what: str, payload: bytes, refused: Callable[[str], None]) -> None:
    node, call = FakeNode(), FakeCall(payload)
    owner = lambda goal, accept: accept(True), lambda goals, ending: ending(goals)
    server: Any = ActionServer(node, "fibonacci", FIBONACCI, *owner)  # type: ignore[arg-type]
    within = "fibonacci/_action"
    if what != "send_goal":
        node.served[f"{within}/send_goal"](FakeCall(REQUESTS["send_goal"]))
    with redirect_stderr(io.StringIO()) as told:
        node.served[f"{within}/{what}"](call)
    if server.bad:
        refused(told.getvalue().strip())
    server.close()
    assert len(call.replies) + call.dropped == 1


def _wanted(name: str, payload: bytes, refused: Callable[[str], None]) -> None:
    """A goal goes to the desk, is told of and has a result."""
    desk, call, asker = ActionDesk(), FakeCall(payload), FakeCall(LE + ID)
    goals = RosGoals(desk)
    with redirect_stderr(io.StringIO()) as told:
        desk.node.served[f"{name}/_action/send_goal"](call)
    if call.dropped:
        refused(told.getvalue().strip())
    elif (request := desk.requests.take()) is not None:
        try:
            STRICT.read(request.body)
            request.reply({"accepted": True, "id": "0a"})
            desk.on_feedback({"id": "0a", "state": "searching"})
        except RfNavError as error:
            request.refuse(str(error))
    desk.node.served[f"{name}/_action/get_result"](asker)
    goals.close()
    assert len(call.replies) + call.dropped == 1
    assert len(asker.replies) == 1


def seeds() -> list[bytes]:
    told = [*KEYS, *ATTACHED, *REQUESTS.values(), *GOALS.values()]
    told[0] = told[0].removeprefix(b"0/odom/")
    return [bytes((number,)) + seed for number, seed in enumerate(told)]
