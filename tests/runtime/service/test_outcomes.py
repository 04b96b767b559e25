"""The closed lists of results and refusals, and their sentences."""

from dataclasses import replace
from typing import Any

import pytest

from runtime.core.types import SearchState
from runtime.service.outcomes import (
    REFUSALS,
    RESULTS,
    FailCause,
    GoalEnd,
    Refusal,
    refused,
)

SEARCHED = {"floor_m2": 38.2, "near_m2": 30.0, "rooms_m2": {"kitchen": 12.0, "bedroom": 9.5}}
FACTS: dict[str, Any] = {
    "elapsed_s": 193.0, "driven_m": 21.34, "usd": 0.0, "searched": SEARCHED,
    "unreached": [{"frontier": 4, "xy": [1.0, 2.0], "cells": 9},
                  {"frontier": 7, "xy": [-1.0, 0.5], "cells": 8}],
}  # fmt: skip


def test_every_end_and_every_refusal_has_a_number_of_ours_that_nothing_else_has():
    codes = [listed.code for listed in (*RESULTS.values(), *REFUSALS.values()) if listed.code]
    assert len(codes) == len(set(codes)) == len(RESULTS) - 2 + len(REFUSALS)
    assert all(4700 < code < 4800 for code in codes)
    assert set(REFUSALS) == set(Refusal)
    assert set(FailCause) <= set(RESULTS)
    ends = {state for state in SearchState if state.over or state is SearchState.PREEMPTED}
    assert ends - {SearchState.FAILED} == {key for key in RESULTS if isinstance(key, SearchState)}
    assert [key for key, listed in RESULTS.items() if listed.code == 0] == ["found", "arrived"]


def test_where_a_thing_may_still_be_is_told_of_what_was_not_found_alone():
    doubts = [
        {"on": "shelf", "xy": [1.0, -2.04], "chance": 0.124, "seen_m": 3.1},
        {"on": "", "xy": [0.0, 0.0], "chance": 0.02, "seen_m": None},
    ]
    facts = FACTS | {"in_doubt": doubts}
    told = GoalEnd(SearchState.NOT_FOUND, "nothing left").sentence("mug", facts)
    assert (
        "; by the detector's recall at its size most likely missed: the shelf at (1.0, -2.0), "
        "seen from 3.1 m (about 12 %), what stands at (0.0, 0.0) (about 2 %); it took" in told
    )
    away = GoalEnd(SearchState.UNREACHABLE, "no way", at_xy=(1.0, 1.0))
    assert "missed" not in away.sentence("mug", facts)


def test_a_refusal_tells_its_number():
    assert refused(Refusal.BUSY, "why") == {"accepted": False, "code": 4721, "error": "why"}


@pytest.mark.parametrize(
    ("end", "sentence"),
    [
        (GoalEnd(SearchState.FOUND, "found mug 3", at_xy=(1.04, -2.0)),
         '"a mug" was found at (1.0, -2.0); it took 3.2 min and 21.3 m'),
        (GoalEnd(SearchState.ARRIVED, "there"), '"a mug": the robot has arrived; '
         "it took 3.2 min and 21.3 m"),
        (GoalEnd(SearchState.NOT_FOUND, "nothing left"),
         '"a mug" was not found; 38.2 m2 of floor were seen, 30 of it from near (kitchen 12, '
         "bedroom 9.5); no way led to (1.0, 2.0), (-1.0, 0.5); it took 3.2 min and 21.3 m"),
        (GoalEnd(SearchState.UNREACHABLE, "mug 3 was seen at (1.0, 0.0), and no way leads there"),
         '"a mug": unreachable: mug 3 was seen at (1.0, 0.0), and no way leads there; 38.2 m2'),
        (GoalEnd(SearchState.CANCELLED, "cancelled"), '"a mug" was cancelled; 38.2 m2'),
        (GoalEnd(SearchState.CANCELLED, "enough"), '"a mug" was cancelled: enough; 38.2 m2 of '
         "floor were seen, 30 of it from near (kitchen 12, bedroom 9.5); it took 3.2 min "
         "and 21.3 m"),
        (GoalEnd(SearchState.PREEMPTED, "preempted"), '"a mug" gave way to another goal; 38.2'),
        (GoalEnd(SearchState.TIMED_OUT, "60 s have passed"), '"a mug" ran out of time; 38.2'),
        (GoalEnd(SearchState.AREA_LEFT, "it is outside"), '"a mug": area left: it is outside; 38'),
        (GoalEnd(SearchState.FAILED, "battery: 3 % is left", FailCause.BATTERY, returned=True),
         '"a mug" failed: battery: 3 % is left; 38.2 m2'),
    ],
)  # fmt: skip
def test_every_end_is_a_sentence(end: GoalEnd, sentence: str):
    assert end.sentence("a mug", FACTS).startswith(sentence)


def test_a_goal_that_was_never_searched_for_has_no_facts():
    end = GoalEnd(SearchState.ENDED, "the runtime ends", FailCause.RESTART)
    assert end.told("a1", "a mug", {}) == {
        "id": "a1", "goal": "a mug", "result": "failed", "code": 4713, "cause": "restart",
        "sentence": '"a mug" failed: the runtime ends', "reason": "the runtime ends",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("returned", "told"),
    [(True, "; the robot is back where it began"), (False, "; no way led back to where it began")],
)
def test_whether_it_is_back_where_it_began_is_told(returned: bool, told: str):
    end = GoalEnd(SearchState.FOUND, "found", at_xy=(1.0, 2.0), returned=returned)
    assert end.sentence("a mug", {"elapsed_s": 35.2, "driven_m": 1.0}).endswith(
        f"it took 35 s and 1.0 m{told}"
    )
    assert end.told("a1", "a mug", {})["returned"] is returned
    assert end.told("a1", "a mug", {})["at_xy"] == [1.0, 2.0]
    at_dock = replace(end, returned_to="dock").sentence("a mug", {})
    assert at_dock.endswith("; the robot is at dock" if returned else "; no way led to dock")
