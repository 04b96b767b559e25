"""A fixed action, served to a client that has no other code in common with it."""

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from fibonacci import FIBONACCI, LE, FibonacciClient, sequence

from hil_sim.driving.link import free_port
from runtime.robot.action_server import KEPT, WAITING, ActionGoal, ActionServer, GoalState
from runtime.robot.dialects.choice import spoken
from runtime.robot.ros_node import RosNode
from runtime.robot.session import BusConfig, open_session

PATIENCE_S = 20.0
ONE, TWO = b"goal number one.", b"goal number two."
NOBODY = bytes(16)


class Served:
    """The owner: takes goals of an order below 50, works on them when it is told to."""

    def __init__(self, config: BusConfig, session: Any) -> None:
        self.node = RosNode(session, spoken(config))
        self.filed = threading.Event()
        self.now_ns = 10**9
        self.server = ActionServer(
            self.node, "fibonacci", FIBONACCI, self.filed.set, lambda: self.now_ns
        )
        self.goals: list[ActionGoal] = []
        self.cancels = True
        self._ending = threading.Event()
        self.thread = threading.Thread(target=self._turn)
        self.thread.start()

    def _turn(self) -> None:
        while not self._ending.is_set():
            self.filed.wait(0.05)
            self.filed.clear()
            new = self.server.turn(lambda goal: goal.order < 50, lambda goal: self.cancels)
            for goal in new:
                self.server.begin(goal)
            self.goals += new

    def close(self) -> None:
        self._ending.set()
        self.thread.join()
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


def test_requests_that_are_none_are_counted_and_no_more(both: Any):
    served, client = both
    assert list(client.session.get(client.key("send_goal"), payload=b"\x00", timeout=1.0)) == []
    until(lambda: served.server.bad)
    assert served.server.last_error.startswith("fibonacci: 1 bytes are not a CDR ")
    assert client.send_goal(ONE, 3)


@pytest.fixture
def alone() -> Iterator[RosNode]:
    """A node that nobody else is beside."""
    config = BusConfig(listen=(f"tcp/127.0.0.1:{free_port()}",))
    session: Any = open_session(config)
    node = RosNode(session, spoken(config))
    yield node
    node.close()
    session.close()


def test_only_so_many_results_are_kept(alone: RosNode):
    server = ActionServer(alone, "fibonacci", FIBONACCI)
    goals = [ActionGoal(bytes([n]) * 16, None, n) for n in range(1, KEPT + 4)]
    server._goals = {goal.id: goal for goal in goals}
    for goal in goals:
        server.end(goal, GoalState.ABORTED, FIBONACCI.new("Result", numbers(1)))
    assert list(server._goals) == [goal.id for goal in goals[-KEPT:]]


class FakeCall:
    dropped = False

    def drop(self) -> None:
        self.dropped = True


def test_only_so_many_requests_wait(alone: RosNode):
    server = ActionServer(alone, "fibonacci", FIBONACCI)
    calls: list[Any] = [FakeCall() for _ in range(WAITING + 3)]
    for call in calls:
        server._file("send_goal", call)
    assert [call.dropped for call in calls] == [False] * WAITING + [True] * 3
    server.close()
    assert all(call.dropped for call in calls)
