"""Where a recording goes: one file, or a ring of short ones that a fault keeps."""

import math
import shutil
import time
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final, Protocol

from runtime.recording.mcap_file import McapFile
from runtime.recording.reader import SUFFIX

PARTS: Final = 6  # files that a ring's time is spread over
SHORTEST_S: Final = 10.0  # of such a file
AFTER_S: Final = 5.0  # what comes after a fault is kept, too


class DriveFiles(Protocol):
    """What a recorder writes to. One thread at a time."""

    def at(self, now_s: float) -> McapFile:
        """The file for what is written now; monotonic s."""

    def fault(self, now_s: float) -> None:
        """What is there is to be kept."""

    def close(self) -> tuple[Path, ...]:
        """Finish; what is left on disk."""


class WholeDrive:
    """Everything in one file, DIRECTORY/rfnav-DATE-TIME.mcap."""

    def __init__(self, directory: Path, about: Mapping[str, str]) -> None:
        self._file = McapFile(_unused(directory, "rfnav", SUFFIX), about)

    def at(self, now_s: float) -> McapFile:
        return self._file

    def fault(self, now_s: float) -> None:
        """All of it is kept anyway."""

    def close(self) -> tuple[Path, ...]:
        self._file.close()
        return (self._file.path,)


class Ring:
    """The last minutes, in DIRECTORY/ring-DATE-TIME/. A fault makes that `fault-...`, which stays,
    and another ring begins; a crash leaves the ring as it is. Without either it is removed."""

    def __init__(self, directory: Path, minutes: float, about: Mapping[str, str]) -> None:
        self._directory, self._about = directory, about
        self._part_s = max(SHORTEST_S, minutes * 60.0 / PARTS)
        self._parts = math.ceil(minutes * 60.0 / self._part_s) + 1
        self._folder = _unused(directory, "ring")
        self._files: deque[McapFile] = deque()
        self._number = 0
        self._until_s = -math.inf
        self._keep_s: float | None = None  # when the fault is over
        self._kept: list[Path] = []
        self._open()  # a place that cannot be written is told at once

    def at(self, now_s: float) -> McapFile:
        if math.isinf(self._until_s):
            self._until_s = now_s + self._part_s
        if self._keep_s is not None and now_s >= self._keep_s:
            self._keep()
            self._folder = _unused(self._directory, "ring")
            self._open()
        elif now_s >= self._until_s:
            self._files[-1].close()
            self._open()
            while len(self._files) > self._parts and self._keep_s is None:
                self._files.popleft().path.unlink()
        else:
            return self._files[-1]
        self._until_s = now_s + self._part_s
        return self._files[-1]

    def fault(self, now_s: float) -> None:
        if self._keep_s is None:
            self._keep_s = now_s + AFTER_S

    def close(self) -> tuple[Path, ...]:
        if self._keep_s is not None:
            self._keep()
        elif self._files:
            self._files[-1].close()
            shutil.rmtree(self._folder)
            with suppress(OSError):  # something else lies there
                self._directory.rmdir()
        self._files.clear()
        return tuple(self._kept)

    def _open(self) -> None:
        self._number += 1
        path = self._folder / f"{self._number:06d}{SUFFIX}"
        self._files.append(McapFile(path, self._about))

    def _keep(self) -> None:
        self._files[-1].close()
        kept = _unused(self._directory, "fault")
        self._folder.rename(kept)
        self._files.clear()
        self._kept.append(kept)
        self._keep_s = None


def _unused(directory: Path, begins: str, suffix: str = "") -> Path:
    """A name by the time of day that nothing has yet."""
    stem, n = f"{begins}-{time.strftime('%Y%m%d-%H%M%S')}", 1
    path = directory / f"{stem}{suffix}"
    while path.exists():
        n += 1
        path = directory / f"{stem}-{n}{suffix}"
    return path
