"""Names of categories and rooms, embedded once: what image features are aligned with."""

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from models.errors import ModelFileError

PATH = Path(__file__).parent / "names.toml"
NEVER_DRAWN = 12
"""How many words for absent things join each step."""

Embed = Callable[[Sequence[str]], np.ndarray]


@dataclass(frozen=True)
class Names:
    """Embedded names. `compare` (C, C): 1 where category j's names count for a region of i.
    `held_out` categories are in the frames and never learned."""

    categories: tuple[str, ...]
    held_out: tuple[str, ...]
    rooms: tuple[str, ...]
    compare: Tensor
    _category_rows: tuple[Tensor, ...]
    _view_rows: tuple[Tensor, ...]
    _room_rows: tuple[Tensor, ...]
    _never: Tensor

    def draw(self, rng: np.random.Generator) -> Tensor:
        """(C + NEVER_DRAWN, 384): one name per category, then words for absent things."""
        rows = [r[int(rng.integers(len(r)))] for r in self._category_rows]
        never = self._never[torch.from_numpy(rng.permutation(len(self._never))[:NEVER_DRAWN])]
        return torch.cat((torch.stack(rows), never))

    def draw_views(self, rng: np.random.Generator) -> Tensor:
        """(C, 384): one phrase per category for a view that shows it."""
        return torch.stack([r[int(rng.integers(len(r)))] for r in self._view_rows])

    def draw_rooms(self, rng: np.random.Generator) -> Tensor:
        """(R, 384): one phrase per room type."""
        return torch.stack([r[int(rng.integers(len(r)))] for r in self._room_rows])


def load_names(embed: Embed, path: Path = PATH) -> Names:
    """Read and embed the file's names."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    known, rooms = table["categories"], table["rooms"]
    near = [set(body.get("near", ())) for body in known.values()]
    for other in set().union(*near) - set(known):
        raise ModelFileError(f"{path}: near: {other!r} is no category of this file")
    compare = torch.tensor([[float(b not in skip) for b in known] for skip in near])
    phrases = [
        [p.format(n) for p in rooms["phrases"] for n in many] for many in rooms["names"].values()
    ]
    return Names(
        categories=tuple(known),
        held_out=tuple(table.get("held_out", ())),
        rooms=tuple(rooms["names"]),
        compare=compare,
        _category_rows=tuple(_rows(embed, body["names"]) for body in known.values()),
        _view_rows=tuple(
            _rows(embed, [table["views"]["phrase"].format(n) for n in body["names"]])
            for body in known.values()
        ),
        _room_rows=tuple(_rows(embed, p) for p in phrases),
        _never=_rows(embed, table["words"]["never"]),
    )


def _rows(embed: Embed, texts: Sequence[str]) -> Tensor:
    return torch.from_numpy(np.asarray(embed(texts), np.float32))
