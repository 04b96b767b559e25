"""A file is begun once, and says why it cannot be."""

from pathlib import Path

import pytest

from runtime.errors import RecordingError
from runtime.recording.mcap_file import McapFile
from runtime.recording.reader import Recording, messages


def test_a_recording_is_never_overwritten(tmp_path: Path):
    path = tmp_path / "a.mcap"
    McapFile(path, {}).close()
    before = path.read_bytes()
    with pytest.raises(RecordingError, match="no recording is overwritten"):
        McapFile(path, {})
    assert path.read_bytes() == before


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match=r"file/a\.mcap: cannot be written"):
        McapFile(tmp_path / "file" / "a.mcap", {})


def test_what_was_flushed_is_there_before_it_is_closed(tmp_path: Path):
    path = tmp_path / "a.mcap"
    file = McapFile(path, {"robot": "r"})
    file.write("/rfnav/rest", "rfnav.Rest", 1, 1, b'{"state":"ready"}')
    assert list(messages(path)) == []
    file.flush(to_disk=True)
    assert [m.payload for m in messages(path)] == [b'{"state":"ready"}']
    assert file.size_bytes == path.stat().st_size
    assert Recording(path).about["robot"] == "r"
    file.close()
    file.close()
