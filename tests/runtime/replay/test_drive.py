"""A recorded search comes out again to the last bit, and what does not is told."""

from collections.abc import Callable
from pathlib import Path

import pytest
from recorded_drive import recorded_drive

from runtime.core.voting import prior
from runtime.errors import RecordingError
from runtime.recording.mcap_file import McapFile
from runtime.recording.reader import Recorded, messages
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
    assert len(again.elected) == counts["decision"]


def test_what_comes_out_otherwise_is_told_in_words(recorded: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(prior, "WEIGHTS", {"o2f": -3.0, "r2f": -3.0})
    told = first(replayed(recorded))
    assert "decision.in_words" in told
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


def copied(recorded: Path, path: Path, keep: Callable[[int, Recorded], bool]) -> Script:
    """The recording with those of its messages that are to be kept, by their number."""
    file = McapFile(path, {})
    for n, m in enumerate(messages(recorded)):
        if n == 0 or keep(n, m):
            file.write(m.topic, m.schema, m.log_time_ns, m.publish_time_ns, m.payload)
    file.close()
    return Script.open(path)


def test_what_begins_in_the_midst_of_a_search_is_not_replayed(recorded: Path, tmp_path: Path):
    script = copied(recorded, tmp_path / "late.mcap", lambda n, m: n > 60)
    with pytest.raises(RecordingError, match="begins in the midst of a search"):
        replay(script)


def test_the_next_search_of_such_a_recording_is(recorded: Path, tmp_path: Path):
    """As a ring has it: the end of one search, then another."""
    late = list(messages(recorded))[60:]
    file = McapFile(tmp_path / "ring.mcap", {})
    for m in (next(messages(recorded)), *late, *messages(recorded)):
        file.write(m.topic, m.schema, m.log_time_ns, m.publish_time_ns, m.payload)
    file.close()
    again = replay(Script.open(tmp_path / "ring.mcap"))
    assert again.equal, first(again)
    assert again.skipped > 3
    assert again.elected == replayed(recorded).elected


def test_what_the_recorder_lost_is_told_and_not_made_up(recorded: Path, tmp_path: Path):
    lost = [n for n, m in enumerate(messages(recorded)) if m.topic == "/loop/detections"][4]
    script = copied(recorded, tmp_path / "lossy.mcap", lambda n, m: n != lost)
    again = replay(script)
    assert not again.equal
    assert "the loop asks for detections, which was not asked for then" in again.stopped
    assert again.differences.compared["command"] == 4
