"""An action served to ROS 2, over either dialect: what comes is filed in Zenoh's threads, and
answered by the one that owns the server, in its turn."""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from functools import partial
from typing import Any, Final

import numpy as np

from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.action_types import (
    CANCEL,
    GOAL_INFO,
    GOAL_STATUS,
    STATUS,
    TIME,
    UUID,
    ActionType,
)
from runtime.robot.dialects.dialect import Qos, RosService, RosTopic
from runtime.robot.ros_node import RosNode, Sending, ServiceCall

WAITING: Final = 16  # requests of a kind; what comes beyond is dropped
ASKERS: Final = 8  # that wait for one goal's result
KEPT: Final = 16  # goals that have ended, whose results may still be asked for
NOBODY: Final = bytes(16)  # the id that stands for all goals


class GoalState(IntEnum):
    """GoalStatus.status."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def ended(self) -> bool:
        return self >= GoalState.SUCCEEDED


class CancelCode(IntEnum):
    """CancelGoal_Response.return_code."""

    NONE = 0
    REJECTED = 1
    UNKNOWN_GOAL = 2
    GOAL_ENDED = 3


@dataclass
class ActionGoal:
    """A goal that was accepted. `message`: of its type's Goal."""

    id: bytes
    message: Any
    stamp_ns: int  # when it was accepted
    state: GoalState = GoalState.ACCEPTED
    result: bytes = b""  # the reply to who asks, once it has ended
    askers: list[ServiceCall] = field(default_factory=list)


class ActionServer:
    """`filed` is called in Zenoh's threads when something waits; all methods by one thread."""

    def __init__(
        self,
        node: RosNode,
        name: str,
        action: ActionType,
        filed: Callable[[], None] = lambda: None,
        now_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._name, self._action, self._filed, self._now_ns = name, action, filed, now_ns
        self._lock = threading.Lock()
        self._waiting: deque[tuple[str, ServiceCall]] = deque()
        self._goals: dict[bytes, ActionGoal] = {}  # by id, the oldest first
        self.bad, self.last_error = 0, ""  # requests that were none
        within, kind = f"{name}/_action", action.kind
        feedback = RosTopic(f"{within}/feedback", f"{kind}_FeedbackMessage")
        self._feedback = node.publisher(feedback, Sending())
        status = RosTopic(f"{within}/status", STATUS, Qos(latched=True, depth=1))
        self._status = node.publisher(status, Sending())
        for what, served in (
            ("send_goal", f"{kind}_SendGoal"),
            ("cancel_goal", CANCEL),
            ("get_result", f"{kind}_GetResult"),
        ):
            node.serve(RosService(f"{within}/{what}", served), partial(self._file, what))

    def turn(
        self, accepts: Callable[[Any], bool], cancels: Callable[[ActionGoal], bool]
    ) -> list[ActionGoal]:
        """Answer all that waits; goals that are new. `accepts`: whether a goal is taken on, of its
        message; `cancels`: whether one that is under way may be ended early."""
        taken: list[ActionGoal] = []
        while (next_ := self._next()) is not None:
            what, call = next_
            try:
                if what == "send_goal":
                    taken += self._send_goal(call, accepts)
                elif what == "cancel_goal":
                    self._cancel(call, cancels)
                else:
                    self._get_result(call)
            except SensorError as error:
                self.bad, self.last_error = self.bad + 1, str(error)
                call.drop()
        return taken

    def begin(self, goal: ActionGoal) -> None:
        """It is under way."""
        self._to(goal, GoalState.EXECUTING)

    def feedback(self, goal: ActionGoal, feedback: Any) -> None:
        """`feedback`: a message of the type's Feedback."""
        message = self._action.new("FeedbackMessage", _uuid(goal.id), feedback)
        self._feedback.put(wire.encode(message))

    def end(self, goal: ActionGoal, state: GoalState, result: Any) -> None:
        """It is over; whoever asks or has asked is told. `result`: a message of the type's
        Result."""
        goal.result = wire.encode(self._action.new("GetResult_Response", int(state), result))
        self._to(goal, state)
        askers, goal.askers = goal.askers, []
        for asker in askers:
            asker.reply(goal.result)
        ended = [id for id, one in self._goals.items() if one.state.ended]
        for id in ended[:-KEPT]:
            del self._goals[id]

    def close(self) -> None:
        """Nobody is answered any more."""
        while (next_ := self._next()) is not None:
            next_[1].drop()
        for goal in self._goals.values():
            for asker in goal.askers:
                asker.drop()
            goal.askers = []

    # -- inside --------------------------------------------------------------------------------

    def _file(self, what: str, call: ServiceCall) -> None:
        """In Zenoh's threads."""
        with self._lock:
            room = sum(1 for kind, _ in self._waiting if kind == what) < WAITING
            if room:
                self._waiting.append((what, call))
        if room:
            self._filed()
        else:
            call.drop()

    def _next(self) -> tuple[str, ServiceCall] | None:
        with self._lock:
            return self._waiting.popleft() if self._waiting else None

    def _send_goal(self, call: ServiceCall, accepts: Callable[[Any], bool]) -> list[ActionGoal]:
        request = self._read(call, f"{self._action.kind}_SendGoal_Request")
        id, stamp_ns = _id(request.goal_id), self._now_ns()
        accepted = id != NOBODY and id not in self._goals and accepts(request.goal)
        goal = ActionGoal(id, request.goal, stamp_ns)
        if accepted:
            self._goals[id] = goal
        reply = self._action.new("SendGoal_Response", accepted, _time(stamp_ns))
        call.reply(wire.encode(reply))
        if accepted:
            self._publish_status()
        return [goal] if accepted else []

    def _get_result(self, call: ServiceCall) -> None:
        request = self._read(call, f"{self._action.kind}_GetResult_Request")
        goal = self._goals.get(_id(request.goal_id))
        if goal is None:
            call.reply(self._nothing())
        elif goal.state.ended:
            call.reply(goal.result)
        elif len(goal.askers) < ASKERS:
            goal.askers.append(call)
        else:
            call.drop()

    def _cancel(self, call: ServiceCall, cancels: Callable[[ActionGoal], bool]) -> None:
        """The one that is named, and those accepted until a time that is; all without either."""
        info = self._read(call, f"{CANCEL}_Request").goal_info
        id, until_ns = _id(info.goal_id), info.stamp.sec * 10**9 + info.stamp.nanosec
        named, everything = self._goals.get(id), id == NOBODY and until_ns == 0
        meant = [
            goal
            for goal in self._goals.values()
            if not goal.state.ended
            and (everything or goal is named or 0 < goal.stamp_ns <= until_ns)
        ]
        ending = [goal for goal in meant if cancels(goal)]
        code = CancelCode.NONE
        if meant and not ending:
            code = CancelCode.REJECTED
        elif not meant and id != NOBODY:
            code = CancelCode.UNKNOWN_GOAL if named is None else CancelCode.GOAL_ENDED
        told = [_info(goal) for goal in ending]
        response = wire.STORE.types[f"{CANCEL}_Response"](int(code), told)
        call.reply(wire.encode(response))
        for goal in ending:
            self._to(goal, GoalState.CANCELING)

    def _read(self, call: ServiceCall, kind: str) -> Any:
        return wire.decode(call.payload, kind, self._name)

    def _nothing(self) -> bytes:
        """What is told of a goal that nobody knows: a result of zeros."""
        return wire.encode(self._action.blank("GetResult_Response"))

    def _to(self, goal: ActionGoal, state: GoalState) -> None:
        goal.state = state
        self._publish_status()

    def _publish_status(self) -> None:
        kind = wire.STORE.types[GOAL_STATUS]
        told = [kind(_info(goal), int(goal.state)) for goal in self._goals.values()]
        self._status.put(wire.encode(wire.STORE.types[STATUS](told)))


def _id(uuid: Any) -> bytes:
    return bytes(np.asarray(uuid.uuid, np.uint8))


def _uuid(id: bytes) -> Any:
    return wire.STORE.types[UUID](np.frombuffer(id, np.uint8))


def _time(stamp_ns: int) -> Any:
    return wire.STORE.types[TIME](*divmod(stamp_ns, 10**9))


def _info(goal: ActionGoal) -> Any:
    return wire.STORE.types[GOAL_INFO](_uuid(goal.id), _time(goal.stamp_ns))
