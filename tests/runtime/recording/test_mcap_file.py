"""A file is begun once, and says why it cannot be."""

import json
from pathlib import Path

import mcap.writer
import pytest
import zstandard
from mcap.records import Chunk
from mcap.stream_reader import StreamReader

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


def test_chunks_are_compressed_quickly_and_those_of_others_as_ever(tmp_path: Path):
    path = tmp_path / "a.mcap"
    file = McapFile(path, {})
    for n in range(500):
        told = json.dumps({"state": f"{n * n} {n % 7}"}).encode()
        file.write("/loop/rest", "rfnav.Rest", n, n, told)
    file.close()
    with path.open("rb") as stream:
        records = StreamReader(stream, emit_chunks=True).records
        (chunk,) = [record for record in records if isinstance(record, Chunk)]
    data = zstandard.decompress(chunk.data)
    by_level = {n: zstandard.ZstdCompressor(level=n).compress(data) for n in (1, 3)}
    assert by_level[1] != by_level[3]
    assert chunk.data == by_level[1]
    assert mcap.writer.zstandard is zstandard
