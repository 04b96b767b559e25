"""Writes down a drive as it happens, in a thread of low priority that nobody waits for.

The parts of the loop tell it by kind what they consumed and what they made of it:

wire          odometry, intrinsics, tf, velocities: `WireMessage`, as the bytes came or went
frame         an observation that was handed to the loop: `ConsumedFrame`
request       a goal or a cancel; order: how a goal was understood
detections    what was seen in the frame
heard         a value that the loop was given in passing: {"name", "value"}
ballot        (Ballot, what became of a rehearsal), when the loop took it
question      what the experts are asked; decision: `Decision`; command; plan; rest; tick
halt          the base is held, or no longer; fault: what ends the runtime
world         the `World` after a step, which is drawn every now and then
"""

import os
import sys
import threading
import time
from collections import Counter, deque
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple

from runtime.core.world import World
from runtime.errors import RfNavError
from runtime.recording.drive_files import DriveFiles
from runtime.recording.mcap_file import McapFile
from runtime.recording.messages import Encoder
from runtime.recording.pictures import Picture
from runtime.robot.streams import ConsumedFrame, WireMessage

BACKLOG_BYTES: Final = 64 * 2**20  # what may wait to be written; what comes on top is lost
FLUSH_S: Final = 1.0  # how much a crash may lose
DISK_S: Final = 5.0  # and a power failure
PICTURE_S: Final = 1.0  # between two drawings of the map
SMALL_BYTES: Final = 1000  # what is counted for a value without images
NICE: Final = 10


class _Waiting(NamedTuple):
    """A value that is to be written."""

    log_time_ns: int
    kind: str
    value: object
    size: int


@dataclass(frozen=True)
class RecordingSummary:
    """What became of a recording."""

    paths: tuple[Path, ...]
    seconds: float
    size_bytes: int
    dropped: dict[str, int] = field(default_factory=dict)  # by kind
    cpu_s: float = 0.0  # that the writing took
    error: str = ""

    def in_words(self) -> str:
        """One line."""
        megabytes, minutes = self.size_bytes / 1e6, max(self.seconds, 1e-9) / 60
        where = ", ".join(map(str, self.paths)) or "nothing was kept"
        told = f"recorded {minutes:.1f} min, {megabytes:.1f} MB, {megabytes / minutes:.1f} MB a "
        told += f"minute, {100 * self.cpu_s / max(self.seconds, 1e-9):.1f} % of a core: {where}"
        if self.dropped:
            told += f"; lost: {', '.join(f'{n} {kind}' for kind, n in self.dropped.items())}"
        return told + (f"; it ended early: {self.error}" if self.error else "")


class Recorder:
    """Called with a kind and a value by any thread; `close` writes what waits. `first`: the value
    that every file begins with."""

    def __init__(self, files: DriveFiles, encoder: Encoder, first: tuple[str, object]) -> None:
        self._files, self._encoder, self._first = files, encoder, first
        self._begun: McapFile | None = None  # the file that has its first value
        self._changed = threading.Condition()
        self._queue: deque[_Waiting] = deque()
        self._backlog = 0  # bytes
        self._dropped: Counter[str] = Counter()
        self._told: Counter[str] = Counter()  # of those, what the file says
        self._closing = False
        self._drawn_s = 0.0
        self._began_s = time.monotonic()
        self._flushed_s = self._synced_s = self._began_s
        self._cpu_s, self._size, self._error = 0.0, 0, ""
        self._bug: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def __call__(self, kind: str, value: object) -> None:
        """Take a value down; returns at once."""
        if kind == "world":
            self._draw(value)
            return
        size = SMALL_BYTES
        if isinstance(value, ConsumedFrame):
            size += len(value.match.depth.payload) + value.observation.rgb.nbytes
        elif isinstance(value, WireMessage):
            size += len(value.payload)
        with self._changed:
            if self._backlog + size > BACKLOG_BYTES:
                self._dropped[kind] += 1
                return
            self._queue.append(_Waiting(time.time_ns(), kind, value, size))
            self._backlog += size
            self._changed.notify()

    def close(self) -> RecordingSummary:
        """Write what waits; how it went."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join()
        seconds = time.monotonic() - self._began_s
        paths: tuple[Path, ...] = ()
        try:
            paths = self._files.close()
        except (OSError, RfNavError) as error:
            self._error = self._error or _reason(error)
        if self._bug is not None:
            raise self._bug
        size = sum(_size(path) for path in paths) or self._size
        dropped = dict(sorted(self._dropped.items()))
        return RecordingSummary(paths, seconds, size, dropped, self._cpu_s, self._error)

    def _draw(self, world: object) -> None:
        """In the thread that owns the world."""
        now_s = time.monotonic()
        if isinstance(world, World) and now_s - self._drawn_s >= PICTURE_S:
            self._drawn_s = now_s
            self("picture", Picture.of(world))

    # -- the writing thread --------------------------------------------------------------------

    def _run(self) -> None:
        with suppress(OSError):  # where a thread cannot have a priority of its own
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)
        try:
            while self._turn():
                pass
        except (OSError, RfNavError) as error:
            self._error = _reason(error)
            print(f"rfnav: the recording ends: {self._error}", file=sys.stderr)
        except BaseException as error:  # noqa: BLE001 -- raised again by `close`
            self._bug = error
            print(f"rfnav: the recording ends: {error!r}", file=sys.stderr)
        finally:
            self._cpu_s = time.thread_time()

    def _turn(self) -> bool:
        """Write one value; False after the last."""
        with self._changed:
            while not self._queue and not self._closing:
                self._changed.wait(FLUSH_S)
                if not self._queue:
                    break
            waiting = self._queue.popleft() if self._queue else None
            over = waiting is None and self._closing
        now_s = time.monotonic()
        if waiting is not None:
            self._write(waiting, now_s)
            with self._changed:
                self._backlog -= waiting.size
        if over or now_s - self._flushed_s >= FLUSH_S:
            self._flush(now_s)
        return not over

    def _write(self, waiting: _Waiting, now_s: float) -> None:
        fault = waiting.kind == "fault"
        if fault or (waiting.kind == "halt" and _holds(waiting.value)):
            self._files.fault(now_s)
        if fault:
            told = {"kind": "fault", "reason": waiting.value, "driving": False}
            waiting = waiting._replace(kind="halt", value=told)
        file = self._files.at(now_s)
        if file is not self._begun:
            self._begun = file
            self._write(_Waiting(waiting.log_time_ns, *self._first, 0), now_s)
        for draft in self._encoder.drafts(waiting.kind, waiting.value):
            stamp_ns = waiting.log_time_ns if draft.stamp_ns is None else draft.stamp_ns
            file.write(draft.topic, draft.schema, waiting.log_time_ns, stamp_ns, draft.payload)
            self._size += len(draft.payload)

    def _flush(self, now_s: float) -> None:
        self._flushed_s = now_s
        with self._changed:
            dropped, backlog = Counter(self._dropped), self._backlog
        if dropped != self._told:
            self._told = dropped
            told = {"dropped": dict(sorted(dropped.items())), "backlog_bytes": backlog}
            self._write(_Waiting(time.time_ns(), "recorder", told, 0), now_s)
        to_disk = now_s - self._synced_s >= DISK_S
        self._synced_s = now_s if to_disk else self._synced_s
        self._files.at(now_s).flush(to_disk)


def _holds(halt: object) -> bool:
    return isinstance(halt, dict) and bool(halt["kind"]) and bool(halt["driving"])


def _reason(error: OSError | RfNavError) -> str:
    return str(error) if isinstance(error, RfNavError) else f"{error.strerror}"


def _size(path: Path) -> int:
    """Of a file, or of those in a folder."""
    return sum(p.stat().st_size for p in ([path] if path.is_file() else path.iterdir()))
