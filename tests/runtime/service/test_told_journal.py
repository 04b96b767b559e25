"""Decisions and stops of a journal, told again as they were told while they happened."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from runtime.core.belief import Ahead
from runtime.core.motion.stops import BaseStop
from runtime.core.types import (
    Absence,
    Ballot,
    Brief,
    Frontier,
    FrontierBrief,
    Missing,
    NearbyObject,
    Vote,
)
from runtime.core.voting.consensus import ConsensusConfig, elect
from runtime.core.voting.in_full import ToldDecision, in_full
from runtime.errors import RecordingError
from runtime.journal import Journal
from runtime.loops.reports import explain
from runtime.service.told_journal import told_decisions, told_stops

SEEN = FrontierBrief(
    7, 4.0, (NearbyObject("sink", 0.8, 0.6),), (("bathroom", 0.7),), np.ones(3, np.float32),
    b"a picture", True, 3.0,
)  # fmt: skip
BRIEF = Brief("mug", 5, (FrontierBrief(3, 1.0, (), ()), SEEN), (7, 3))
VOTE = Vote("o2f", (7,), ((3, 0.2), (7, 0.8)), "7: sink", "cloud", (3,), ((7, "sink (0.80)"),))
BALLOT = Ballot((VOTE,), (Missing("sle", Absence.ERROR, "it broke"),), {"o2f": 0.25})
FRONTIERS = tuple(
    Frontier(id, np.array([[x, 0.0]]), (x, 0.5), far)
    for id, x, far in ((3, 1.0, 1.0), (7, 3.0, 4.0))
)


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    path = tmp_path / "decisions.jsonl"
    world = SimpleNamespace(body=SimpleNamespace(step=9), frontiers=FRONTIERS)
    decision = elect(BALLOT, BRIEF.frontiers, ConsensusConfig(mode="lenient"), 5, "new evidence")
    with Journal(path) as file:
        file.write("goal", text="my mug", name="mug", how="as it is", episode=None)
        file.write("standing", at_s=1.0, was="ready", now="searching")
        file.write("decision", brief=BRIEF, **explain(decision, world, "nearest"))
        file.write("standing", at_s=2.0, was="searching", now="held: frame: no frame")
        file.write("standing", at_s=3.5, was="held: frame: no frame", now="searching")
        file.write("decision", brief=BRIEF, **explain(decision, world, "nearest"))
        file.write("standing", at_s=5.0, was="searching", now="stopped: by hand")
    return path


def test_a_decision_is_told_as_it_was_told_then(journal: Path):
    first, second = told_decisions(journal)
    decision = elect(BALLOT, BRIEF.frontiers, ConsensusConfig(mode="lenient"), 5, "new evidence")
    at = {f.id: f.goal_xy for f in FRONTIERS}
    then = ToldDecision(1, "my mug", decision, BRIEF, at, 7)
    assert in_full(first) == in_full(then)
    assert "Look of the view (sle): does not vote: error: it broke." in in_full(first)
    assert second.number == 2


def test_stops_are_told_with_their_times(journal: Path):
    assert tuple(told_stops(journal)) == (
        BaseStop(1, "held", "frame", "no frame", 2.0, 3.5, "searching"),
        BaseStop(2, "stopped", "stop", "by hand", 5.0),
    )


def test_one_that_nothing_stopped_and_one_cut_off_are_read(tmp_path: Path, journal: Path):
    path = tmp_path / "cut.jsonl"
    path.write_bytes(b'{"kind": "goal", "text": "mug"}\n{"kind": "decision", "vo')
    assert not list(told_decisions(path))
    assert not list(told_stops(path))
    held = b'{"kind": "standing", "at_s": 1, "now": "held: x"}\n'
    path.write_bytes(held + b'{"kind": "standing", "at_s": 2, "now": "ready"}\n')
    assert [stop.ended_s for stop in told_stops(path)] == [2.0]


def test_nothing_decided_is_nowhere_to_go(tmp_path: Path):
    path = tmp_path / "decisions.jsonl"
    world = SimpleNamespace(body=SimpleNamespace(step=9), frontiers=())
    decision = elect(Ballot(), (), ConsensusConfig(mode="strict"))
    with Journal(path) as file:
        file.write("goal", text="mug")
        file.write("decision", brief=Brief("mug", 0, ()), **explain(decision, world, "nearest"))
    [told] = told_decisions(path)
    assert (told.decision.frontier, told.heads_for) == (None, None)


@pytest.mark.parametrize(
    ("part", "value"),
    [
        ("votes", [3]), ("votes", {}), ("votes", [{ "expert": 3}]), ("missing", [{}]),
        ("frontier", "7"), ("rule", None), ("chosen", [True]), ("latency_s", []),
        ("latency_s", {"o2f": "x"}), ("without", 3), ("without", {"o2f": "x"}), ("brief", None),
        ("brief", {"frontiers": [{"id": 1}]}), ("frontiers", [{"id": 1, "goal_xy": [1]}]),
        ("frontiers", [{"id": 1}]), ("closest", 1.5), ("why", 0), ("heads_for", True),
        ("chosen", [0] * 10_001),
    ],
)  # fmt: skip
def test_a_line_that_rfnav_does_not_write_is_refused_with_its_place(
    journal: Path, part: str, value: object
):
    lines = [json.loads(line) for line in journal.read_text().splitlines()]
    lines[2][part] = value
    journal.write_text("".join(json.dumps(line) + "\n" for line in lines))
    with pytest.raises(RecordingError, match=r"decisions.jsonl: line 3: \w+: is not as rfnav"):
        list(told_decisions(journal))


@pytest.mark.parametrize(
    ("part", "value"),
    [("reasons", [["7", "x"]]), ("reasons", [[7]]), ("probabilities", [[1, 2, 3]])],
)
def test_so_is_a_vote(journal: Path, part: str, value: object):
    lines = [json.loads(line) for line in journal.read_text().splitlines()]
    lines[2]["votes"][0][part] = value
    journal.write_text("".join(json.dumps(line) + "\n" for line in lines))
    with pytest.raises(RecordingError, match="line 3"):
        list(told_decisions(journal))


def test_and_what_was_known_of_a_frontier(journal: Path):
    lines = [json.loads(line) for line in journal.read_text().splitlines()]
    lines[2]["brief"]["frontiers"][1]["rooms"] = [["bathroom"]]
    journal.write_text("".join(json.dumps(line) + "\n" for line in lines))
    with pytest.raises(RecordingError, match="line 3: rooms"):
        list(told_decisions(journal))


def test_a_file_that_is_none_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(RecordingError, match="cannot be read"):
        list(told_decisions(tmp_path / "none.jsonl"))
    path = tmp_path / "other.jsonl"
    path.write_text("not JSON\n")
    with pytest.raises(RecordingError, match="line 1: not JSON"):
        list(told_stops(path))
    monkeypatch.setattr("runtime.service.told_journal.LINE_BYTES", 10)
    path.write_text("x" * 30)
    with pytest.raises(RecordingError, match="line 1: is no line of a journal"):
        list(told_stops(path))


def test_a_planned_decision_is_told_with_its_order_and_its_belief(tmp_path: Path):
    first_m = np.array([1.0, 4.0])
    between_m = np.array([[0.0, 5.0], [5.0, 0.0]])
    at, areas = ((1.0, 0.5), (3.0, 0.5)), (1.0, 3.0)
    ahead = Ahead((3, 7), at, areas, np.array(areas), first_m, between_m)
    cfg = ConsensusConfig(mode="prior", fallback="ahead")
    said = replace(VOTE, nats=((3, -1.0), (7, 1.0)))
    decision = elect(Ballot((said,)), BRIEF.frontiers, cfg, 5, "due", (3, 7), ahead)
    path, world = tmp_path / "d.jsonl", SimpleNamespace(body=SimpleNamespace(step=9), frontiers=())
    with Journal(path) as file:
        file.write("goal", text="mug", name="mug", how="as it is", episode=None)
        brief = replace(BRIEF, ahead=ahead)
        file.write("decision", brief=brief, **explain(decision, world, "nearest"))
    (told,) = told_decisions(path)
    assert told.decision.order == decision.order
    assert told.decision.belief is not None
    assert decision.belief is not None
    assert decision.taken is not None
    assert [p.id for p in told.decision.belief.places] == [p.id for p in decision.belief.places]
    assert told.decision.belief.elsewhere == pytest.approx(decision.belief.elsewhere, abs=0.001)
    took = told.decision.taken
    assert took is not None
    assert took == replace(decision.taken, share=took.share, said=took.said)
    assert [one.expert for one in took.said] == ["o2f"]
    assert took.share == pytest.approx(decision.taken.share, abs=0.001)
    line = json.loads(path.read_text().splitlines()[1])
    assert line["votes"][0]["nats"] == [[3, -1.0], [7, 1.0]]
    assert "ahead" not in line["brief"]
    for wrong in (7, {**line["taken"], "way_m": "far"}, {**line["taken"], "said": [{}]}):
        path.write_text(json.dumps({**line, "taken": wrong}) + "\n")
        with pytest.raises(RecordingError, match=r"line 1: .* is not as rfnav writes it"):
            list(told_decisions(path))
    line["belief"]["places"][0]["kind"] = "dream"
    path.write_text(json.dumps(line) + "\n")
    with pytest.raises(RecordingError, match="belief: is not as rfnav writes it"):
        list(told_decisions(path))
