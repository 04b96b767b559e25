"""Who waits for a result hears of it, and results are kept for a while."""

import json
from typing import Any

from runtime.robot.requests import Request
from runtime.service.results import ASKERS, KEPT, GoalResults


class Query:
    def __init__(self) -> None:
        self.answers: list[dict[str, Any]] = []

    def reply(self, key: str, answer: str) -> None:
        self.answers.append(json.loads(answer))

    def drop(self) -> None:
        """Nothing is held."""


def wait(results: GoalResults, id: str) -> Query:
    query = Query()
    results.wait(id, Request("result", {}, query, "rfnav/result"))
    return query


def test_each_hears_of_its_own_goal_alone():
    results = GoalResults()
    one, other, again = (wait(results, id) for id in ("a", "b", "a"))
    results.file({"id": "a", "result": "found"})
    assert one.answers == again.answers == [{"id": "a", "result": "found"}]
    assert other.answers == []
    results.close("rfnav ends")
    assert other.answers[0]["error"] == "rfnav ends"
    results.file({"id": "b", "result": "found"})
    assert len(other.answers) == 1


def test_no_more_wait_than_are_kept_and_who_has_gone_keeps_nobody_out():
    results = GoalResults()
    queries = [wait(results, "a") for _ in range(ASKERS + 1)]
    assert [bool(query.answers) for query in queries] == [True] + [False] * ASKERS
    assert "ask again" in queries[0].answers[0]["error"]
    results.file({"id": "a", "result": "found"})
    assert queries[-1].answers == [{"id": "a", "result": "found"}]


def test_the_newest_are_kept():
    results = GoalResults()
    assert results.last is None
    for number in range(KEPT + 2):
        results.file({"id": str(number), "result": "found"})
    assert [results.of(str(n)) is None for n in (0, 1, 2)] == [True, True, False]
    assert results.last == {"id": str(KEPT + 1), "result": "found"}
    results.file({"id": "5", "result": "failed"})
    assert results.last == {"id": "5", "result": "failed"}
