"""What is counted, told and remembered for those who watch over the service."""

import json
from typing import Any

import numpy as np
import pytest
from manual_clock import ManualClock

from runtime.core.types import Absence, Ballot, Brief, Frontier, FrontierBrief, Missing, Vote
from runtime.core.voting.consensus import ConsensusConfig, elect
from runtime.log import DEBUG, ERROR, INFO, NOTICE, WARNING
from runtime.loops.standing import RunState
from runtime.robot.requests import Request
from runtime.service import telemetry as module
from runtime.service.telemetry import EVERY_S, KINDS_KEPT, PRIORITIES, Telemetry, memory_bytes

FRONTIER = Frontier(7, np.array([[1.0, 2.0]]), (1.0, 2.0), 1.5)
BRIEF = Brief("mug", 0, (FrontierBrief(7, 1.5, (), ()),))


class Log:
    """What was said, with what."""

    def __init__(self) -> None:
        self.lines: list[tuple[str, int, dict[str, str]]] = []

    def __call__(self, line: str, priority: int = INFO, **fields: str) -> None:
        self.lines.append((line, priority, fields))


def ballot(*rungs: str) -> Ballot:
    votes = tuple(Vote(f"e{n}", (7,), ((7, 1.0),), "so", rung) for n, rung in enumerate(rungs))
    return Ballot(votes, (Missing("sle", Absence.LATE),))


def decided(telemetry: Telemetry, *rungs: str) -> None:
    decision = elect(
        ballot(*rungs), BRIEF.frontiers, ConsensusConfig(mode="strict"), 0, "first decision"
    )
    telemetry.decided(3, "mug", decision, BRIEF, (FRONTIER,), 7, 1.0)


def test_a_search_is_told_from_its_goal_to_its_result():
    log = Log()
    telemetry = Telemetry(ManualClock(), tell=log)
    telemetry.began("a mug", "as it is", "g1")
    decided(telemetry, "local")
    telemetry.stood(2.0, "searching", "held", "frame: no frame")
    telemetry.stood(3.0, "held: frame: no frame", "searching", "")
    telemetry.ended("found", "the mug is here")
    telemetry.stood(4.0, "searching", "ready", "")
    assert log.lines == [
        ('goal "a mug": as it is', INFO, {"EVENT": "goal", "GOAL_ID": "g1"}),
        (
            "decision 3: frontier 7, the closest, as e0 votes alone (sle: late)",
            DEBUG,
            {"EVENT": "decision", "GOAL_ID": "g1", "DECISION": "3"},
        ),
        (
            "searching -> held: frame: no frame",
            WARNING,
            {
                "EVENT": "halt",
                "GOAL_ID": "g1",
                "HALT": "frame",
                "STATE": "held",
                "CAUSE": "frame: no frame",
            },
        ),
        (
            "held: frame: no frame -> searching",
            INFO,
            {"EVENT": "standing", "GOAL_ID": "g1", "STATE": "searching", "CAUSE": ""},
        ),
        (
            "found: the mug is here",
            NOTICE,
            {"EVENT": "result", "GOAL_ID": "g1", "RESULT": "found"},
        ),
        ("searching -> ready", INFO, {"EVENT": "standing", "STATE": "ready", "CAUSE": ""}),
    ]


def test_a_fault_is_an_error_and_every_state_of_note_is_one_that_there_is():
    log = Log()
    Telemetry(ManualClock(), tell=log).stood(0.0, "ready", "fault", "it broke")
    assert log.lines[0][1] == ERROR
    assert set(PRIORITIES) <= {state.value for state in RunState}


def test_without_anybody_who_watches_nothing_is_due():
    clock = ManualClock()
    telemetry = Telemetry(clock, tell=Log())
    clock.advance(2 * EVERY_S)
    assert not telemetry.due()


def test_what_is_watched_is_of_one_moment():
    clock = ManualClock()
    telemetry = Telemetry(clock, watched=True, tell=Log())
    assert not telemetry.due()
    clock.advance(EVERY_S)
    assert telemetry.due()
    decided(telemetry, "local", "cloud")
    telemetry.ended("found", "here")
    telemetry.note({"state": "ready"})
    assert not telemetry.due()
    newest = telemetry.newest
    assert newest.at_s == clock.now_s()
    assert newest.status == {"state": "ready"}
    assert newest.votes == {("e0", "local"): 1, ("e1", "cloud"): 1}
    assert newest.absences == {("sle", "late"): 1}
    assert (newest.decisions, newest.results) == (1, {"found": 1})
    decided(telemetry, "local")
    assert newest.votes[("e0", "local")] == 1  # as it was
    telemetry.note({})
    assert telemetry.newest.votes[("e0", "local")] == 2


def test_the_status_has_the_counts_and_the_memory():
    clock = ManualClock()
    telemetry = Telemetry(clock, tell=Log())
    clock.advance(12.0)
    decided(telemetry, "local", "cloud")
    told = telemetry.told()
    assert told["votes"] == {"e0": {"local": 1}, "e1": {"cloud": 1}}
    assert told["absences"] == {"sle": {"late": 1}}
    assert (told["up_s"], told["now_s"]) == (12.0, clock.now_s())
    assert told["memory_mb"] == pytest.approx(memory_bytes() / 1e6, rel=0.2)
    assert memory_bytes() > 10e6


def test_where_nobody_tells_the_memory_it_is_0(monkeypatch: pytest.MonkeyPatch):
    def unread(self: object, **_: object) -> str:
        raise OSError("no such file")

    monkeypatch.setattr(module.Path, "read_text", unread)
    assert memory_bytes() == 0


def test_pairs_without_end_are_not_all_counted():
    telemetry = Telemetry(ManualClock(), tell=Log())
    for n in range(KINDS_KEPT + 5):
        decided(telemetry, f"rung{n}")
    assert len(telemetry.told()["votes"]["e0"]) == KINDS_KEPT
    decided(telemetry, "rung0")
    assert telemetry.told()["votes"]["e0"]["rung0"] == 2


class Query:
    def __init__(self) -> None:
        self.answers: list[dict[str, Any]] = []

    def reply(self, key: str, answer: str) -> None:
        self.answers.append(json.loads(answer))

    def drop(self) -> None:
        """Nothing is held."""


def test_what_it_does_now_is_told_while_a_search_is_on():
    telemetry = Telemetry(ManualClock(), tell=Log())
    request = Request("why", {}, Query(), "rfnav/why")
    assert telemetry.why(request)["now"] == "no search"
    telemetry.does("look at mug 7 (0.61)")
    assert telemetry.why(request)["now"] == telemetry.told()["does"] == "look at mug 7 (0.61)"
    decided(telemetry, "local")
    assert "now" not in telemetry.why(Request("why", {"decision": 3}, Query(), "rfnav/why"))
    telemetry.ended("found", "here")
    assert telemetry.told()["does"] == ""


def test_why_is_answered_and_what_cannot_be_is_refused():
    telemetry, query = Telemetry(ManualClock(), tell=Log()), Query()
    decided(telemetry, "local")
    request = Request("why", {}, query, "rfnav/why")
    request.reply(telemetry.why(request))
    assert query.answers[0]["decision"]["in_words"][0] == (
        'Decision 3 of the search for "mug", 1 s into it.'
    )
    request = Request("why", {"decision": 4}, query, "rfnav/why")
    assert telemetry.why(request) == {
        "accepted": False, "error": "why: decision 4: there is none yet; the last is 3",
    }  # fmt: skip
