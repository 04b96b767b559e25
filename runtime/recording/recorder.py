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
import threading
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Final, NamedTuple

import numpy as np

from runtime.core.types import Brief, Detections
from runtime.core.world import World
from runtime.errors import RfNavError
from runtime.log import say
from runtime.recording.drive_files import DriveFiles
from runtime.recording.mcap_file import McapFile
from runtime.recording.messages import Encoder
from runtime.recording.pictures import Picture
from runtime.robot.streams import ConsumedFrame, WireMessage

BACKLOG_BYTES: Final = 64 * 2**20  # what may wait to be written; what comes on top is lost
FLUSH_S: Final = 1.0  # how much a crash may lose
DISK_S: Final = 5.0  # and a power failure
PICTURE_S: Final = 1.0  # between two drawings of the map
SMALL_BYTES: Final = 1000  # what is counted for a value without images and arrays
ALWAYS: Final = frozenset({"halt", "fault", "tick", "rest"})  # however much waits
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
    that every file begins with.

    There is no lock: control calls it twice a tick, and would wait for a thread of low priority.
    What is counted is kept by thread, so that no two write the same number.
    """

    def __init__(self, files: DriveFiles, encoder: Encoder, first: tuple[str, object]) -> None:
        self._files, self._encoder, self._first = files, encoder, first
        self._begun: McapFile | None = None  # the file that has its first value
        self._queue: SimpleQueue[_Waiting | None] = SimpleQueue()  # None: the last
        self._came: dict[int, int] = {}  # bytes, by the thread that told them
        self._went = 0  # of those: written
        self._dropped: dict[tuple[int, str], int] = {}  # by thread and kind
        self._told: dict[str, int] = {}  # of those, what the file says
        self._over = False  # nothing is written any more
        self._drawn_s = 0.0
        self._began_s = time.monotonic()
        self._flushed_s = self._synced_s = self._began_s
        self._cpu_s, self._size, self._error = 0.0, 0, ""
        self._bug: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def __call__(self, kind: str, value: object) -> None:
        """Take a value down; returns at once."""
        if self._over:
            return
        if kind == "world":
            self._draw(value)
            return
        thread, size = threading.get_ident(), SMALL_BYTES
        if kind not in ALWAYS:
            size = held_bytes(value)
            if self._backlog() + size > BACKLOG_BYTES:
                self._dropped[thread, kind] = self._dropped.get((thread, kind), 0) + 1
                return
        self._came[thread] = self._came.get(thread, 0) + size
        self._queue.put(_Waiting(time.time_ns(), kind, value, size))

    def close(self) -> RecordingSummary:
        """Write what waits; how it went."""
        self._queue.put(None)
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
        return RecordingSummary(paths, seconds, size, self._lost(), self._cpu_s, self._error)

    def _backlog(self) -> int:
        """Bytes that wait to be written, or are being written. A copy, for threads come and go."""
        return sum(self._came.copy().values()) - self._went

    def _lost(self) -> dict[str, int]:
        """By kind."""
        lost: dict[str, int] = {}
        for (_, kind), n in sorted(self._dropped.copy().items(), key=lambda item: item[0][1]):
            lost[kind] = lost.get(kind, 0) + n
        return lost

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
            say(f"the recording ends: {self._error}")
        except BaseException as error:  # noqa: BLE001 -- raised again by `close`
            self._bug = error
            say(f"the recording ends: {error!r}")
        finally:
            self._over, self._queue = True, SimpleQueue()  # what waits is not kept in memory
            self._cpu_s = time.thread_time()

    def _turn(self) -> bool:
        """Write one value; False after the last."""
        waiting, over = None, False
        with suppress(Empty):
            waiting = self._queue.get(timeout=FLUSH_S)
            over = waiting is None
        now_s = time.monotonic()
        if waiting is not None:
            self._write(waiting, now_s)
            self._went += waiting.size
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
        dropped = self._lost()
        if dropped != self._told:
            self._told = dropped
            told = {"dropped": dropped, "backlog_bytes": self._backlog()}
            self._write(_Waiting(time.time_ns(), "recorder", told, 0), now_s)
        to_disk = now_s - self._synced_s >= DISK_S
        self._synced_s = now_s if to_disk else self._synced_s
        self._files.at(now_s).flush(to_disk)


def held_bytes(value: object) -> int:
    """About what a value keeps in memory: its images and arrays, and SMALL_BYTES for all else."""
    parts = _parts(value)
    return SMALL_BYTES + sum(
        part.nbytes if isinstance(part, np.ndarray) else len(part)
        for part in parts
        if isinstance(part, np.ndarray | bytes)
    )


def _parts(value: object) -> Iterable[object]:
    """Where a value is large. Not all of it is walked through: that would take the loop longer
    than what it tells."""
    match value:
        case ConsumedFrame(match=match, observation=obs):
            return match.color.payload, match.depth.payload, obs.rgb, obs.depth_m
        case WireMessage(payload=payload):
            return (payload,)
        case Detections() | Picture():
            return vars(value).values()
        case {"brief": Brief(frontiers=frontiers)}:
            seen = (part for f in frontiers if f.sight for part in vars(f.sight).values())
            return [*(part for f in frontiers for part in (f.image, f.view)), *seen]
        case {"value": np.ndarray() as array}:
            return (array,)
    return ()


def _holds(halt: object) -> bool:
    return isinstance(halt, dict) and bool(halt["kind"]) and bool(halt["driving"])


def _reason(error: OSError | RfNavError) -> str:
    return str(error) if isinstance(error, RfNavError) else f"{error.strerror}"


def _size(path: Path) -> int:
    """Of a file, or of those in a folder."""
    return sum(p.stat().st_size for p in ([path] if path.is_file() else path.iterdir()))
