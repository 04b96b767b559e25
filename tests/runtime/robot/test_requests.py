"""Queries wait within bounds; a cancel overtakes them, and takes earlier goals along."""

import json
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from runtime.robot.requests import CANCELLED, ENDS, QUERIES, Request, Requests


class Asker:
    """A query, and what it was answered."""

    def __init__(self, payload: bytes | None) -> None:
        self.payload = None if payload is None else self
        self._bytes = payload or b""
        self.answers: list[dict[str, Any]] = []
        self.dropped = False

    def to_bytes(self) -> bytes:
        return self._bytes

    def reply(self, key: str, answer: str) -> None:
        assert not self.dropped
        self.answers.append({"key": key, **json.loads(answer)})

    def drop(self) -> None:
        self.dropped = True


def waiting(now_s: Callable[[], float] = time.monotonic) -> Requests:
    return Requests(threading.Condition(), lambda topic: f"robot/{topic}", now_s=now_s)


def file(requests: Requests, kind: str, payload: bytes | None = b"{}") -> Asker:
    asker = Asker(payload)
    requests.file(kind, f"rfnav/{kind}", asker)
    return asker


def taken(requests: Requests) -> Request:
    request = requests.take()
    assert request is not None
    return request


def test_cancel_overtakes_status_and_status_overtakes_goals():
    requests = waiting()
    file(requests, "goal", b'{"goal":"bed"}')
    file(requests, "status")
    assert [taken(requests).kind for _ in range(2)] == ["status", "goal"]
    for kind in ("status", "cancel", "status"):
        file(requests, kind)
    assert [taken(requests).kind for _ in range(3)] == ["cancel", "status", "status"]
    assert requests.take() is None


@pytest.mark.parametrize("payload", [b"{}", b'{"id":null}', b"all of it"])
def test_goals_that_came_before_a_cancel_go_with_it(payload: bytes):
    requests = waiting()
    goals = [file(requests, "goal", b'{"goal":"bed"}') for _ in range(3)]
    file(requests, "cancel", payload)
    later = taken(requests)
    assert later.kind == "cancel"
    for goal in goals:
        assert [answer["error"] for answer in goal.answers] == [CANCELLED]
        assert goal.dropped
    file(requests, "goal", b'{"goal":"sofa"}')
    assert taken(requests).body == {"goal": "sofa"}


def test_a_cancel_of_one_goal_takes_no_other_along():
    requests = waiting()
    goal = file(requests, "goal", b'{"goal":"bed"}')
    file(requests, "cancel", b'{"id":"a1"}')
    assert taken(requests).body == {"id": "a1"}
    assert taken(requests).body == {"goal": "bed"}
    assert goal.answers == []


def test_a_goal_that_has_waited_long_is_begun_for_nobody():
    at_s = [7.0]
    requests = waiting(lambda: at_s[0])
    late, status = file(requests, "goal", b'{"goal":"bed"}'), file(requests, "status")
    at_s[0] += QUERIES["goal"].wait_s + 1.0
    file(requests, "goal", b'{"goal":"sofa"}')
    assert taken(requests).kind == "status"
    assert taken(requests).body == {"goal": "sofa"}
    assert [answer["error"] for answer in late.answers] == ["it has waited for 51 s: ask again"]
    assert status.answers == []


def test_a_flood_is_answered_busy_and_a_cancel_comes_through_it():
    requests = waiting()
    goals = [file(requests, "goal", b'{"goal":"bed"}') for _ in range(800)]
    busy = [goal for goal in goals if goal.answers]
    assert len(busy) == 800 - QUERIES["goal"].waiting
    assert busy[0].answers == [
        {
            "key": "robot/rfnav/goal",
            "accepted": False,
            "error": "busy: 4 goal requests wait already",
        }
    ]
    file(requests, "cancel")
    assert taken(requests).kind == "cancel"
    assert all(goal.answers and goal.dropped for goal in goals)


def test_a_cancel_cancels_and_a_status_is_told_whatever_else_they_say():
    requests = waiting()
    for payload in (b"\xff\0", b"[" * 900, None, b"[]", b'{"reason":"enough"}'):
        file(requests, "cancel", payload)
        request = taken(requests)
        assert request.kind == "cancel"
        assert request.body in ({}, {"reason": "enough"})
        file(requests, "status", payload)
        assert taken(requests).kind == "status"


def test_a_goal_that_is_no_json_is_refused_and_the_next_is_taken():
    requests = waiting()
    bad = file(requests, "goal", b"{")
    file(requests, "goal", b'{"goal":"bed"}')
    assert taken(requests).body == {"goal": "bed"}
    assert "not JSON" in bad.answers[0]["error"]
    assert bad.dropped


def test_the_first_answer_counts():
    asker = Asker(b"{}")
    request = Request("goal", {}, asker, "rfnav/goal")
    request.reply({"accepted": True})
    request.refuse("too late")
    assert [answer["accepted"] for answer in asker.answers] == [True]


def test_who_waits_at_the_end_is_told_so_and_so_is_who_comes_then():
    requests = waiting()
    askers = [file(requests, kind) for kind in QUERIES]
    requests.close()
    askers.append(file(requests, "goal"))
    assert all(asker.dropped for asker in askers)
    assert {asker.answers[0]["error"] for asker in askers} == {ENDS}
    assert not requests.wait()
