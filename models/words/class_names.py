"""Class lists: what may be one, and the text rows that stand for it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError
from models.words.text_encoder import TextEncoder

MAX_CLASSES = 2000
MAX_NAME = 100
ROOM_PHRASES = ("{}", "a {}", "a photo of a {}", "inside a {}")


def check_names(names: Sequence[str], where: str) -> None:
    """Raise ModelFileError unless this is a usable list of class names."""
    if not names:
        raise ModelFileError(f"{where}: the class list is empty; give at least one name")
    if len(names) > MAX_CLASSES:
        raise ModelFileError(f"{where}: {len(names)} names; at most {MAX_CLASSES} are possible")
    for name in names:
        shown = " ".join(name.split())[:30]
        if not name.strip():
            raise ModelFileError(f"{where}: a class name is blank; write a word or remove the line")
        if "\n" in name or "\r" in name:
            raise ModelFileError(
                f"{where}: class name {shown!r} holds a line break; use one line each"
            )
        if not name.isprintable():
            raise ModelFileError(
                f"{where}: class name {name[:30]!r} holds what cannot be printed; write it anew"
            )
        if len(name) > MAX_NAME:
            raise ModelFileError(
                f"{where}: class name {shown!r}… has {len(name)} characters; at most {MAX_NAME}"
            )


def read_names(path: Path) -> tuple[str, ...]:
    """Class names from a text file, one a line."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ModelFileError(
            f"{path}: not a readable class list ({error}); one name a line"
        ) from error
    while lines and not lines[-1].strip():
        lines.pop()
    check_names(lines, str(path))
    return tuple(line.strip() for line in lines)


class ClassText:
    """Text rows of a class list: `rows` (M, D), of which row m belongs to class `owner[m]`."""

    def __init__(self, classes: Sequence[Sequence[str]], encoder: TextEncoder) -> None:
        for names in classes:
            if isinstance(names, str) or not names:
                raise ModelFileError("vocabulary: each class is a tuple of at least one name")
        self.classes = tuple(tuple(names) for names in classes)
        flat = [name for names in self.classes for name in names]
        check_names(flat, "vocabulary")
        self.rows = encoder.embed(flat)
        counts = [len(names) for names in self.classes]
        self.owner = np.repeat(np.arange(len(self.classes)), counts)
        self._starts = np.concatenate(([0], np.cumsum(counts)[:-1])).astype(np.int64)

    def similarity(self, embeddings: NDArray[np.float32]) -> NDArray[np.float32]:
        """(N, D) unit rows -> (N, classes) cosine with each class's best name."""
        cosines = embeddings @ self.rows.T
        best: NDArray[np.float32] = np.maximum.reduceat(cosines, self._starts, axis=1)
        return best


def room_rows(rooms: Sequence[str], encoder: TextEncoder) -> NDArray[np.float32]:
    """(R, D) unit rows, each the mean over several phrasings."""
    if not rooms:
        return np.zeros((0, encoder.dimension), np.float32)
    check_names(rooms, "room types")
    rows = encoder.embed([p.format(room) for room in rooms for p in ROOM_PHRASES])
    mean = rows.reshape(len(rooms), len(ROOM_PHRASES), -1).mean(axis=1)
    return np.asarray(mean / np.linalg.norm(mean, axis=1, keepdims=True), np.float32)
