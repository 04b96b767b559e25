"""A disk whose power goes, or which is full, in the midst of a write."""

import errno
from dataclasses import dataclass, field
from pathlib import Path

from runtime.service.saved import Disk


class PowerCutError(Exception):
    """Nothing runs any more."""


@dataclass
class CutDisk(Disk):
    """Over a real folder, which is as the disk is after the power cut: what was not synced is there
    in part, or under the name it had before. `steps` until the power goes; `full`: before the step
    fails as on a full disk."""

    steps: int
    full: bool = False
    half: dict[Path, bytes] = field(default_factory=dict)  # written, not synced
    moved: dict[Path, bytes | None] = field(default_factory=dict)  # replaced: what was there

    def write(self, path: Path, raw: bytes) -> None:
        self.half[path] = raw
        path.write_bytes(raw[: len(raw) // 2])
        self._step()
        path.write_bytes(raw)

    def sync(self, path: Path) -> None:
        self._step()
        if path.is_dir():
            self.moved.clear()
        else:
            self.half.pop(path, None)

    def replace(self, draft: Path, path: Path) -> None:
        self._step()
        self.moved[path] = path.read_bytes() if path.exists() else None
        if draft in self.half:
            self.half[path] = self.half.pop(draft)
        super().replace(draft, path)

    def cut(self, renamed: bool) -> None:
        """The power has gone. `renamed`: a rename that was not synced has reached the disk."""
        if not renamed:
            for path, before in self.moved.items():
                self.half.pop(path, None)
                path.unlink() if before is None else path.write_bytes(before)
        for path, raw in self.half.items():
            if path.exists():
                path.write_bytes(raw[: len(raw) // 2])

    def _step(self) -> None:
        self.steps -= 1
        if self.steps < 0:
            if self.full:
                raise OSError(errno.ENOSPC, "No space left on device")
            raise PowerCutError
