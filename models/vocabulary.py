"""The detector's default word lists."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

PATH = Path(__file__).parent / "vocabulary.toml"


@dataclass(frozen=True)
class Vocabulary:
    """`objects`: classes, each a tuple of names, canonical first. `rooms`: room types."""

    objects: tuple[tuple[str, ...], ...]
    rooms: tuple[str, ...]


def load_vocabulary(path: Path = PATH) -> Vocabulary:
    """Read a word list."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    return Vocabulary(tuple(tuple(c) for c in table["objects"]), tuple(table["rooms"]))
