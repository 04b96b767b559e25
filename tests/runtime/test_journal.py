"""A journal survives a crash line by line; a map comes back as it was written."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from full_disk import largest_file
from sighted import sight

from runtime.core.types import Absence, Action, Ballot, Decision, FrontierBrief, Missing, Vote
from runtime.errors import ConfigError
from runtime.journal import Journal, plain, read_journal, read_map, write_map


@dataclass(frozen=True)
class Leaf:
    a: np.ndarray
    b: float


def test_lines_are_on_disk_as_soon_as_they_are_written(tmp_path: Path) -> None:
    path = tmp_path / "run" / "decisions.jsonl"
    with Journal(path) as journal:
        journal.write("step", stamp_ns=np.int64(5), action=Action.STOP, xy=np.zeros(2, np.float32))
        assert list(read_journal(path)) == [
            {"kind": "step", "stamp_ns": 5, "action": "stop", "xy": [0.0, 0.0]}
        ]
    with Journal(path) as journal:  # appended to, not begun anew
        journal.write("end")
    assert [line["kind"] for line in read_journal(path)] == ["step", "end"]


def test_a_torn_last_line_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "decisions.jsonl"
    path.write_text('{"kind": "step"}\n{"kind": "st')
    assert [line["kind"] for line in read_journal(path)] == ["step"]


def test_a_whole_decision_has_a_json_form() -> None:
    late = Missing("sle", Absence.LATE)
    ballot = Ballot((Vote("o2f", (1,), ((1, 0.5),), "x"),), (late,), {"o2f": 0.1})
    line = plain(Decision(1, "lone", (1,), 2, ballot, 7, "start"))
    assert json.loads(json.dumps(line))["ballot"]["missing"] == [{"expert": "sle", "cause": "late"}]


def test_the_evidence_of_who_prefers_none_is_told() -> None:
    leans = Missing("r2f", Absence.NO_PREFERENCE, nats=((1, -0.2), (2, 0.2)))
    told = {"expert": "r2f", "cause": "no preference", "nats": [[1, -0.2], [2, 0.2]]}
    assert json.loads(json.dumps(plain(Ballot((), (leans,), {}))))["missing"] == [told]


def test_plain_values() -> None:
    assert plain(Leaf(np.array([[1.5, np.nan]]), np.inf)) == {"a": [[1.5, None]], "b": None}
    assert plain({1: (np.bool_(True), Path("x")), "s": {3, 1}}) == {"1": [True, "x"], "s": [1, 3]}
    assert plain({"image": b"abc"}) == {"image": 3}
    with pytest.raises(TypeError, match="a object has no JSON form"):
        plain(object())


def test_what_a_keyframe_shows_has_no_place_in_it() -> None:
    told = plain(FrontierBrief(1, 2.0, (), (), sight=sight(0.5)))
    assert "sight" not in told
    assert told["unknown_m2"] == 0.0


def test_a_directory_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match=r"file/x/decisions.jsonl: cannot be written"):
        Journal(tmp_path / "file" / "x" / "decisions.jsonl")


def test_map_round_trip(tmp_path: Path) -> None:
    grid = np.arange(12, dtype=np.uint8).reshape(3, 4)
    meta = {"goal": "toilet", "origin_m": (0.5, -1.0), "names": ["sofa"], "best": np.float32(0.5)}
    for _ in range(2):
        path = write_map(tmp_path / "run", {"grid": grid}, meta)
    assert [entry.name for entry in path.parent.iterdir()] == ["map.npz"]
    arrays, got = read_map(tmp_path / "run")
    np.testing.assert_array_equal(arrays["grid"], grid)
    assert got == {"goal": "toilet", "origin_m": [0.5, -1.0], "names": ["sofa"], "best": 0.5}


def test_what_a_full_disk_does_not_take_is_lost_said_once_and_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "decisions.jsonl"
    with Journal(path) as journal, largest_file(4096):
        for n in range(200):
            journal.write("step", n=n, text="x" * 100)
        full = "No space left on device"
        assert journal.lost == f"{path}: cannot be written ({full}): lines are lost"
    assert capsys.readouterr().err == f"rfnav: {journal.lost}\n"
    kept = list(read_journal(path))  # whole lines all
    assert [line["n"] for line in kept] == list(range(len(kept)))
    with Journal(path) as journal:
        with largest_file(path.stat().st_size + 10):
            journal.write("step", n=-1)
        journal.write("end")  # there is room again
        journal.write("after")
    assert list(read_journal(path))[len(kept) :] == [
        {"kind": "lost", "lines": 1}, {"kind": "end"}, {"kind": "after"}
    ]  # fmt: skip


def test_a_journal_that_is_not_kept() -> None:
    with Journal(None) as journal:
        journal.write("step")
        assert journal.lost == "the journal is not kept"


def test_a_map_that_a_full_disk_does_not_take_leaves_nothing(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 255, 100_000, dtype=np.uint8)
    with largest_file(4096), pytest.raises(OSError, match="File too large"):
        write_map(tmp_path, {"noise": noise}, {})
    assert list(tmp_path.iterdir()) == []
