"""A recorded drive read back: every message in the order in which it was written, up to the end or
to where a power failure cut the file off."""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Final, cast

import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, Footer, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk

from runtime.errors import RecordingError

FORMAT: Final = "1"
"""Of our recordings: what topics there are and what is in them. Another one is not read."""
ABOUT: Final = "rfnav"  # the MCAP metadata that says what a file is
SUFFIX: Final = ".mcap"
RECORD_BYTES: Final = 256 * 2**20  # a longer one is damage: chunks are about a second

# What a file that ends in the middle of something raises, besides the library's own errors.
_CUT: Final = (
    McapError,
    struct.error,
    zstandard.ZstdError,
    CRCValidationError,
    UnicodeDecodeError,
    EOFError,
    OverflowError,  # a length, within a chunk, that no memory has
)


@dataclass(frozen=True)
class Recorded:
    """A message: `payload` as its schema has it, CDR for ROS 2 types (`sensor_msgs/msg/Image`) and
    JSON for ours (`rfnav.Tick`). `log_time_ns` is when it was recorded, by the machine's time of
    day; `publish_time_ns` the stamp in its header, or the same where it has none."""

    topic: str
    log_time_ns: int
    publish_time_ns: int
    payload: bytes
    schema: str


@dataclass(frozen=True, order=True)
class ChunkPlace:
    """Where in a recording a chunk begins: in which of its files, at which byte."""

    file: int
    byte: int


class _Short:
    """A file that is asked for no more than a record may have: whoever asks for more gets as much
    memory as that, whatever there is to read. EOFError for less than nothing, which a record has
    left that says it is shorter than its own head."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file

    def read(self, count: int) -> bytes:
        if count < 0:
            raise EOFError
        return self._file.read(min(count, RECORD_BYTES))


def _read(file: IO[bytes], at: int = 0) -> Iterator[tuple[int, McapRecord]]:
    """Its records from that byte on, those of a chunk when all of that was there, each with the
    byte at which it, or its chunk, begins. One of _CUT where it is damaged."""
    file.seek(at)
    short = cast(IO[bytes], _Short(file))
    limit = RECORD_BYTES
    records = StreamReader(short, at > 0, emit_chunks=True, record_size_limit=limit).records
    while True:
        at = file.tell()
        record = next(records, None)
        if record is None:
            return
        if not isinstance(record, Chunk):
            yield at, record
            continue
        sizes = [record.uncompressed_size]
        if record.compression == "zstd":
            sizes.append(zstandard.frame_content_size(record.data))
        if max(sizes) > RECORD_BYTES:
            raise EOFError
        for within in breakup_chunk(record, validate_crc=True):
            yield at, within


class Recording:
    """A file that was begun by the recorder, or a folder of them, one after the other, as a ring
    leaves it. RecordingError when it is none, or of another format.

    `cut` is known once all messages were read: whether a file ends in the middle. What comes after
    that is left out, further files too.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._damaged: set[Path] = set()
        self._schemas: dict[Path, dict[int, Schema]] = {}
        self._channels: dict[Path, dict[int, Channel]] = {}
        self._files = sorted(path.glob(f"*{SUFFIX}")) if path.is_dir() else [path]
        if not self._files:
            raise RecordingError(f"{path}: no {SUFFIX} file is in it")
        self.about: Mapping[str, str] = _about(self._files[0])
        found = self.about.get("format")
        if found != FORMAT:
            written = self.about.get("version", "unknown")
            raise RecordingError(
                f"{path}: a recording of format {found}, this reads {FORMAT}: replay it with the "
                f"version of rfnav that wrote it ({written})"
            )

    @property
    def cut(self) -> bool:
        return bool(self._damaged)

    def size_bytes(self) -> int:
        """On disk."""
        return sum(file.stat().st_size for file in self._files)

    def __iter__(self) -> Iterator[Recorded]:
        return (message for _, message in self.placed())

    def placed(self, since: ChunkPlace = ChunkPlace(0, 0)) -> Iterator[tuple[ChunkPlace, Recorded]]:
        """Each message with the place of its chunk, from a place on that was read before."""
        for number, file in enumerate(self._files[since.file :], since.file):
            start = since.byte if number == since.file else 0
            for at, message in self._messages(file, start):
                yield ChunkPlace(number, at), message
            if file in self._damaged:
                return

    def _messages(self, path: Path, start: int) -> Iterator[tuple[int, Recorded]]:
        schemas = self._schemas.setdefault(path, {})
        channels = self._channels.setdefault(path, {})
        with path.open("rb") as file:
            for at, record in self._records(path, file, start):
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, Message):
                    channel = channels[record.channel_id]
                    yield (
                        at,
                        Recorded(
                            channel.topic,
                            record.log_time,
                            record.publish_time,
                            bytes(record.data),
                            schemas[channel.schema_id].name,
                        ),
                    )

    def _records(self, path: Path, file: IO[bytes], start: int) -> Iterator[tuple[int, McapRecord]]:
        """Those of whole chunks; what follows a damaged one is left out, for a replay needs all."""
        try:
            for at, record in _read(file, start):
                if isinstance(record, Footer):
                    return
                yield at, record
        except _CUT:
            self._damaged.add(path)


def messages(path: Path) -> Iterator[Recorded]:
    """Every message of a recording, in the order of writing. RecordingError when it is none."""
    return iter(Recording(path))


def _about(path: Path) -> Mapping[str, str]:
    """What a file's first records say of it."""
    try:
        with path.open("rb") as file:
            if not file.read(1):
                raise RecordingError(f"{path}: is empty: nothing was recorded")
            file.seek(0)
            for _, record in _read(file):
                if isinstance(record, Metadata) and record.name == ABOUT:
                    return record.metadata
                if isinstance(record, Message):
                    break  # ours begins with it
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from error
    except _CUT as error:
        raise RecordingError(f"{path}: not a recording of rfnav, or cut off at once") from error
    raise RecordingError(f"{path}: an MCAP file, but not a recording of rfnav")
