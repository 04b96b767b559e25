"""One word for how the runtime stands, and what is told of it."""

import math
from dataclasses import replace

import pytest

from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import Halt, HaltKind
from runtime.core.types import SearchState
from runtime.loops.standing import (
    KEPT,
    Changes,
    Occasion,
    RunStanding,
    RunState,
    late_told,
    stands,
    told_state,
)
from runtime.robot.base import WELL

HALT = Halt(HaltKind.ODOMETRY, "no odometry for 0.4 s")
STOP = Halt(HaltKind.STOP, "by bumper_stop")
HAND = replace(WELL, hand="sticks")
SEARCHING, READY = SearchState.SEARCHING, SearchState.READY


@pytest.mark.parametrize(
    ("known", "state", "cause"),
    [
        (("", None, WELL, None, READY, {}, False), "starting", ""),
        (("", None, WELL, None, READY, {}, True), "ready", ""),
        (("", None, WELL, None, SearchState.FOUND, {}, True), "ready", ""),
        (("", None, WELL, None, SEARCHING, {"rung": "smollm2"}, True), "searching", ""),
        (("", None, WELL, None, SEARCHING, {"rung": "none"}, True), "degraded", "rung: none"),
        (("", None, WELL, HALT, SEARCHING, {}, True), "held", "odometry: no odometry for 0.4 s"),
        (("", None, HAND, HALT, SEARCHING, {}, True), "paused", "a hand has the sticks: sticks"),
        (("", STOP, HAND, HALT, SEARCHING, {}, True), "stopped", "by bumper_stop"),
        (("", STOP, WELL, None, READY, {}, False), "stopped", "by bumper_stop"),
        (("a bug", STOP, HAND, HALT, SEARCHING, {}, True), "fault", "a bug"),
    ],
)
def test_what_matters_most_is_said(known, state, cause):
    assert stands(*known) == RunStanding(RunState(state), cause)


def test_a_search_that_nobody_watches_over_is_degraded():
    known = "", None, WELL, None, SEARCHING, {"rung": "none"}, True
    assert stands(*known, "the guard is gone").cause == "rung: none, the guard is gone"


def test_what_is_shed_is_what_a_search_has_less_of():
    shed = "shed to be in time: one look of the detectors in 2"
    known = "", None, WELL, None, SEARCHING, {"rung": "smollm2", "shed": shed}, True
    assert stands(*known) == RunStanding(RunState.DEGRADED, shed)
    known = *known[:5], {"rung": "none", "shed": shed}, True
    assert stands(*known, "the guard is gone").cause == f"rung: none, {shed}, the guard is gone"


def test_a_robot_that_stamps_nothing_is_watched_over_less():
    report = {"rung": "smollm2", "shed": "", "unstamped": ("depth", "odom")}
    known = "", None, WELL, None, SEARCHING, report, True
    assert stands(*known) == RunStanding(RunState.DEGRADED, "stamps stand still: depth, odom")


def test_another_thing_that_is_lacking_is_another_standing():
    changes = Changes()
    changes.note(1.0, RunStanding(RunState.DEGRADED, "rung: none"))
    changes.note(2.0, RunStanding(RunState.DEGRADED, "rung: none, the guard is gone"))
    changes.note(3.0, RunStanding(RunState.DEGRADED, "rung: none, the guard is gone"))
    assert [change.now_s for change in changes.take()] == [1.0, 2.0]


def test_changes_are_told_once_and_an_age_that_grows_is_none():
    changes = Changes()
    changes.note(1.0, RunStanding(RunState.SEARCHING))
    changes.note(2.0, RunStanding(RunState.HELD, "odometry: none for 0.4 s"))
    changes.note(2.1, RunStanding(RunState.HELD, "odometry: none for 0.5 s"))
    changes.note(3.0, RunStanding(RunState.HELD, "frame: none"))
    told = [(c.now_s, c.before.state, c.after.in_words()) for c in changes.take()]
    assert told == [
        (1.0, "starting", "searching"),
        (2.0, "searching", "held: odometry: none for 0.4 s"),
        (3.0, "held", "held: frame: none"),
    ]
    assert changes.take() == ()


def test_no_more_changes_are_kept_than_anybody_wants():
    changes = Changes()
    for n in range(3 * KEPT):
        changes.note(n, RunStanding((RunState.SEARCHING, RunState.READY)[n % 2]))
    assert len(changes.take()) == KEPT


def test_the_state_is_told_at_changes_and_every_so_many_turns():
    occasion = Occasion(3)
    assert [occasion.comes("a") for _ in range(7)] == [True, False, False, True, False, False, True]
    assert occasion.comes("b")
    assert not occasion.comes("b")


def test_what_is_told_is_json_whatever_depth_allows():
    known = SEARCHING, RunStanding(RunState.SEARCHING), None, STILL, None, WELL
    assert told_state(*known, FREE)["caution"] is None
    slow = told_state(*known, Caution(HaltKind.FLOOR, "no floor", math.inf, 0.0))["caution"]
    assert slow == {"kind": "floor", "reason": "no floor", "most_mps": None}


def test_lateness_in_milliseconds():
    assert late_told(()) == {}
    told = late_told([0.001] * 99 + [0.1])["tick_late_ms"]
    assert told == {"p50": 1.0, "p99": pytest.approx(1.99), "max": 100.0, "ticks": 100}
