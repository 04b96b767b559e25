"""Files that outlive the process: whenever the power goes, each is the one before or the new one,
whole. One that cannot be read is kept aside, and told of."""

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final, TypeVar

from runtime.errors import SavedError

ASIDE: Final = 100  # files that could not be read are kept beside one
T = TypeVar("T")


class Disk:
    """The steps that a file is written in; a test's disk ends at any of them."""

    def write(self, path: Path, raw: bytes) -> None:
        path.write_bytes(raw)

    def sync(self, path: Path) -> None:
        """A file or a folder: what was written of it outlives a power cut."""
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)

    def replace(self, draft: Path, path: Path) -> None:
        draft.replace(path)

    def remove(self, path: Path) -> None:
        path.unlink(missing_ok=True)


SYSTEM: Final = Disk()


def save(path: Path, raw: bytes, disk: Disk = SYSTEM) -> None:
    """Have `raw` in place of what the file holds. SavedError when it cannot be written; then the
    file is the one before."""
    draft = path.with_name(f".{path.name}.new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        disk.write(draft, raw)
        disk.sync(draft)
        disk.replace(draft, path)
        disk.sync(path.parent)
    except OSError as error:
        with suppress(OSError):
            disk.remove(draft)
        raise SavedError(
            f"{path}: cannot be written ({error.strerror}): make room, or let rfnav write there"
        ) from error


def saved(path: Path, read: Callable[[bytes], T], most_bytes: int) -> T | None:
    """What the file holds, as `read` makes it; None where there is none. SavedError when it cannot
    be had; what `read` does not take, a ValueError of it, is put aside first."""
    try:
        with path.open("rb") as file:
            raw = file.read(most_bytes + 1)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise SavedError(f"{path}: cannot be read ({error.strerror}): let rfnav read it") from error
    try:
        if len(raw) > most_bytes:
            raise ValueError(f"more than {most_bytes} bytes")
        return read(raw)
    except ValueError as error:
        raise SavedError(f"{path}: {error}; it was put aside as {put_aside(path)}") from error


def put_aside(path: Path) -> str:
    """Keep a file under a name that nothing else has, beside where it was; that name."""
    for number in range(1, ASIDE + 1):
        aside = path.with_name(f"{path.name}.aside-{number}")
        if not aside.exists():
            break
    try:
        path.replace(aside)
        SYSTEM.sync(path.parent)
    except OSError as error:
        raise SavedError(f"{path}: cannot be put aside ({error.strerror}): move it") from error
    return aside.name
