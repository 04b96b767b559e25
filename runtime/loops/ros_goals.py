"""Goals that come by ROS 2's actions. They are asked at the same desk as a query on `rfnav/goal`, a
cancel as one on `rfnav/cancel`, and are told what `rfnav/feedback` tells."""

import json
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final, Protocol

from runtime.core.types import Pose, SearchState
from runtime.robot.action_server import Accepting, ActionGoal, ActionServer, Ending, GoalState
from runtime.robot.goal_actions import GoalAction, goal_actions
from runtime.robot.requests import ENDS
from runtime.robot.ros_node import RosNode
from runtime.service.outcomes import FailCause, GoalEnd, Refusal, refused

EARLY: Final = 16  # goals that ended before they were answered for
STATES: Final = {
    "found": GoalState.SUCCEEDED,
    "arrived": GoalState.SUCCEEDED,
    "cancelled": GoalState.CANCELED,
}
"""By result; of all others ABORTED."""


class ActionBus(Protocol):
    """The bus, as actions need it; see `Bus`."""

    node: RosNode
    on_feedback: Callable[[Mapping[str, Any]], None]

    @property
    def distro(self) -> str:
        """Of the nodes of ROS 2 that it speaks with."""
        ...

    def file(self, kind: str, query: Any) -> None: ...

    def placed(self, pose: Pose, frame: str) -> Pose: ...

    def frame_of(self, stream: str, otherwise: str) -> str: ...


class _Query:
    """What an action was asked, as Zenoh would have it; `told` gets the answer."""

    def __init__(
        self, asked: Callable[[], Mapping[str, object]], told: Callable[[dict[str, Any]], None]
    ) -> None:
        self._asked, self._told = asked, told

    @property
    def payload(self) -> "_Query":
        return self

    def to_bytes(self) -> bytes:
        return json.dumps(self._asked()).encode()

    def reply(self, key: str, said: str) -> None:
        self._told(json.loads(said))

    def drop(self) -> None:
        """Nothing is held."""


@dataclass
class _Sent:
    """A goal, the action that it came by and what it was answered. What is asked for in turn has an
    id each; `open`: those that have not ended, `ended`: how the others did."""

    action: GoalAction
    server: ActionServer
    goal: ActionGoal
    answer: Mapping[str, Any]
    open: list[str]
    ended: list[Mapping[str, Any]] = field(default_factory=list)

    def end(self, frame: str) -> None:
        """By the first of its ends that is none to be content with, else by the last."""
        states = [STATES.get(str(told.get("result")), GoalState.ABORTED) for told in self.ended]
        bad = [n for n, state in enumerate(states) if state is not GoalState.SUCCEEDED]
        which = bad[0] if bad else -1
        told = dict(self.ended[which])
        if len(self.ended) > 1:
            told["each"] = self.ended
        self.server.end(self.goal, states[which], self.action.result(told, frame))


class RosGoals:
    """See the module. Every goal that can be read is accepted, and has a result: ROS has no words
    for why one is refused, a result does. All methods may be called from any thread."""

    def __init__(self, bus: ActionBus) -> None:
        self._bus, self._lock = bus, threading.Lock()
        self._sent: dict[str, _Sent] = {}  # under way or queued, by our own ids
        self._early: dict[str, Mapping[str, Any]] = {}  # how those ended that nobody was told of
        self._servers: dict[str, ActionServer] = {}
        self._closed = False
        for action in goal_actions(bus.distro):
            served = bus.node, action.name, action.kind, partial(self._want, action), self._cancel
            self._servers[action.name] = ActionServer(*served)
        bus.on_feedback = self.tell

    def tell(self, told: Mapping[str, Any]) -> None:
        """A report on a goal, as it is on `rfnav/feedback`; one with a result is its last."""
        id, ends = str(told.get("id")), "result" in told
        with self._lock:
            sent = self._sent.pop(id, None) if ends else self._sent.get(id)
            if ends and sent is None:
                self._early[id] = told
                for old in list(self._early)[:-EARLY]:
                    del self._early[old]
        if sent is None:
            return
        frame = self._frame()
        if not ends:
            sent.server.begin(sent.goal)
        sent.server.feedback(sent.goal, sent.action.feedback({**sent.answer, **told}, frame))
        if ends:
            sent.open.remove(id)
            sent.ended.append(told)
            if not sent.open:
                sent.end(frame)

    def close(self) -> None:
        """Whoever still waits is told that nothing comes any more."""
        self._bus.on_feedback = lambda told: None
        with self._lock:
            self._closed = True
            left = {sent.goal.id: sent for sent in self._sent.values()}
            self._sent.clear()
        end = GoalEnd(SearchState.ENDED, ENDS, FailCause.RESTART)
        for sent in left.values():
            sent.ended += [end.told(id, str(sent.answer.get("name", "")), {}) for id in sent.open]
            sent.end(self._frame())
        for server in self._servers.values():
            server.close()

    # -- inside --------------------------------------------------------------------------------

    def _frame(self) -> str:
        return self._bus.frame_of("odom", "odom")

    def _want(self, action: GoalAction, goal: ActionGoal, accept: Accepting) -> None:
        asked = partial(action.asked, goal.message, self._bus.placed)
        self._bus.file("goal", _Query(asked, partial(self._answered, action, goal, accept)))

    def _answered(
        self, action: GoalAction, goal: ActionGoal, accept: Accepting, answer: dict[str, Any]
    ) -> None:
        """The desk has."""
        sent = _Sent(action, self._servers[action.name], goal, answer, [])
        with self._lock:
            accept(not self._closed)
            if self._closed:
                return
            if answer.get("accepted"):
                self._keep(sent, [answer, *answer.get("then", ())])
            else:
                sent.ended.append(refused(Refusal.REQUEST, "") | answer)
        if not sent.open:
            sent.end(self._frame())

    def _keep(self, sent: _Sent, answers: Iterable[Mapping[str, Any]]) -> None:
        """Holding the lock."""
        for answer in answers:
            id = str(answer["id"])
            if (early := self._early.pop(id, None)) is not None:
                sent.ended.append(early)
            else:
                sent.open.append(id)
                self._sent[id] = sent

    def _cancel(self, goals: Sequence[ActionGoal], ending: Ending) -> None:
        meant = {goal.id for goal in goals}
        with self._lock:
            ids = {id: sent.goal for id, sent in self._sent.items() if sent.goal.id in meant}
        ended: dict[bytes, ActionGoal] = {}

        def ask() -> None:
            """One after the other: no more cancels may wait at the desk than few. The last that was
            asked for first, or it would begin when the one before it ends."""
            if not ids:
                ending(list(ended.values()))
                return
            id, goal = ids.popitem()
            asked = partial(dict[str, object], id=id, reason="cancelled by ROS")
            self._bus.file("cancel", _Query(asked, partial(told, goal)))

        def told(goal: ActionGoal, answer: dict[str, Any]) -> None:
            if answer.get("ended"):
                ended[goal.id] = goal
            ask()

        ask()
