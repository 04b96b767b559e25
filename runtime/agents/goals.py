"""Goals of agents: begun, followed to their end, and cancelled where who began them gives up."""

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import Executor
from typing import Any, Final

from runtime.agents.link import RobotLink
from runtime.agents.told import AgentAnswer, refused
from runtime.agents.tools import IF_BUSY, AgentLimits
from runtime.errors import BusError, RfNavError
from runtime.log import say
from runtime.view.told import table

TAKEN_S: Final = 60.0  # a goal's words may have to be understood by a model that is slow
ANSWER_S: Final = 5.0
EVERY_S: Final = 1.0
CANCELS: Final = 2  # attempts, the second over a link of its own
AWAY_S: Final = 60.0  # so long a service that is started anew is waited for
GIVEN_UP: Final = "the agent gave up the call that asked for it"
ENDED: Final = (
    "id", "result", "code", "cause", "elapsed_s", "driven_m", "usd", "at_xy", "returned"
)  # fmt: skip
UNDER_WAY: Final = (
    "state", "elapsed_s", "driven_m", "frontiers", "usd", "toward_xy", "paused"
)  # fmt: skip
WORDS: Final = ("goal", "name", "how", "reason", "sentence", "vote", "error")
"""Of what the service answers: what a camera, a model or people may have put there."""

Progress = Callable[[float, float, str], Awaitable[None]]
"""Seconds that have passed, seconds at most, and how it goes."""


def goal_body(asked: Mapping[str, Any], limits: AgentLimits) -> dict[str, Any]:
    """A query's body, within the limits. `asked`: arguments of find_object or go_to_place. The way
    back, which the service sets no limit to, is no longer than the one before: each gets half."""
    share = 0.5 if asked.get("then_return") else 1.0
    amounts = {
        "time_s": share * asked.get("time_limit_s", limits.time_s),
        "distance_m": share * asked.get("distance_limit_m", limits.distance_m),
    }
    body: dict[str, Any] = {}
    if "place" in asked:
        body["go_to"] = asked["place"]
    else:
        body["goal"] = asked["thing"]
        money = asked.get("money_limit_usd", limits.money_usd)
        amounts |= {} if money is None else {"money_usd": money}
    body |= {"limits": amounts, "if_busy": asked.get("if_busy", IF_BUSY[0])}
    body |= {"queue_most": limits.queue}
    body |= {"afterwards": "return"} if asked.get("then_return") else {}
    area = limits.area or ({"room": asked["room"]} if "room" in asked else {})
    return body | ({"area": dict(area)} if area else {})


class _Begun:
    """Goals of one call: either they are told to it, or it has given up and they are cancelled."""

    def __init__(self) -> None:
        self._lock, self._given_up, self._ids = threading.Lock(), False, tuple[str, ...]()

    def began(self, ids: tuple[str, ...]) -> bool:
        """False when nobody wants them any more."""
        with self._lock:
            self._ids = ids
            return not self._given_up

    def give_up(self) -> tuple[str, ...]:
        """What has begun by now."""
        with self._lock:
            self._given_up = True
            return self._ids


class AgentGoals:
    """`usual`: where the service is asked; `hurried`: for what must not wait behind that."""

    def __init__(
        self, link: RobotLink, limits: AgentLimits, usual: Executor, hurried: Executor
    ) -> None:
        self._link, self._limits, self._usual, self._hurried = link, limits, usual, hurried

    async def ask(self, asked: Mapping[str, Any], progress: Progress) -> AgentAnswer:
        """Begin one, and wait as long as it is wished. Who gives that up cancels it."""
        begun, loop = _Begun(), asyncio.get_running_loop()
        body = goal_body(asked, self._limits)
        try:
            answer = await loop.run_in_executor(self._usual, self._begin, body, begun)
            if not answer.get("accepted"):
                why = {"refused": True, "code": answer.get("code")}
                return AgentAnswer(why, {"error": answer.get("error")}, error=True)
            ids = _ids(answer)
            facts = {"accepted": True, "id": ids[0], "then": ids[1:], "queued": _queued(answer)}
            told = AgentAnswer({**facts, "limits": body["limits"]}, _words(answer))
            if not (wait_s := float(asked.get("wait_s", 0.0))):
                return told
            try:
                return await self.follow(ids[-1], wait_s, progress)
            except RfNavError as error:  # it may go on all the same, and has an id
                return AgentAnswer({**told.facts, "error": str(error)}, told.untrusted, error=True)
        except asyncio.CancelledError:
            for id in reversed(begun.give_up()):
                self._hurried.submit(self._cancel, id)
            raise

    async def follow(self, id: str, wait_s: float, progress: Progress) -> AgentAnswer:
        """How a goal stands when it has ended, or after so long. A service that is away for a
        while, started anew for instance, is waited for; BusError after that."""
        began_s = answered_s = time.monotonic()
        while True:
            how = "the robot does not answer"
            over = time.monotonic() - began_s >= wait_s
            try:
                answer = await asyncio.get_running_loop().run_in_executor(
                    self._usual, self._stands, id
                )
                answered_s, how = time.monotonic(), so_far(answer)
                if over or answer.get("result") is not None or "error" in answer:
                    return goal_told(answer)
            except BusError:
                if over or time.monotonic() - answered_s > AWAY_S:
                    raise
            passed_s = min(time.monotonic() - began_s, wait_s)
            await progress(passed_s, wait_s, how)
            await asyncio.sleep(min(EVERY_S, wait_s - passed_s))

    def _stands(self, id: str) -> dict[str, Any]:
        answer = self._link.ask("result", {"id": id, "wait": False}, ANSWER_S)
        if answer.get("accepted") is False:  # it ends just now, or the service is busy
            raise BusError(str(answer.get("error") or "busy"))
        return answer

    def _begin(self, body: dict[str, Any], begun: _Begun) -> dict[str, Any]:
        ready = self._link.ask("status", {}, ANSWER_S)
        if ready.get("accepted") is False:  # else it would begin when nobody waits for it any more
            raise BusError(str(ready.get("error") or "busy"))
        if not begun.began(()):
            return {}
        answer = self._link.ask("goal", body, TAKEN_S)
        if answer.get("accepted") and not begun.began(_ids(answer)):
            for id in reversed(_ids(answer)):  # or the next would begin
                self._cancel(id)
        return answer

    def _cancel(self, id: str) -> None:
        """Nobody waits for what comes of it: that it could not be done is said."""
        why = ""
        for _ in range(CANCELS):
            try:
                self._link.ask("cancel", {"id": id, "reason": GIVEN_UP}, TAKEN_S)
                return
            except RfNavError as error:
                why = str(error)
        say(f"mcp: goal {id}, which was given up, is not cancelled: {why}")


def goal_told(answer: Mapping[str, Any]) -> AgentAnswer:
    """Of an answer on `rfnav/result`."""
    if answer.get("result") is not None:
        facts = {name: answer[name] for name in ENDED if name in answer}
        return AgentAnswer({"ended": True, **facts}, _words(answer))
    if "error" in answer:
        return refused(str(answer["error"]))
    newest = table(answer, "feedback")
    facts = {name: newest[name] for name in UNDER_WAY if name in newest}
    return AgentAnswer(
        {"ended": False, "id": answer.get("id"), "before_it": answer.get("ahead", 0), **facts},
        _words(newest),
    )


def so_far(answer: Mapping[str, Any]) -> str:
    """In a line of numbers and words of ours alone: a client may show it to a model."""
    newest = table(answer, "feedback")
    if ahead := answer.get("ahead"):
        return f"waits for {int(ahead)} before it"
    try:
        spent = f"{newest['elapsed_s']:.0f} s, {newest['driven_m']:.1f} m"
        return f"searches: {spent}, frontiers left: {newest['frontiers']:d}"
    except (KeyError, TypeError, ValueError):
        return "begins"


def _ids(answer: Mapping[str, Any]) -> tuple[str, ...]:
    """Of all goals that a request began, in order."""
    goals = [answer, *answer.get("then", ())]
    try:
        return tuple(str(goal["id"]) for goal in goals)
    except (KeyError, TypeError) as error:
        raise BusError("rfnav/goal: an answer without an id") from error


def _queued(answer: Mapping[str, Any]) -> int:
    queued = answer.get("queued", 0)
    return queued if isinstance(queued, int) else 0


def _words(answer: Mapping[str, Any]) -> dict[str, Any]:
    return {name: answer[name] for name in WORDS if answer.get(name)}
