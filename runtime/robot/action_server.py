"""An action served to ROS 2, over either dialect. What is asked of it is read in Zenoh's threads;
what becomes of a goal is asked of who owns the robot, who may answer from any thread."""

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import partial
from typing import Any, Final

import numpy as np

from runtime.errors import SensorError
from runtime.log import say
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

REQUEST_BYTES: Final = 1 << 15
ASKERS: Final = 8  # that wait for one goal's result
KEPT: Final = 16  # goals that have ended, whose results may still be asked for
NOBODY: Final = bytes(16)  # the id that stands for all goals


class GoalState(IntEnum):
    """GoalStatus.status; UNKNOWN of one that is not accepted yet."""

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
    """A goal that was sent. `message`: of its type's Goal."""

    id: bytes
    message: Any
    stamp_ns: int  # when it came
    state: GoalState = GoalState.UNKNOWN
    result: bytes = b""  # the reply to who asks, once it has ended
    askers: list[ServiceCall] = field(default_factory=list)


Accepting = Callable[[bool], None]
"""Called once, from any thread: whether a goal is taken on."""
Ending = Callable[[Sequence[ActionGoal]], None]
"""The same for a cancel: which of its goals are ended early."""


class ActionServer:
    """`wants` is called of each goal that is sent, `cancels` of those under way that are to end,
    both in Zenoh's threads. Any thread may call the methods."""

    def __init__(
        self,
        node: RosNode,
        name: str,
        action: ActionType,
        wants: Callable[[ActionGoal, Accepting], None],
        cancels: Callable[[Sequence[ActionGoal], Ending], None],
        now_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._name, self._action, self._now_ns = name, action, now_ns
        self._wants, self._cancels = wants, cancels
        self._lock, self._closed = threading.Lock(), False
        self._goals: dict[bytes, ActionGoal] = {}  # by id, the oldest first
        self.bad = 0  # requests that were none; the first is told of
        within, kind = f"{name}/_action", action.kind
        feedback = RosTopic(f"{within}/feedback", f"{kind}_FeedbackMessage")
        self._feedback = node.publisher(feedback, Sending())
        status = RosTopic(f"{within}/status", STATUS, Qos(latched=True, depth=1))
        self._status = node.publisher(status, Sending())
        for what, served, answer in (
            ("send_goal", f"{kind}_SendGoal", self._send_goal),
            ("cancel_goal", CANCEL, self._cancel_goal),
            ("get_result", f"{kind}_GetResult", self._get_result),
        ):
            service = RosService(f"{within}/{what}", served)
            node.serve(service, partial(self._answer, answer, f"{served}_Request"))

    def begin(self, goal: ActionGoal) -> None:
        """It is under way."""
        with self._lock:
            if goal.state is GoalState.ACCEPTED:
                self._to(goal, GoalState.EXECUTING)

    def feedback(self, goal: ActionGoal, feedback: Any) -> None:
        """`feedback`: a message of the type's Feedback."""
        message = self._action.new("FeedbackMessage", _uuid(goal.id), feedback)
        self._feedback.put(wire.encode(message))

    def end(self, goal: ActionGoal, state: GoalState, result: Any) -> None:
        """It is over; whoever asks or has asked is told. `result`: a message of the type's
        Result."""
        reply = wire.encode(self._action.new("GetResult_Response", int(state), result))
        with self._lock:
            goal.result = reply
            self._to(goal, state)
            askers, goal.askers = goal.askers, []
            ended = [id for id, one in self._goals.items() if one.state.ended]
            for id in ended[:-KEPT]:
                del self._goals[id]
        for asker in askers:
            asker.reply(reply)

    def close(self) -> None:
        """Nobody is answered any more."""
        with self._lock:
            self._closed = True
            left = [asker for goal in self._goals.values() for asker in goal.askers]
            self._goals.clear()
        for asker in left:
            asker.drop()

    # -- inside, in Zenoh's threads ------------------------------------------------------------

    def _answer(
        self, answer: Callable[[ServiceCall, Any], None], kind: str, call: ServiceCall
    ) -> None:
        try:
            if len(call.payload) > REQUEST_BYTES:
                raise SensorError(
                    f"{self._name}: {len(call.payload)} bytes: at most {REQUEST_BYTES}"
                )
            request = wire.decode(call.payload, kind, self._name)
        except SensorError as error:
            if not self.bad:
                say(str(error))
            self.bad += 1
            call.drop()
            return
        answer(call, request)

    def _send_goal(self, call: ServiceCall, request: Any) -> None:
        goal = ActionGoal(_id(request.goal_id), request.goal, self._now_ns())
        with self._lock:
            new = goal.id != NOBODY and goal.id not in self._goals and not self._closed
            if new:
                self._goals[goal.id] = goal
        if new:
            self._wants(goal, partial(self._accept, call, goal))
        else:
            self._reply_accepted(call, goal, False)

    def _accept(self, call: ServiceCall, goal: ActionGoal, accepted: bool) -> None:
        """In whatever thread has decided it."""
        with self._lock:
            if accepted:
                goal.state = GoalState.ACCEPTED
            else:
                self._goals.pop(goal.id, None)
        self._reply_accepted(call, goal, accepted)
        if accepted:
            with self._lock:
                self._publish_status()

    def _reply_accepted(self, call: ServiceCall, goal: ActionGoal, accepted: bool) -> None:
        reply = self._action.new("SendGoal_Response", accepted, _time(goal.stamp_ns))
        call.reply(wire.encode(reply))

    def _get_result(self, call: ServiceCall, request: Any) -> None:
        with self._lock:
            goal = self._goals.get(_id(request.goal_id))
            waits = goal is not None and not goal.result
            if goal is not None and waits and len(goal.askers) < ASKERS:
                goal.askers.append(call)
                return
        if waits:
            call.drop()
        else:
            call.reply(goal.result if goal else self._nothing())

    def _cancel_goal(self, call: ServiceCall, request: Any) -> None:
        """The one that is named, and those that came until a time that is; all without either."""
        info = request.goal_info
        id, until_ns = _id(info.goal_id), info.stamp.sec * 10**9 + info.stamp.nanosec
        everything = id == NOBODY and until_ns == 0
        with self._lock:
            named = self._goals.get(id)
            meant = [
                goal
                for goal in self._goals.values()
                if goal.state is not GoalState.UNKNOWN
                and not goal.state.ended
                and (everything or goal is named or 0 < goal.stamp_ns <= until_ns)
            ]
        if meant:
            self._cancels(meant, partial(self._ending, call))
            return
        code = CancelCode.NONE
        if id != NOBODY:
            code = CancelCode.UNKNOWN_GOAL if named is None else CancelCode.GOAL_ENDED
        self._reply_cancelled(call, code, ())

    def _ending(self, call: ServiceCall, ending: Sequence[ActionGoal]) -> None:
        """In whatever thread has decided it."""
        with self._lock:
            for goal in ending:
                if not goal.state.ended:
                    self._to(goal, GoalState.CANCELING)
        code = CancelCode.NONE if ending else CancelCode.REJECTED
        self._reply_cancelled(call, code, ending)

    def _reply_cancelled(
        self, call: ServiceCall, code: CancelCode, ending: Sequence[ActionGoal]
    ) -> None:
        told = [_info(goal) for goal in ending]
        response = wire.STORE.types[f"{CANCEL}_Response"](int(code), told)
        call.reply(wire.encode(response))

    def _nothing(self) -> bytes:
        """What is told of a goal that nobody knows: a result of zeros."""
        return wire.encode(self._action.blank("GetResult_Response"))

    def _to(self, goal: ActionGoal, state: GoalState) -> None:
        """Holding the lock."""
        goal.state = state
        self._publish_status()

    def _publish_status(self) -> None:
        """Holding the lock: what is true last is published last."""
        kind = wire.STORE.types[GOAL_STATUS]
        told = [
            kind(_info(goal), int(goal.state))
            for goal in self._goals.values()
            if goal.state is not GoalState.UNKNOWN
        ]
        self._status.put(wire.encode(wire.STORE.types[STATUS](told)))


def _id(uuid: Any) -> bytes:
    return bytes(np.asarray(uuid.uuid, np.uint8))


def _uuid(id: bytes) -> Any:
    return wire.STORE.types[UUID](np.frombuffer(id, np.uint8))


def _time(stamp_ns: int) -> Any:
    return wire.STORE.types[TIME](*divmod(stamp_ns, 10**9))


def _info(goal: ActionGoal) -> Any:
    return wire.STORE.types[GOAL_INFO](_uuid(goal.id), _time(goal.stamp_ns))
