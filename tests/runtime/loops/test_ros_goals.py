"""The door for ROS 2's actions, on no bus: who asks, and the desk that answers, are the test's."""

import json
from collections.abc import Iterator
from typing import Any

import pytest
from action_desk import ActionDesk
from fake_node import LE, FakeCall

from runtime.loops.ros_goals import EARLY, RosGoals
from runtime.robot import wire
from runtime.robot.action_server import CancelCode, GoalState
from runtime.robot.goal_actions import FIND
from runtime.robot.requests import QUERIES, Request

ONE, TWO = b"goal number one.", b"goal number two."
EVERYTHING = bytes(24)
WITHIN = "rfnav/find_object/_action"


class Robot(ActionDesk):
    """The test answers at the desk."""

    def __init__(self) -> None:
        super().__init__()
        self.goals = RosGoals(self)

    def taken(self) -> Request:
        request = self.requests.take()
        assert request is not None
        return request

    def send(self, id: bytes, *goal: str) -> FakeCall:
        """Have a goal of FindObject wait at the desk."""
        message = FIND.blank("Goal")
        message.goal = list(goal)
        return self.node.call(f"{WITHIN}/send_goal", id + wire.encode(message)[4:])

    def accepted(self, id: bytes, as_: str, **more: Any) -> None:
        call = self.send(id, "mug")
        self.taken().reply({"accepted": True, "id": as_, "name": "mug", **more})
        assert call.replies[0][0] == 1

    def result(self, id: bytes) -> FakeCall:
        return self.node.call(f"{WITHIN}/get_result", id)

    def cancel(self, info: bytes) -> FakeCall:
        return self.node.call(f"{WITHIN}/cancel_goal", info)

    def fed(self) -> list[tuple[bytes, Any]]:
        """(id, Feedback) of all that was published."""
        kind = f"{FIND.kind}_FeedbackMessage"
        raw = self.node.published[f"{WITHIN}/feedback"]
        told = [wire.decode(LE + one, kind, "fed") for one in raw]
        return [(bytes(one.goal_id.uuid), one.feedback) for one in told]


def read(call: FakeCall) -> tuple[GoalState, Any]:
    raw = LE + call.replies[0]
    told: Any = wire.decode(raw, f"{FIND.kind}_GetResult_Response", "result")
    return GoalState(told.status), told.result


@pytest.fixture
def robot() -> Iterator[Robot]:
    robot = Robot()
    yield robot
    robot.goals.close()


def test_a_goal_is_asked_at_the_desk_and_told_what_is_told_of_it(robot: Robot):
    sent = robot.send(ONE, "a red mug")
    request = robot.taken()
    assert (request.kind, request.body) == ("goal", {"goal": "a red mug"})
    assert not sent.replies  # the desk has the word
    request.reply({"accepted": True, "id": "0a", "how": "mug: known"})
    assert sent.replies[0][0] == 1
    waiting = robot.result(ONE)
    robot.on_feedback({"id": "0a", "state": "searching", "driven_m": 1.5})
    robot.on_feedback({"id": "of another door", "state": "searching"})
    ((id, told),) = robot.fed()
    assert (id, told.state, told.driven_m, told.how) == (ONE, "searching", 1.5, "mug: known")
    assert told.current_pose.header.frame_id == "odom of its own"
    assert not waiting.replies
    robot.on_feedback({"id": "0a", "result": "found", "code": 0, "sentence": "there"})
    assert json.loads(robot.fed()[-1][1].details)["result"] == "found"
    state, result = read(waiting)
    assert (state, result.result, result.code, result.sentence) == (4, "found", 0, "there")
    assert read(robot.result(ONE))[0] is GoalState.SUCCEEDED  # whoever asks later


@pytest.mark.parametrize(
    ("result", "state"),
    [
        ("found", GoalState.SUCCEEDED),
        ("arrived", GoalState.SUCCEEDED),
        ("cancelled", GoalState.CANCELED),
        ("not_found", GoalState.ABORTED),
        ("preempted", GoalState.ABORTED),
        ("failed", GoalState.ABORTED),
    ],
)
def test_a_result_is_a_state_of_ros(robot: Robot, result: str, state: GoalState):
    robot.accepted(ONE, "0a")
    robot.on_feedback({"id": "0a", "result": result, "code": 1})
    assert read(robot.result(ONE))[0] is state


def test_why_a_goal_is_refused_is_in_its_result(robot: Robot):
    sent = robot.send(ONE, "kitchen")
    robot.taken().reply({"accepted": False, "code": 4720, "error": "goal: a room is a place"})
    assert sent.replies[0][0] == 1
    state, result = read(robot.result(ONE))
    assert state is GoalState.ABORTED
    assert (result.result, result.code) == ("refused", 4720)
    assert result.sentence == "goal: a room is a place"


def test_what_cannot_be_made_a_request_or_is_one_too_many_is_refused_as_well(robot: Robot):
    message = FIND.blank("Goal")
    message.goal, message.time_limit_s = ["mug"], float("nan")
    robot.node.call(f"{WITHIN}/send_goal", ONE + wire.encode(message)[4:])
    assert robot.requests.take() is None
    result = read(robot.result(ONE))[1]
    assert "time_limit_s: is no number" in result.sentence
    assert result.code == 4720
    for number in range(QUERIES["goal"].waiting + 1):
        robot.send(bytes([number + 1]) * 16, "mug")
    late = bytes([QUERIES["goal"].waiting + 1]) * 16
    assert read(robot.result(late))[1].sentence.startswith("busy: ")


def test_an_end_that_comes_before_the_answer_is_told_all_the_same(robot: Robot):
    robot.send(ONE, "mug")
    request = robot.taken()
    robot.on_feedback({"id": "0a", "result": "failed", "cause": "fault", "code": 4712})
    for number in range(EARLY - 1):
        robot.on_feedback({"id": f"other {number}", "result": "found"})
    request.reply({"accepted": True, "id": "0a"})
    assert read(robot.result(ONE))[1].cause == "fault"
    assert len(robot.goals._early) < EARLY


def test_only_so_many_ends_are_kept_for_goals_of_other_doors(robot: Robot):
    for number in range(3 * EARLY):
        robot.on_feedback({"id": f"{number}", "result": "found"})
    assert len(robot.goals._early) == EARLY


@pytest.mark.parametrize(
    ("first", "second", "which", "state"),
    [
        ("found", "found", "0b", GoalState.SUCCEEDED),
        ("not_found", "found", "0a", GoalState.ABORTED),
        ("found", "cancelled", "0b", GoalState.CANCELED),
    ],
)
def test_things_that_are_looked_for_in_turn_have_one_result(
    robot: Robot, first: str, second: str, which: str, state: GoalState
):
    robot.accepted(ONE, "0a", then=[{"id": "0b", "name": "chair"}])
    waiting = robot.result(ONE)
    robot.on_feedback({"id": "0a", "result": first, "sentence": "0a", "code": 1})
    assert not waiting.replies
    robot.on_feedback({"id": "0b", "state": "searching"})
    assert robot.fed()[-1][1].state == "searching"
    robot.on_feedback({"id": "0b", "result": second, "sentence": "0b", "code": 2})
    told, result = read(waiting)
    assert (told, result.sentence) == (state, which)
    each = json.loads(result.details)["each"]
    assert [one["sentence"] for one in each] == ["0a", "0b"]


def test_things_that_are_looked_for_in_turn_are_cancelled_together(robot: Robot):
    ids = [f"0{n}" for n in range(QUERIES["cancel"].waiting + 2)]  # more than may wait at the desk
    robot.accepted(ONE, ids[0], then=[{"id": id, "name": "chair"} for id in ids[1:]])
    cancel = robot.cancel(ONE + bytes(8))
    for id in reversed(ids):  # none begins because another ends
        assert not cancel.replies
        request = robot.taken()
        assert request.body["id"] == id
        request.reply({"ended": True})
    assert (cancel.replies[0][0], cancel.replies[0][4]) == (CancelCode.NONE, 1)


def test_a_goal_is_cancelled_at_the_desk(robot: Robot):
    robot.accepted(ONE, "0a")
    robot.accepted(TWO, "0b")
    cancel = robot.cancel(TWO + bytes(8))
    request = robot.taken()
    assert request.kind == "cancel"
    assert request.body == {"id": "0b", "reason": "cancelled by ROS"}
    robot.on_feedback({"id": "0b", "result": "cancelled", "code": 4703})
    request.reply({"ended": True})
    code, count = cancel.replies[0][0], cancel.replies[0][4]
    assert (code, count) == (CancelCode.NONE, 1)
    assert read(robot.result(TWO))[0] is GoalState.CANCELED
    assert not robot.result(ONE).replies  # goes on


def test_a_cancel_of_all_is_answered_when_each_is(robot: Robot):
    robot.accepted(ONE, "0a")
    robot.accepted(TWO, "0b")
    cancel = robot.cancel(EVERYTHING)
    last = robot.taken()
    assert last.body["id"] == "0b"
    last.reply({"ended": True})
    assert not cancel.replies
    first = robot.taken()
    assert first.body["id"] == "0a"
    first.reply({"ended": False, "error": "no such goal"})
    assert (cancel.replies[0][0], cancel.replies[0][4]) == (CancelCode.NONE, 1)


def test_a_cancel_that_ends_nothing_is_refused(robot: Robot):
    robot.accepted(ONE, "0a")
    cancel = robot.cancel(ONE + bytes(8))
    robot.taken().reply({"ended": False})
    assert cancel.replies[0][0] == CancelCode.REJECTED


def test_whoever_waits_at_the_end_has_a_result(robot: Robot):
    robot.accepted(ONE, "0a")
    waiting = robot.result(ONE)
    unanswered = robot.send(TWO, "mug")
    robot.goals.close()
    state, result = read(waiting)
    assert (state, result.result, result.cause) == (GoalState.ABORTED, "failed", "restart")
    assert result.code == 4713
    assert result.sentence == '"mug" failed: rfnav ends'
    robot.requests.close()
    assert unanswered.replies[0][0] == 0
    robot.on_feedback({"id": "0a", "state": "searching"})
    assert not robot.fed()
