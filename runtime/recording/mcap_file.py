"""One MCAP file being written: topics with their schemas, messages in chunks of about a second."""

import json
import os
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec, module_from_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import zstandard
from mcap.writer import Writer

from runtime.errors import RecordingError
from runtime.recording.reader import ABOUT, FORMAT
from runtime.recording.schemas import JSON_SCHEMAS, ros_definition

CHUNK_BYTES: Final = 1 << 20
ZSTD_LEVEL: Final = 1  # a third of the time of 3, on depth with noise, for a sixth more room


def _quick(data: bytes) -> bytes:
    return zstandard.ZstdCompressor(level=ZSTD_LEVEL).compress(data)


def _own_writer() -> Any:
    """The library's module once more, to ourselves. It has no setting for the level: it calls
    `zstandard.compress`, which takes 3, and others in this process are to go on so."""
    spec = find_spec("mcap.writer")
    assert spec is not None
    assert spec.loader is not None
    own: Any = module_from_spec(spec)
    spec.loader.exec_module(own)
    own.zstandard = SimpleNamespace(compress=_quick)
    return own


_WRITER: Final = _own_writer()


class McapFile:
    """Opens a file that must not be there yet. One thread at a time may use it.

    What was flushed survives a crash of the process; after `flush(to_disk=True)` it survives a
    power failure too.
    """

    def __init__(self, path: Path, about: Mapping[str, str]) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("xb")
        except OSError as error:
            if path.exists():
                told = "is there already: no recording is overwritten"
                raise RecordingError(f"{path}: {told}") from error
            raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error
        zstd = _WRITER.CompressionType.ZSTD
        self._writer: Writer = _WRITER.Writer(self._file, CHUNK_BYTES, zstd)
        self._writer.start(profile="ros2", library="rfnav")
        self._writer.add_metadata(ABOUT, {"format": FORMAT, "version": _version(), **about})
        self._file.flush()
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}

    def write(
        self, topic: str, schema: str, log_time_ns: int, publish_time_ns: int, payload: bytes
    ) -> None:
        """Add a message; `schema` is a ROS 2 type (its payload CDR) or one of `JSON_SCHEMAS`."""
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._open(topic, schema)
        self._writer.add_message(channel, log_time_ns, payload, publish_time_ns)

    def flush(self, to_disk: bool = False) -> None:
        """End the chunk that is being filled."""
        self._writer.flush()
        if to_disk:
            os.fsync(self._file.fileno())

    @property
    def size_bytes(self) -> int:
        """Written so far, without the chunk that is being filled."""
        return self._file.tell()

    def close(self) -> None:
        """Write the index and close. Idempotent."""
        if not self._file.closed:
            try:
                self._writer.finish()
            finally:  # on a full disk, too
                self._file.close()

    def _open(self, topic: str, schema: str) -> int:
        ours = schema in JSON_SCHEMAS
        if schema not in self._schemas:
            text = json.dumps(JSON_SCHEMAS[schema]) if ours else ros_definition(schema)
            encoding = "jsonschema" if ours else "ros2msg"
            self._schemas[schema] = self._writer.register_schema(schema, encoding, text.encode())
        encoding = "json" if ours else "cdr"
        return self._writer.register_channel(topic, encoding, self._schemas[schema])


def _version() -> str:
    """Of this runtime, for those who read the file with another one."""
    try:
        return version("rf-nav")
    except PackageNotFoundError:  # a checkout that nobody installed
        return "unknown"
