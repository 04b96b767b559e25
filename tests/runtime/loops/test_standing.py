"""One word for how the runtime stands, and what is told of it."""

import math
from dataclasses import replace

import pytest

from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import Halt, HaltKind, Odometry
from runtime.core.types import Pose, SearchState, Twist
from runtime.loops.standing import (
    KEPT,
    Change,
    Changes,
    Occasion,
    RunStanding,
    RunState,
    forbids,
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
        (
            ("", None, WELL, HALT, SEARCHING, {"paused": "paused by X"}, True),
            "paused",
            "paused by X",
        ),
        (("", None, WELL, None, READY, {"paused": "paused by X"}, True), "ready", ""),
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


def test_all_of_the_state_is_told():
    base = replace(WELL, held="not armed", battery_percent=40.0)
    odometry = Odometry(Pose(1.23456, -2.34567, 0.98764), 77, 5.0)
    caution = Caution(HaltKind.OBSTACLE, "something 0.50 m ahead", 0.125)
    standing = RunStanding(RunState.HELD, "base: base: not armed")
    twist = Twist(0.123456, -0.654321)
    assert told_state(SEARCHING, standing, HALT, twist, odometry, base, caution) == {
        "state": SEARCHING,
        "runtime": {"state": RunState.HELD, "cause": "base: base: not armed"},
        "halt": "no odometry for 0.4 s",
        "v_mps": 0.1235,
        "w_radps": -0.6543,
        "pose": [1.2346, -2.3457, 0.9876],
        "odom_stamp_ns": 77,
        "base": vars(base),
        "caution": {
            "kind": HaltKind.OBSTACLE, "reason": "something 0.50 m ahead", "most_mps": 0.125,
        },
    }  # fmt: skip


def test_what_is_not_known_is_told_as_such():
    told = told_state(READY, RunStanding(RunState.READY), None, STILL, None, WELL, FREE)
    assert (told["halt"], told["pose"], told["odom_stamp_ns"]) == ("", None, None)


def test_a_standing_in_words():
    assert RunStanding(RunState.READY).in_words() == "ready"
    assert RunStanding(RunState.FAULT, "a bug").in_words() == "fault: a bug"


@pytest.mark.parametrize("rung", ["embedding", "counts alone", "none"])
def test_a_rung_without_a_language_model_is_degraded(rung):
    known = "", None, WELL, None, SEARCHING
    assert stands(*known, {"rung": rung}, True) == RunStanding(RunState.DEGRADED, f"rung: {rung}")
    assert stands(*known, {}, True, "no guard") == RunStanding(RunState.DEGRADED, "no guard")


def test_what_the_base_says_is_a_reason_not_to_drive():
    assert forbids(WELL) is None
    assert forbids(replace(WELL, held="not armed")) == Halt(HaltKind.BASE, "base: not armed")
    both = replace(WELL, held="not armed", hand="sticks")
    assert forbids(both) == Halt(HaltKind.HAND, "a hand has the sticks: sticks")


def test_a_change_is_of_the_state_or_of_its_cause_but_for_the_numbers_of_what_holds_it():
    told = [
        RunStanding(RunState.STARTING),
        RunStanding(RunState.DEGRADED, "shed: 1 of 3"),
        RunStanding(RunState.DEGRADED, "shed: 2 of 3"),
        RunStanding(RunState.HELD, "frame: none for 0.5 s"),
        RunStanding(RunState.HELD, "frame: none for 12.0 s"),
        RunStanding(RunState.HELD, "plan: the plan is 2.1 s old"),
        RunStanding(RunState.PAUSED, "plan: the plan is 2.1 s old"),
    ]
    changes = Changes()
    assert changes.now == told[0]
    for n, standing in enumerate(told[1:], 1):
        changes.note(float(n), standing)
        assert changes.now is standing
    assert changes.take() == tuple(Change(float(n), told[n - 1], told[n]) for n in (1, 2, 3, 5, 6))


@pytest.mark.parametrize(
    ("report", "cause"),
    [
        ({"shed": "no second looks"}, "no second looks"),
        ({"unstamped": ("odom",)}, "stamps stand still: odom"),
        (
            {"rung": "none", "shed": "no second looks", "unstamped": ("odom", "depth")},
            "rung: none, no second looks, stamps stand still: odom, depth",
        ),
    ],
)
def test_all_that_it_lacks_is_said(report, cause):
    known = "", None, WELL, None, SEARCHING
    assert stands(*known, report, True) == RunStanding(RunState.DEGRADED, cause)


def test_lateness_is_told_to_the_hundredth_of_a_millisecond():
    told = late_told([0.00123456, 0.00123456, 0.00323456])["tick_late_ms"]
    assert told == {"p50": 1.23, "p99": 3.19, "max": 3.23, "ticks": 3}
