"""Whole drives are never overwritten; a ring keeps what a fault needs, and nothing else."""

from pathlib import Path

import pytest

from runtime.errors import RecordingError
from runtime.recording.drive_files import AFTER_S, PARTS, Ring, WholeDrive
from runtime.recording.reader import messages


def told(files: Ring, seconds: range) -> None:
    for n in seconds:
        files.at(float(n)).write("/loop/rest", "rfnav.Rest", n, n, b'{"state":"%d"}' % n)


def kept(path: Path) -> list[int]:
    return [m.log_time_ns for file in sorted(path.iterdir()) for m in messages(file)]


def test_two_drives_at_once_are_two_files(tmp_path: Path):
    paths = [path for n in range(2) for path in WholeDrive(tmp_path, {}).close()]
    assert len(set(paths)) == 2
    assert all(path.name.startswith("rfnav-") for path in paths)


def test_a_ring_without_a_fault_leaves_nothing(tmp_path: Path):
    ring = Ring(tmp_path / "ring", 2.0, {})
    told(ring, range(300))
    (folder,) = (tmp_path / "ring").iterdir()
    assert 120 <= len(kept(folder)) <= 120 * (PARTS + 2) / PARTS
    assert ring.close() == ()
    assert not (tmp_path / "ring").exists()


def test_a_fault_keeps_the_minutes_before_it_and_a_little_after(tmp_path: Path):
    ring = Ring(tmp_path, 2.0, {})
    told(ring, range(300))
    ring.fault(299.0)
    told(ring, range(300, 400))
    ring.fault(400.0)
    told(ring, range(400, 402))
    first, second = ring.close()
    assert first.name.startswith("fault-")
    found = kept(first)
    assert found == list(range(found[0], 299 + round(AFTER_S)))
    assert found[-1] - found[0] >= 120
    assert kept(second) == list(range(found[-1] + 1, 402))


def test_a_crash_leaves_the_ring_and_the_next_begins_another(tmp_path: Path):
    crashed = Ring(tmp_path, 1.0, {})
    told(crashed, range(5))
    crashed.at(5.0).flush()
    another = Ring(tmp_path, 1.0, {})
    told(another, range(100, 110))
    another.close()
    (left,) = tmp_path.iterdir()
    assert kept(left) == list(range(5))
    crashed.at(5.0).close()


def test_a_place_that_cannot_be_written_is_told_at_once(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot be written"):
        Ring(tmp_path / "file", 1.0, {})
