"""Files as the recorder leaves them, whole or not, and files that are none of its."""

import json
import struct
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from other_half import base_pose

from runtime.core.types import Pose
from runtime.errors import RecordingError
from runtime.recording.mcap_file import McapFile
from runtime.recording.reader import Recording, messages
from runtime.robot import wire


def written(path: Path, count: int = 5, **about: str) -> Path:
    file = McapFile(path, {"robot": "test", **about})
    for n in range(count):
        stamp_ns = 1_000 * (n + 1)
        payload = wire.encode_odometry(Pose(float(n), 0.0, 0.0), stamp_ns)
        file.write("/odom", wire.ODOMETRY, stamp_ns + 7, stamp_ns, payload)
        told = json.dumps({"name": "busy", "value": n}).encode()
        file.write("/rfnav/heard", "rfnav.Heard", stamp_ns + 8, stamp_ns + 8, told)
        file.flush()
    file.close()
    return path


def test_messages_come_back_as_they_were_written(tmp_path: Path):
    found = list(messages(written(tmp_path / "a.mcap")))
    assert [m.topic for m in found] == ["/odom", "/rfnav/heard"] * 5
    odometry, heard = found[2], found[3]
    assert base_pose(odometry.payload) == Pose(1.0, 0.0, 0.0)
    assert (odometry.log_time_ns, odometry.publish_time_ns) == (2_007, 2_000)
    assert odometry.schema == wire.ODOMETRY
    assert json.loads(heard.payload) == {"name": "busy", "value": 1}


def test_others_can_read_it_by_its_schemas(tmp_path: Path):
    with written(tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        schemas = {s.name: s for s in summary.schemas.values()}
        assert schemas[wire.ODOMETRY].encoding == "ros2msg"
        assert b"geometry_msgs/PoseWithCovariance pose" in schemas[wire.ODOMETRY].data
        assert json.loads(schemas["rfnav.Heard"].data)["type"] == "object"
        encodings = {c.topic: c.message_encoding for c in summary.channels.values()}
        assert encodings == {"/odom": "cdr", "/rfnav/heard": "json"}
        assert len(list(reader.iter_messages())) == 10


def test_a_file_that_was_cut_off_reads_up_to_the_cut(tmp_path: Path):
    whole = written(tmp_path / "a.mcap").read_bytes()
    everything = list(messages(tmp_path / "a.mcap"))
    counts = []
    for size in range(len(whole) // 8, len(whole), 97):
        cut = tmp_path / "cut.mcap"
        cut.write_bytes(whole[:size])
        recording = Recording(cut)
        found = list(recording)
        assert found == everything[: len(found)]
        assert recording.cut
        counts.append(len(found))
    assert counts == sorted(counts)
    assert {2, 6, 10} <= set(counts)
    recording = Recording(tmp_path / "a.mcap")
    assert list(recording) == everything
    assert not recording.cut


def test_damage_in_the_middle_ends_it_there(tmp_path: Path):
    path = written(tmp_path / "a.mcap")
    damaged = bytearray(path.read_bytes())
    at = damaged.index(b"\x28\xb5\x2f\xfd", len(damaged) // 3)  # where a zstd frame begins
    damaged[at + 40] ^= 0xFF
    path.write_bytes(damaged)
    recording = Recording(path)
    assert len(list(recording)) < 10
    assert recording.cut


@pytest.mark.parametrize("length", [2**40, 2**63 + 5])
def test_a_chunk_that_says_it_is_longer_than_memory_ends_it_there(length: int, tmp_path: Path):
    path = written(tmp_path / "a.mcap")
    everything = list(messages(path))
    damaged = bytearray(path.read_bytes())
    at = damaged.index(b"\x28\xb5\x2f\xfd")  # where a zstd frame begins, after its length
    damaged[at - 8 : at] = length.to_bytes(8, "little")
    path.write_bytes(damaged)
    recording = Recording(path)
    found = list(recording)
    assert found == everything[: len(found)]
    assert len(found) < len(everything)
    assert recording.cut


def test_a_message_that_says_it_is_shorter_than_its_own_head_ends_it_there(tmp_path: Path):
    path = tmp_path / "a.mcap"
    file = McapFile(path, {"robot": "test"})
    file.flush()
    whole = path.read_bytes()
    file.close()
    path.write_bytes(whole + struct.pack("<BQ", 5, 9) + bytes(40))
    recording = Recording(path)
    assert list(recording) == []
    assert recording.cut


@pytest.mark.parametrize("length", [2**40, 2**63 + 5])
def test_a_chunk_that_says_it_unpacks_to_more_than_memory_ends_it_there(
    length: int, tmp_path: Path
):
    path = written(tmp_path / "a.mcap")
    damaged = bytearray(path.read_bytes())
    at = damaged.index(b"\x28\xb5\x2f\xfd")
    before = 8 + 4 + len("zstd") + 4 + 8  # its length, the compression's name, a checksum
    damaged[at - before : at - before + 8] = length.to_bytes(8, "little")
    path.write_bytes(damaged)
    recording = Recording(path)
    assert len(list(recording)) < 10
    assert recording.cut


def test_a_frame_that_says_it_unpacks_to_more_than_memory_ends_it_there(tmp_path: Path):
    path = written(tmp_path / "a.mcap")
    bomb = b"\x28\xb5\x2f\xfd\xe0" + (2**40).to_bytes(8, "little")  # 1 TB, says its head
    damaged = bytearray(path.read_bytes())
    at = damaged.index(b"\x28\xb5\x2f\xfd")
    damaged[at : at + len(bomb)] = bomb
    path.write_bytes(damaged)
    recording = Recording(path)
    assert len(list(recording)) < 10
    assert recording.cut


def test_what_follows_a_cut_in_a_folder_is_left_out(tmp_path: Path):
    for name in "abc":
        written(tmp_path / f"{name}.mcap")
    cut = tmp_path / "b.mcap"
    cut.write_bytes(cut.read_bytes()[: cut.stat().st_size // 4])
    recording = Recording(tmp_path)
    early = iter(recording)
    assert len([next(early) for _ in range(10)]) == 10
    found = list(recording)
    assert 10 <= len(found) < 20
    assert recording.cut
    assert len([*early]) == len(found) - 10  # whoever had read less by then comes as far


def foreign(path: Path) -> None:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (lambda path: path.write_bytes(b""), "is empty: nothing was recorded"),
        (lambda path: path.write_bytes(b"PK\x03\x04 a zip"), "not a recording of rfnav"),
        (lambda path: path.write_bytes(b"\x89MCAP0\r\n\x01"), "cut off at once"),
        (lambda path: written(path, format="0", version="9.1"), "of format 0, this reads 1"),
        (lambda path: None, "cannot be read (No such file"),
        (foreign, "an MCAP file, but not a recording of rfnav"),
    ],
)
def test_what_is_no_recording_is_told_in_a_line(content, message: str, tmp_path: Path):
    path = tmp_path / "a.mcap"
    content(path)
    with pytest.raises(RecordingError) as told:
        list(messages(path))
    assert message in str(told.value)
    assert str(told.value).startswith(str(path))
    assert "\n" not in str(told.value)
