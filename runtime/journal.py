"""What a run leaves behind: a journal of JSON lines, and the map as one npz file."""

import dataclasses
import errno
import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from enum import Enum
from io import FileIO
from pathlib import Path
from typing import Any, Self

import numpy as np

from runtime.core.types import Missing
from runtime.errors import ConfigError
from runtime.log import say

MAP_FILE = "map.npz"
_META = "meta_json"
_NO_FILE: FileIO | None = None


class Journal:
    """Append-only JSON lines, each whole on disk when it is written: a crash loses at most the last
    one. What a full disk does not take is lost, and said once; `lost` says so, "" for nothing."""

    def __init__(self, path: Path | None) -> None:
        """Opens for appending; raises ConfigError when the file cannot be written. None: nothing
        is kept."""
        self.path, self._file = path, _NO_FILE
        self.lost = "" if path is not None else "the journal is not kept"
        self._lines_lost = 0
        if path is None:
            return
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("ab", buffering=0)
        except OSError as error:
            raise ConfigError(f"{path}: cannot be written ({error.strerror})") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def write(self, kind: str, /, **fields: object) -> None:
        """One line {"kind": kind, ...fields}; dataclasses, enums, arrays become plain values."""
        if self._file is None:
            return
        text = json.dumps({"kind": kind, **{k: plain(v) for k, v in fields.items()}}) + "\n"
        if self._lines_lost:
            text = json.dumps({"kind": "lost", "lines": self._lines_lost}) + "\n" + text
        self._lines_lost = 0 if self._append(text.encode()) else self._lines_lost + 1

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None

    def _append(self, raw: bytes) -> bool:
        """All of it or nothing; whether it was written."""
        assert self._file is not None
        try:
            end = self._file.seek(0, os.SEEK_END)
            if self._file.write(raw) == len(raw):
                return True
            why = os.strerror(errno.ENOSPC)
            self._file.truncate(end)
        except OSError as error:
            why = error.strerror or str(error)
        if not self.lost:
            self.lost = f"{self.path}: cannot be written ({why}): lines are lost"
            say(self.lost)
        return False


def plain(value: object) -> Any:
    """Dataclasses, mappings, sequences, enums and numpy values -> what JSON knows.

    NaN and infinity have no JSON form: they become null. Images (bytes) have no place in a journal:
    their length is what is told of them.
    """
    if isinstance(value, Enum):
        return plain(value.value)
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, bytes):
        return len(value)
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, np.ndarray):
        ready = value.dtype.kind in "biu" or (value.dtype.kind == "f" and np.isfinite(value).all())
        return value.tolist() if ready else plain(value.tolist())
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Missing):
        return value.told()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            f.name: plain(getattr(value, f.name))
            for f in dataclasses.fields(value)
            if f.metadata.get("written", True)
        }
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, set | frozenset):
        return [plain(item) for item in sorted(value)]
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    raise TypeError(f"a {type(value).__name__} has no JSON form")


def read_journal(path: Path) -> Iterator[dict[str, Any]]:
    """The lines of a journal; a torn last line (a crash while writing) is left out."""
    with path.open(encoding="utf-8") as file:
        for line in file:
            if line.endswith("\n"):
                yield json.loads(line)


def write_map(
    directory: Path, arrays: Mapping[str, np.ndarray[Any, Any]], meta: Mapping[str, object]
) -> Path:
    """`arrays` and JSON-able `meta` -> directory/map.npz, replaced whole or not at all. Raises
    OSError."""
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / MAP_FILE
    draft = directory / f".{MAP_FILE}.{os.getpid()}"
    columns: dict[str, Any] = {**arrays, _META: np.array(json.dumps(plain(meta)))}
    try:
        with draft.open("wb") as file:
            np.savez_compressed(file, **columns)
        draft.replace(path)
    except OSError:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
        raise
    return path


def read_map(directory: Path) -> tuple[dict[str, np.ndarray[Any, Any]], dict[str, Any]]:
    """directory/map.npz -> (arrays, meta), as they were given to `write_map`."""
    with np.load(directory / MAP_FILE, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files if name != _META}
        meta: dict[str, Any] = json.loads(str(file[_META]))
    return arrays, meta
