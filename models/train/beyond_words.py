"""The words that the scene-layout expert is taught: names of things and rooms, for either of its
experts, and which names it is never told."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from models.errors import ModelFileError
from models.toml_text import read_toml
from models.train.names import PATH as NAMES
from models.train.names import Embed

PATH = Path(__file__).parent / "beyond.toml"


@dataclass(frozen=True)
class LayoutWords:
    """Names of K categories, their rows in the text encoder's space, and of R room types.

    `called` lists each category's names, canonical first; `taught` (K,) whether any is ever taught;
    `texts` is the file's [text].
    """

    called: tuple[tuple[str, ...], ...]
    rooms: tuple[str, ...]
    taught: np.ndarray
    texts: dict[str, str]
    _rows: tuple[Tensor, ...]
    room_rows: Tensor

    def draw(self, rng: np.random.Generator) -> Tensor:
        """(K, 384): one name of each category."""
        return torch.stack([rows[int(rng.integers(len(rows)))] for rows in self._rows])

    def canonical(self) -> Tensor:
        """(K, 384): the first name of each."""
        return torch.stack([rows[0] for rows in self._rows])


def load_words(categories: Sequence[str], rooms: Sequence[str], embed: Embed) -> LayoutWords:
    """Read names.toml and beyond.toml for the categories and rooms of some homes."""
    names, own = read_toml(NAMES), read_toml(PATH)
    known: dict[str, Any] = {c: body["names"] for c, body in names["categories"].items()}
    never = {*own["never_trained"], *names["held_out"]}
    if strange := sorted(set(own["never_trained"]) - set(known)):
        raise ModelFileError(f"{PATH}: never_trained: {strange[0]!r} is no category of {NAMES}")
    known |= names["held_out"]
    if missing := [c for c in categories if c not in known]:
        raise ModelFileError(f"category {missing[0]!r} has no names in {NAMES}")
    called = tuple(tuple(dict.fromkeys((c, *known[c]))) for c in categories)
    thing = own["text"]["thing"]

    def rows(texts: Sequence[str]) -> Tensor:
        return torch.from_numpy(np.asarray(embed([thing.format(t) for t in texts]), np.float32))

    return LayoutWords(
        called=called,
        rooms=tuple(rooms),
        taught=np.array([c not in never for c in categories]),
        texts=dict(own["text"]),
        _rows=tuple(rows(c) for c in called),
        room_rows=rows(rooms),
    )
