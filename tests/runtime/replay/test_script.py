"""A recording as turns."""

from pathlib import Path

from recorded_drive import recorded_drive

from runtime.replay.script import Script


def test_what_was_heard_is_read_ahead_of_the_turns(tmp_path: Path):
    path = tmp_path / "cut.mcap"
    path.write_bytes(recorded_drive().read_bytes()[:-5000])
    script = Script.open(path)
    stamps = list(script.heard("looked"))
    assert not script.recording.cut  # that is told where the turns come to it
    turns = list(script.turns())
    assert script.recording.cut
    assert len(stamps) > 10
    assert stamps == [stamp for turn in turns for stamp in turn.heard["looked"]]
