"""What stands in a room of each type, how many, on what and beside what: read, not invented.

`placement.json` holds counts over 120 single rooms (see its "source"). It has no studies, dining
rooms and hallways: those are put together from parts of living rooms, bedrooms and kitchens in
`DERIVED`, and are no statistics of such rooms.
"""

import functools
import json
import random
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

TABLE = Path(__file__).parent / "placement.json"
AT_WALL = 0.7
"""Share against a wall where fewer than three instances were seen on the floor."""

Habits = Mapping[str, "Habit"]


@dataclass(frozen=True)
class Habit:
    """How a category occurs in a type of room. All figures are shares in 0..1.

    `counts[k]`: of rooms with k of them. `on`: of instances on a support ("floor", "wall",
    "inside" of something shut, or a category). `near`: of floor-standing instances with that
    category within 1 m. `wall`: of floor-standing instances against a wall.
    """

    counts: tuple[float, ...]
    on: tuple[tuple[str, float], ...]
    near: Mapping[str, float]
    wall: float = AT_WALL

    def draw_count(self, rng: random.Random) -> int:
        return rng.choices(range(len(self.counts)), self.counts)[0]

    def share_on(self, support: str) -> float:
        return dict(self.on).get(support, 0.0)

    def rarer(self, factor: float) -> "Habit":
        """The same with its presence cut to `factor` of what it was."""
        shown = tuple(share * factor for share in self.counts[1:])
        return replace(self, counts=(1.0 - sum(shown), *shown))


DERIVED: dict[str, tuple[tuple[str, float, tuple[str, ...]], ...]] = {
    "study": (
        ("bedroom", 1.0, ("desk", "chair", "trash can", "book", "laptop", "cell phone", "shelf",
                          "desk lamp", "mug", "alarm clock", "bookcase")),
        ("living room", 0.5, ("armchair", "floor lamp", "plant", "statue", "picture", "box",
                              "vase", "dresser")),
    ),
    "dining room": (
        ("living room", 0.6, ("dresser", "nightstand", "floor lamp", "plant", "statue", "picture",
                              "vase", "plate", "shelf", "armchair", "trash can")),
        ("kitchen", 0.4, ("bowl", "bottle", "mug", "apple")),
    ),
    "hallway": (
        ("living room", 0.35, ("nightstand", "dresser", "plant", "picture", "vase", "statue",
                               "box", "floor lamp", "mirror", "shelf", "chair")),
        ("bedroom", 0.3, ("basketball", "baseball bat")),
    ),
}  # fmt: skip
"""Rooms without statistics: (like which room, how much rarer, which categories)."""


@functools.cache
def habits(kind: str) -> Habits:
    """Habits by category, for any of the scene's room types."""
    table = _table()
    if kind in table:
        return MappingProxyType(table[kind])
    found = {
        category: table[like][category].rarer(factor)
        for like, factor, categories in DERIVED[kind]
        for category in categories
    }
    return MappingProxyType(found)


@functools.cache
def _table() -> dict[str, dict[str, Habit]]:
    rooms = json.loads(TABLE.read_text(encoding="utf-8"))["rooms"]
    return {
        kind: {category: _habit(row) for category, row in rows.items()}
        for kind, rows in rooms.items()
    }


def _habit(row: Mapping[str, Any]) -> Habit:
    return Habit(
        tuple(row["counts"]),
        tuple(row["on"].items()),
        MappingProxyType(row.get("near", {})),
        row.get("wall", AT_WALL),
    )
