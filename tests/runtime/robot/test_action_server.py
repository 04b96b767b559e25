"""A fixed action, served to a client that has no other code in common with it."""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from fake_node import FakeCall, FakeNode
from fibonacci import FIBONACCI, LE, FibonacciClient, sequence

from hil_sim.driving.link import free_port
from runtime.robot.action_server import (
    ASKERS,
    KEPT,
    REQUEST_BYTES,
    ActionGoal,
    ActionServer,
    GoalState,
)
from runtime.robot.dialects.choice import spoken
from runtime.robot.ros_node import RosNode
from runtime.robot.session import BusConfig, open_session

PATIENCE_S = 20.0
ONE, TWO = b"goal number one.", b"goal number two."
NOBODY = bytes(16)


class Served:
    """The owner: takes goals of an order below 50, and lets them be ended where it `cancels`."""

    def __init__(self, config: BusConfig, session: Any) -> None:
        self.node = RosNode(session, spoken(config))
        self.now_ns = 10**9
        called = self.node, "fibonacci", FIBONACCI, self._want, self._cancel
        self.server = ActionServer(*called, lambda: self.now_ns)
        self.goals: list[ActionGoal] = []
        self.cancels = True

    def _want(self, goal: ActionGoal, accept: Callable[[bool], None]) -> None:
        taken = goal.message.order < 50
        accept(taken)
        if taken:
            self.server.begin(goal)
            self.goals.append(goal)

    def _cancel(
        self, goals: Sequence[ActionGoal], ending: Callable[[Sequence[ActionGoal]], None]
    ) -> None:
        ending(goals if self.cancels else ())

    def close(self) -> None:
        self.server.close()
        self.node.close()


@pytest.fixture(params=["ros2dds", "rmw_zenoh"])
def both(request: pytest.FixtureRequest) -> Iterator[tuple[Served, FibonacciClient]]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config = BusConfig(listen=(endpoint,), dialect=request.param)
    ours: Any = open_session(config)
    theirs: Any = open_session(BusConfig(connect=(endpoint,)))
    served, client = Served(config, ours), FibonacciClient(theirs, request.param)
    until(lambda: list(theirs.get(client.key("get_result"), payload=LE + NOBODY, timeout=1.0)))
    time.sleep(0.3)  # a link of Zenoh's loses what is published in its first moments
    yield served, client
    theirs.close()
    served.close()
    ours.close()


def until(what: Callable[[], Any]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.02)


def numbers(order: int) -> Any:
    return np.array(sequence(order), np.int32)


def test_a_goal_is_taken_told_of_and_ended_with_its_result(both: Any):
    served, client = both
    assert client.send_goal(ONE, 5)
    until(lambda: served.goals)
    (goal,) = served.goals
    results: list[Any] = []
    asking = threading.Thread(target=lambda: results.append(client.get_result(ONE)))
    asking.start()
    until(lambda: goal.askers)
    served.server.feedback(goal, FIBONACCI.new("Feedback", numbers(3)))
    until(lambda: client.fed)
    assert client.fed == [(ONE, [0, 1, 1, 2])]
    served.server.end(goal, GoalState.SUCCEEDED, FIBONACCI.new("Result", numbers(5)))
    asking.join(PATIENCE_S)
    assert results == [(4, [0, 1, 1, 2, 3, 5])]
    assert client.get_result(ONE) == (4, [0, 1, 1, 2, 3, 5])  # it may be asked for later
    until(lambda: client.statuses and client.statuses[-1] == [(ONE, 4)])
    told = [status for told in client.statuses for _, status in told]
    assert told == [1, 2, 4]


def test_a_goal_that_is_refused_or_known_or_nobodys_is_not_taken(both: Any):
    served, client = both
    assert not client.send_goal(ONE, 60)
    assert not client.send_goal(NOBODY, 3)
    assert client.send_goal(ONE, 3)
    assert not client.send_goal(ONE, 3)
    assert len(served.goals) == 1
    assert client.get_result(TWO) == (0, [])  # unknown


def test_a_goal_is_ended_early_when_that_is_asked_and_allowed(both: Any):
    served, client = both
    assert client.cancel(ONE) == (2, 0)  # nobody knows it
    served.now_ns = 10**9
    assert client.send_goal(ONE, 3)
    served.now_ns = 5 * 10**9
    assert client.send_goal(TWO, 4)
    until(lambda: len(served.goals) == 2)
    served.cancels = False
    assert client.cancel(ONE) == (1, 0)  # refused
    served.cancels = True
    assert client.cancel(NOBODY, sec=3) == (0, 1)  # what was accepted until then
    assert [goal.state for goal in served.goals] == [GoalState.CANCELING, GoalState.EXECUTING]
    nothing = FIBONACCI.new("Result", np.zeros(0, np.int32))
    served.server.end(served.goals[0], GoalState.CANCELED, nothing)
    assert client.get_result(ONE) == (5, [])
    assert client.cancel(ONE) == (3, 0)  # it has ended
    assert client.cancel(NOBODY) == (0, 1)  # all
    until(lambda: client.statuses[-1] == [(ONE, 5), (TWO, 3)])


def test_requests_that_are_none_are_counted_and_no_more(
    both: Any, capsys: pytest.CaptureFixture[str]
):
    served, client = both
    assert list(client.session.get(client.key("send_goal"), payload=b"\x00", timeout=1.0)) == []
    until(lambda: served.server.bad)
    assert capsys.readouterr().err.count("fibonacci: 1 bytes are not a CDR ") == 1
    long = LE + bytes(REQUEST_BYTES)
    assert list(client.session.get(client.key("send_goal"), payload=long, timeout=1.0)) == []
    assert served.server.bad == 2
    assert capsys.readouterr().err == ""  # the first is told of
    assert client.send_goal(ONE, 3)


class Nobody:
    """An owner who answers nothing, on no bus."""

    def __init__(self) -> None:
        self.node = FakeNode()
        self.wanted: list[tuple[ActionGoal, Callable[[bool], None]]] = []
        self.cancelled: list[Any] = []
        node: Any = self.node
        self.server = ActionServer(
            node,
            "fibonacci",
            FIBONACCI,
            lambda *asked: self.wanted.append(asked),
            lambda *asked: self.cancelled.append(asked),
        )

    def asked(self, what: str, body: bytes) -> FakeCall:
        return self.node.call(f"fibonacci/_action/{what}", body)


def ended(server: ActionServer, goal: ActionGoal) -> None:
    server.end(goal, GoalState.ABORTED, FIBONACCI.new("Result", numbers(1)))


def test_only_so_many_results_are_kept():
    nobody = Nobody()
    goals = []
    for n in range(1, KEPT + 4):
        nobody.asked("send_goal", bytes([n]) * 16 + bytes(4))
        goal, accept = nobody.wanted[-1]
        accept(True)
        goals.append(goal)
    for goal in goals:
        ended(nobody.server, goal)
    told = [nobody.asked("get_result", goal.id).replies[0][0] for goal in goals]
    assert told == [GoalState.UNKNOWN] * 3 + [GoalState.ABORTED] * KEPT


def test_only_so_many_wait_for_a_result_and_none_after_the_end():
    nobody = Nobody()
    nobody.asked("send_goal", ONE + bytes(4))
    nobody.wanted[0][1](True)
    askers = [nobody.asked("get_result", ONE) for _ in range(ASKERS + 2)]
    assert [call.dropped for call in askers] == [False] * ASKERS + [True] * 2
    nobody.server.close()
    assert all(call.dropped for call in askers)
    assert not any(call.replies for call in askers)
    late = nobody.asked("send_goal", TWO + bytes(4))
    assert late.replies[0][0] == 0  # not accepted
    assert len(nobody.wanted) == 1


def test_a_goal_that_is_not_accepted_yet_is_nobodys_to_cancel_and_not_shown():
    nobody = Nobody()
    sent = nobody.asked("send_goal", ONE + bytes(4))
    assert not sent.replies
    everything = nobody.asked("cancel_goal", NOBODY + bytes(8))
    assert everything.replies[0][0] == 0
    assert not nobody.cancelled
    nobody.wanted[0][1](False)
    assert sent.replies[0][0] == 0
    again = nobody.asked("send_goal", ONE + bytes(4))
    nobody.wanted[1][1](True)  # one that was refused may be sent again
    assert again.replies[0][0] == 1
    nobody.asked("cancel_goal", NOBODY + bytes(8))
    assert [goal.id for goal in nobody.cancelled[0][0]] == [ONE]


def test_a_goal_that_has_ended_meanwhile_stays_so():
    nobody = Nobody()
    nobody.asked("send_goal", ONE + bytes(4))
    goal, accept = nobody.wanted[0]
    accept(True)
    cancel = nobody.asked("cancel_goal", ONE + bytes(8))
    ended(nobody.server, goal)
    nobody.server.begin(goal)
    goals, ending = nobody.cancelled[0]
    ending(goals)  # its end overtook the answer to the cancel
    assert goal.state is GoalState.ABORTED
    assert cancel.replies[0][0] == 0
    status = nobody.node.published["fibonacci/_action/status"]
    assert status[-1][-1] == GoalState.ABORTED
