"""What the page is told of what the service tells, also where the service tells little."""

from typing import Any

import pytest

from runtime.core.belief import Belief, Expected
from runtime.core.voting.names import rule_said
from runtime.tracing.budgets import read_budgets
from runtime.view.told import (
    NAMES_MOST,
    belief_of,
    budgets_of,
    decision_of,
    health_of,
    moved,
    names_of,
    places_of,
    state_of,
    stop_of,
    under_way,
    zones_of,
)

FEEDBACK = {"id": "a1", "goal": "mug", "state": "searching", "elapsed_s": 3.0, "usd": 0.0}
ENDED = {**FEEDBACK, "result": "found", "sentence": "it stands before it", "at_xy": [1.0, 2.0]}
STATUS: dict[str, Any] = {"goal": "mug", "id": "a1", "queue": [], "last": None}


def test_of_nothing_a_state_of_nothing_is_told():
    told = state_of({}, {}, {})
    assert told["runtime"] == {"state": "unknown", "cause": ""}
    assert (told["pose"], told["goal"], told["last"], told["stopped"]) == (None, None, None, False)


@pytest.mark.parametrize(
    ("feedback", "status", "is_under_way"),
    [
        ({}, {}, False),
        (FEEDBACK, {}, True),  # heard before anything was asked
        (FEEDBACK, STATUS, True),
        ({}, STATUS, True),  # a page that is opened in the midst of a search
        (ENDED, STATUS, False),  # the status is older
        (ENDED, {**STATUS, "id": "b2"}, True),  # the next has begun
        (ENDED, {"goal": None, "id": None}, False),
        (FEEDBACK, {"goal": None, "id": None}, False),  # it ended and nobody heard how
    ],
)
def test_whether_there_is_a_goal_is_told_by_the_newest_of_both(
    feedback: dict[str, Any], status: dict[str, Any], is_under_way: bool
):
    assert under_way(feedback, status) is is_under_way
    assert (state_of({}, feedback, status)["goal"] is not None) is is_under_way


def test_the_last_result_is_told_where_it_was_found():
    told = state_of({}, {**ENDED, "origin_xy": [10.0, 0.0]}, {})
    assert told["last"]["result"] == "found"
    assert told["last"]["at_xy"] == [11.0, 2.0]
    assert state_of({}, {}, {"last": {"result": "cancelled"}})["last"]["result"] == "cancelled"


def test_a_result_that_is_known_by_the_status_alone_has_its_place_moved_too():
    last = {"last": {"result": "found", "at_xy": [1.0, 2.0]}}
    assert state_of({"origin_xy": [10.0, 0.0]}, {}, last)["last"]["at_xy"] == [11.0, 2.0]


def test_a_decision_is_told_in_the_frame_that_is_drawn():
    surface = Expected("surface", "a3", (1.0, 2.0), 0.5, "0.4 m² on which it is missed")
    report = {
        "frontiers": [{"id": 7, "goal_xy": [3.0, 4.0], "distance_m": 2.0}],
        "belief": Belief((surface,), 0.5).told(),
    }
    told = decision_of(report, 1, "mug", [], (10.0, 0.0))
    assert told["frontiers"] == [{"id": 7, "goal_xy": [13.0, 4.0], "distance_m": 2.0}]
    assert told["belief"] == [vars(surface) | {"xy": [11.0, 2.0]}]


@pytest.mark.parametrize("none", [None, [], 3, {"places": None}, {"places": [7, "x"]}])
def test_a_belief_that_is_none_is_told_as_an_empty_list(none: object):
    assert belief_of({"belief": none}, (0.0, 0.0)) == []


def test_a_stop_is_told_as_one():
    stopped = {"runtime": {"state": "stopped", "cause": "stopped by rfnav/stop"}}
    assert state_of(stopped, {}, {})["stopped"]
    assert state_of({}, {}, stopped)["stopped"]  # by the status, before a state has come


def test_health_has_rates_ages_and_budgets():
    before = {"now_s": 10.0, "streams": {"odom": {"received": 100}}}
    now = {
        "now_s": 12.0, "streams": {"odom": {"received": 140, "arrival_s": 11.5, "bad": 1}},
        "stages": {"tick": {"p50_ms": 1.0, "p99_ms": 2.0, "over": 3}, "new": {}},
        "models": {"cloud": {"goal_usd": 0.01, "calls": 2}, "rungs": {"o2f": "local"}},
    }  # fmt: skip
    told = health_of(now, before, read_budgets(), ["x" * 1000])
    assert told["streams"]["odom"] == {"per_s": 20.0, "age_s": 0.5, "bad": 1}
    assert told["stages"]["tick"]["budget_ms"] == budgets_of(read_budgets())["tick"]["p99_ms"]
    assert told["stages"]["new"]["budget_ms"] is None
    assert told["money"] == {"goal_usd": 0.01, "day_usd": None, "calls": 2, "model": None}
    assert len(told["wrong"][0]) == 300
    assert health_of({}, {}, read_budgets(), [])["money"] is None
    started_anew = health_of({**now, "now_s": 1.0}, now, read_budgets(), [])
    assert started_anew["streams"]["odom"]["per_s"] is None


def test_a_decision_has_votes_with_the_time_that_each_took():
    vote = {"expert": "o2f", "frontiers": [7], "rung": "cloud", "reply": "long"}
    report = {"votes": [vote, 7], "latency_s": {"o2f": 0.2}, "without": {"o2f": None}, "why": "new"}
    told = decision_of(report, 3, "mug", ["a", "b"])
    assert told["votes"] == [
        {
            "expert": "o2f", "frontiers": [7], "probabilities": None, "reason": None,
            "reasons": None, "against": None, "rung": "cloud", "latency_s": 0.2,
        }
    ]  # fmt: skip
    assert (told["number"], told["why"], told["without"]) == (3, "new", {"o2f": None})
    assert (told["taken"], "rule_said" in told) == ("", False)
    assert decision_of({}, 3, "mug", ["a"]) == {"number": 3, "goal": "mug", "full": ["a"]}


def test_a_stop_is_over_when_it_has_an_end():
    stop = {"number": 1, "kind": "contact", "state": "held", "reason": "r", "in_words": ["w"]}
    assert not stop_of({**stop, "ended_s": None})["over"]
    told = stop_of({**stop, "ended_s": 3.0})
    assert (told["over"], told["halt"]) == (True, "contact")
    assert "kind" not in told


def test_zones_and_places_are_told_where_they_are():
    zone = {"name": "stairs", "polygon": [[0, 0], [1, 0], [1, 1]], "more": 1}
    assert zones_of({"zones": [zone, "x"], "bound": False}) == {
        "zones": [{"name": "stairs", "polygon": zone["polygon"]}], "bound": False,
    }  # fmt: skip
    told = places_of({"places": {"b": [1.0, 2.0, 0.5], "a": None}, "memory": "bound"})
    assert told == {
        "places": [
            {"name": "a", "xy": None, "yaw": None}, {"name": "b", "xy": [1.0, 2.0], "yaw": 0.5}
        ],
        "memory": "bound",
    }  # fmt: skip


def test_what_was_seen_is_suggested_first_and_nothing_twice():
    status = {"detector": {"classes": ["armchair", "mug", "zebra"]}}
    assert names_of(["mug", "cup", "mug"], status) == ["cup", "mug", "armchair", "zebra"]
    assert len(names_of((str(n) for n in range(1000)), {})) == NAMES_MOST
    assert names_of([], {"detector": {"classes": None}}) == []


@pytest.mark.parametrize("at", [None, "x", [1.0], {}, 7])
def test_a_place_that_is_none_is_null(at: object):
    assert moved(at, (1.0, 1.0)) is None


def test_a_decision_is_told_by_the_same_words_as_in_rfnav_why():
    report = {"rule": "prior", "order": [7, 3], "taken": {"in_words": "4.2 m on foot"}}
    told = decision_of(report, 3, "mug", [])
    assert (told["rule_said"], told["taken"]) == (rule_said("prior", planned=True), "4.2 m on foot")
    assert decision_of({"rule": "all"}, 3, "mug", [])["rule_said"] == rule_said("all")
