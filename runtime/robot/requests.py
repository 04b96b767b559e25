"""Queries to the runtime: those that wait, within bounds, and the one that is being answered."""

import json
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import zenoh

from runtime.errors import SensorError
from runtime.journal import plain
from runtime.robot.json_text import parse_json

CANCELLED: Final = "it was cancelled before it began"
ENDS: Final = "rfnav ends"


@dataclass(frozen=True)
class QueryKind:
    """`waiting`: how many of it wait at most, and `wait_s`: how long, while models load for
    instance. `strict`: one that is no JSON is refused; of others it is taken as empty. `steers`:
    what the robot does depends on it, and so does a replay."""

    waiting: int = 16
    strict: bool = True
    steers: bool = False
    wait_s: float = math.inf


# On `rfnav/KIND`. What overtakes comes first: a cancel is never behind a goal. A cancel cancels and
# a status is told whatever else they say: who cannot be understood may want the robot to stop.
QUERIES: Final = {
    "cancel": QueryKind(strict=False, steers=True),
    "pause": QueryKind(strict=False, steers=True),
    "status": QueryKind(strict=False),
    "result": QueryKind(),
    "resume": QueryKind(steers=True),
    "goal": QueryKind(waiting=4, steers=True, wait_s=50.0),  # ours ask for 60 s, then they go
    "why": QueryKind(),
    "places": QueryKind(),
    "things": QueryKind(),
    "where": QueryKind(),
    "map": QueryKind(),
    "zones": QueryKind(),  # what a search makes of them is recorded with it
}


class Request:
    """A query, to be answered by the thread that owns the bus. The first reply counts, and calls
    `answered`; one to a querier that has gone is lost quietly."""

    def __init__(
        self,
        kind: str,
        body: dict[str, Any],
        query: Any,
        key: str,
        answered: Callable[[], None] = lambda: None,
    ) -> None:
        self.kind = kind
        self.body = body
        self._query = query
        self._key = key
        self._answered, self._is_answered = answered, False

    def reply(self, answer: Mapping[str, object]) -> None:
        if self._is_answered:
            return
        said = json.dumps(plain(answer))
        self._is_answered = True
        try:
            self._query.reply(self._key, said)
        except zenoh.ZError:
            pass  # the session that asked has closed
        finally:
            self._query.drop()
            self._answered()

    def refuse(self, why: str) -> None:
        self.reply({"accepted": False, "error": why})


@dataclass(frozen=True)
class _Waiting:
    """A query as it came."""

    kind: str
    key: str
    query: Any
    answered: Callable[[], None]
    came_s: float

    def read(self) -> Request:
        """SensorError for one that must be JSON and is none."""
        payload = self.query.payload.to_bytes() if self.query.payload is not None else b"{}"
        body: dict[str, Any] = {}
        try:
            body = parse_json(payload, self.key)
        except SensorError:
            if QUERIES[self.kind].strict:
                raise
        return Request(self.kind, body, self.query, self.key, self.answered)

    def refuse(self, why: str) -> None:
        Request(self.kind, {}, self.query, self.key, self.answered).refuse(why)


class Requests:
    """Queries of all kinds, filed by the bus's threads and taken by one. `changed` is told of what
    comes; `answered` of each that was answered, by its kind."""

    def __init__(
        self,
        changed: threading.Condition,
        key: Callable[[str], str],
        answered: Callable[[str], None] = lambda kind: None,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._changed, self._key, self._answered = changed, key, answered
        self._now_s = now_s
        self._waiting: dict[str, deque[_Waiting]] = {kind: deque() for kind in QUERIES}
        self._closed = False

    def file(self, kind: str, topic: str, query: Any) -> None:
        """Have a query wait; one too many is answered at once."""
        answered = partial(self._answered, kind)
        waiting = _Waiting(kind, self._key(topic), query, answered, self._now_s())
        why, most = "", QUERIES[kind].waiting
        with self._changed:
            if self._closed:
                why = ENDS
            elif len(self._waiting[kind]) >= most:
                why = f"busy: {most} {kind} requests wait already"
            else:
                self._waiting[kind].append(waiting)
                self._changed.notify_all()
        if why:
            waiting.refuse(why)

    def wait(self) -> bool:
        """Whether any does. Holding `changed`."""
        return any(self._waiting.values())

    def take(self) -> Request | None:
        """The next; None when none waits. Goals that came before a cancel go with it, unless it
        names one."""
        while True:
            with self._changed:
                kind = next((kind for kind, queue in self._waiting.items() if queue), None)
                if kind is None:
                    return None
                waiting = self._waiting[kind].popleft()
                before = list(self._waiting["goal"])
            late_s = self._now_s() - waiting.came_s
            if late_s > QUERIES[kind].wait_s:
                waiting.refuse(f"it has waited for {late_s:.0f} s: ask again")
                continue
            try:
                request = waiting.read()
            except SensorError as error:
                waiting.refuse(str(error))
                continue
            if kind == "cancel" and request.body.get("id") is None:
                self._drop(before)
            return request

    def close(self) -> None:
        """What waits is refused, and so is what still comes."""
        with self._changed:
            self._closed = True
            left = [one for queue in self._waiting.values() for one in queue]
            for queue in self._waiting.values():
                queue.clear()
        for one in left:
            one.refuse(ENDS)

    def _drop(self, goals: list[_Waiting]) -> None:
        with self._changed:
            for goal in goals:
                self._waiting["goal"].remove(goal)
        for goal in goals:
            goal.refuse(CANCELLED)
