"""A recorded search comes out again to the last bit, and what does not is told."""

from pathlib import Path

import pytest
from recorded_drive import recorded_drive

from runtime.core.voting import consensus
from runtime.errors import RecordingError
from runtime.replay import drive
from runtime.replay.drive import Replayed, replay
from runtime.replay.script import Script


@pytest.fixture(scope="module")
def recorded() -> Path:
    return recorded_drive()


def replayed(path: Path, *settings: str) -> Replayed:
    return replay(Script.open(path), None, settings)


def first(found: Replayed) -> str:
    assert not found.equal
    return found.differences.found[0].in_words()


def test_every_decision_and_command_comes_out_again(recorded: Path):
    again = replayed(recorded)
    assert again.equal, first(again)
    counts = again.differences.compared
    assert counts["command"] >= 20
    assert counts["decision"] == counts["question"] >= 1
    assert again.turns == counts["command"] + 2  # a goal, a cancel
    assert again.seconds > 0


def test_what_comes_out_otherwise_is_told_in_words(recorded: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(consensus, "agree", lambda sets, lenient=False: ("closest", frozenset()))
    told = first(replayed(recorded))
    assert "decision.chosen" in told
    assert " s: " in told
    assert told.startswith("turn ")


def test_another_setting_may_make_another_drive(recorded: Path):
    told = first(replayed(recorded, "map.max_depth_m=1.5"))
    assert "command." in told or "question" in told


def test_a_command_that_is_missing_is_a_difference(recorded: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(drive.Film, "record", lambda self, kind, value: None)
    again = replayed(recorded)
    assert "is nothing, was " in first(again)
    assert len(again.differences.found) >= again.differences.compared["command"]


def test_a_drive_that_was_cut_off_is_replayed_up_to_the_cut(recorded: Path, tmp_path: Path):
    whole, counts = recorded.read_bytes(), []
    for share in (0.5, 0.7, 0.99):
        path = tmp_path / "cut.mcap"
        path.write_bytes(whole[: round(share * len(whole))])
        script = Script.open(path)
        again = replay(script)
        assert script.recording.cut
        assert again.equal, first(again)
        counts.append(again.differences.compared["command"])
    assert counts == sorted(counts)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("camera.z_m=0.4",), "of another robot: camera.z_m is 0.88 there, 0.4 here"),
        (("robot.radius_m=0.3",), "of another robot: robot.radius_m is 0.18 there, 0.3 here"),
    ],
)
def test_a_recording_of_another_robot(recorded: Path, settings: tuple[str, ...], message: str):
    with pytest.raises(RecordingError) as told:
        replayed(recorded, *settings)
    assert message in str(told.value)


def test_a_recording_without_a_search():
    with pytest.raises(RecordingError, match="no search is in it"):
        replayed(recorded_drive(steps=0))
