"""Whatever is asked is answered."""

import json
from typing import Any

import pytest

from runtime.loops.desk import Desk
from runtime.robot.requests import Request


class Query:
    def __init__(self) -> None:
        self.answers: list[dict[str, Any]] = []

    def reply(self, key: str, answer: str) -> None:
        self.answers.append(json.loads(answer))

    def drop(self) -> None:
        """Nothing is held."""


def asked(kind: str) -> tuple[Request, Query]:
    query = Query()
    return Request(kind, {"n": 1}, query, f"rfnav/{kind}"), query


def test_a_kind_is_answered_by_its_own_function_and_another_is_refused():
    desk = Desk({"goal": lambda request: {"accepted": True, **request.body}})
    for kind, answer in (
        ("goal", {"accepted": True, "n": 1}),
        ("why", {"accepted": False, "error": "rfnav/why: is not answered here"}),
    ):
        request, query = asked(kind)
        desk.answer(request)
        assert query.answers == [answer]


def test_one_may_be_answered_later():
    kept: list[Request] = []
    request, query = asked("result")
    Desk({"result": kept.append}).answer(request)
    assert query.answers == []
    kept[0].reply({"result": "found"})
    assert query.answers == [{"result": "found"}]


def test_one_that_meets_a_mistake_is_answered_before_that_is_raised():
    def mistaken(request: Request) -> dict[str, object]:
        raise KeyError(request.kind)

    request, query = asked("goal")
    with pytest.raises(KeyError):
        Desk({"goal": mistaken}).answer(request)
    assert query.answers == [{"accepted": False, "error": "internal error: KeyError('goal')"}]
