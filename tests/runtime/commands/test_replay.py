"""What `rfnav replay` says, and how it ends."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from places import TESTS
from recorded_drive import recorded_drive

from runtime.__main__ import cli
from runtime.errors import RecordingError
from runtime.recording.mcap_file import McapFile
from runtime.recording.reader import messages
from runtime.robot import wire


@pytest.fixture(scope="module")
def recorded() -> Path:
    return recorded_drive()


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["replay", *map(str, arguments)])


def test_equal_is_exit_0(recorded: Path):
    done = run(recorded)
    assert done.exit_code == 0, done.output
    assert re.match(r"equal in \d+ turns: \d+ commands, \d+ decisions, ", done.output)


def test_a_difference_is_exit_1_and_diff_tells_more(recorded: Path):
    done = run(recorded, "--set", "map.max_depth_m=1.5")
    assert done.exit_code == 1
    first, more, *_ = done.output.splitlines()
    assert first.startswith("differs first in turn ")
    assert more.startswith("and ")
    told = run(recorded, "--set", "map.max_depth_m=1.5", "--diff").output.splitlines()
    assert told[0] == first
    assert len(told) > 5


def test_info_says_what_takes_how_much_room(recorded: Path):
    done = run(recorded, "--info")
    assert done.exit_code == 0, done.output
    head, size, *topics = done.output.splitlines()
    assert "lockstep" in head
    assert "MB a minute" in size
    assert any(line.endswith("/camera/depth/image_raw  sensor_msgs/msg/Image") for line in topics)


def test_what_a_terminal_would_obey_is_not_printed(recorded: Path, tmp_path: Path):
    path = tmp_path / "strange.mcap"
    file = McapFile(path, {"loop": "\x1b[2J", "began": "then", "colour": "\x9b31m"})
    for m in messages(recorded):
        file.write(f"{m.topic}\x07", m.schema, m.log_time_ns, m.publish_time_ns, m.payload)
    file.close()
    told = run(path, "--info").output
    assert all(line.isprintable() for line in told.splitlines())
    assert "[2J" in told


def test_what_is_no_recording_is_an_error(tmp_path: Path):
    (tmp_path / "a.mcap").write_bytes(b"")
    done = run(tmp_path / "a.mcap")
    assert isinstance(done.exception, RecordingError)
    assert "is empty" in str(done.exception)
    assert isinstance(run(tmp_path / "b.mcap", "--info").exception, RecordingError)
    (tmp_path / "folder").mkdir()
    assert "no .mcap file is in it" in str(run(tmp_path / "folder").exception)


def test_models_have_nothing_to_look_at_without_colour(recorded: Path, tmp_path: Path):
    path = tmp_path / "dark.mcap"
    file = McapFile(path, {"colour": "none"})
    for m in messages(recorded):
        if m.schema != wire.COMPRESSED_IMAGE:
            file.write(m.topic, m.schema, m.log_time_ns, m.publish_time_ns, m.payload)
    file.close()
    told = run(path, "--models").exception
    assert isinstance(told, RecordingError)
    assert "dark.mcap: has no colour" in str(told)
    assert run(path).exit_code == 0


def test_an_obstacle_before_the_camera_is_told_of(recorded: Path):
    done = run(TESTS / "refs/realtime.mcap", "--obstacle")
    assert done.exit_code == 0, done.output
    assert re.match(r"an obstacle held before the camera: stood in (\d+) of \1 turns", done.output)
    lockstep = run(recorded, "--obstacle")
    assert isinstance(lockstep.exception, RecordingError)
    assert "in lockstep no reflex drives" in str(lockstep.exception)
