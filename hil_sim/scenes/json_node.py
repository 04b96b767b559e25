"""A JSON object of a scene file with its place in it, read with errors that name the place."""

import difflib
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from hil_sim.scenes.format import Point, Polygon, SceneError, polygon_area


@dataclass(frozen=True)
class Node:
    """A JSON object with its place in the file, for errors that name it."""

    data: Any
    label: str
    place: str

    def __post_init__(self) -> None:
        if not isinstance(self.data, dict):
            self.fail("", f"is {type(self.data).__name__}, not an object")

    def fail(self, key: str, why: str) -> None:
        where = ".".join(part for part in (self.place, key) if part)
        raise SceneError(f"{self.label}: {where or 'scene'}: {why}")

    def get(self, key: str) -> Any:
        return self.data.get(key)

    def only(self, *keys: str) -> None:
        for key in self.data:
            if key not in keys:
                self.fail(str(key), f"unknown key{nearest(str(key), keys)}")

    def need(self, key: str) -> Any:
        if key not in self.data:
            self.fail(key, "missing")
        return self.data[key]

    def text(self, key: str) -> str:
        value = self.need(key)
        if not isinstance(value, str) or not value:
            self.fail(key, f"is {value!r}, not a text")
        return str(value)

    def optional_text(self, key: str) -> str | None:
        return self.text(key) if self.data.get(key) is not None else None

    def choice(self, key: str, choices: tuple[str, ...], default: str | None = None) -> str:
        value = self.text(key) if key in self.data or default is None else default
        if value not in choices:
            self.fail(key, f"unknown {value!r}{nearest(value, choices, len(choices) < 9)}")
        return value

    def number(self, key: str, default: float, above: float = -math.inf) -> float:
        value = self.numbers(key, 1, [default] if key not in self.data else [self.data[key]])[0]
        if value <= above:
            self.fail(key, f"is {value:g}, must be more than {above:g}")
        return value

    def numbers(self, key: str, count: int, value: Any) -> tuple[float, ...]:
        good = isinstance(value, (list, tuple)) and len(value) == count
        if not good or not all(_is_number(v) for v in value):
            self.fail(key, f"is {value!r}, not {count} finite number{'s' * (count > 1)}")
        return tuple(float(v) for v in value)

    def point(self, key: str) -> Point:
        x, y = self.numbers(key, 2, self.need(key))
        return x, y

    def triple(self, key: str) -> tuple[float, float, float]:
        x, y, z = self.numbers(key, 3, self.need(key))
        return x, y, z

    def nodes(self, key: str) -> list["Node"]:
        rows = self.data.get(key, [])
        if not isinstance(rows, list):
            self.fail(key, "is not a list")
        return [Node(row, self.label, f"{key}[{i}]") for i, row in enumerate(rows)]

    def polygon(self, key: str, value: Any) -> Polygon:
        if not isinstance(value, list) or len(value) < 3:
            self.fail(key, "a polygon needs at least 3 points")
        points: list[Point] = []
        for i, row in enumerate(value):
            x, y = self.numbers(f"{key}[{i}]", 2, row)
            points.append((x, y))
        if polygon_area(tuple(points)) < 1e-6:
            self.fail(key, "the polygon has no area")
        return tuple(points)

    def polygon_at(self, key: str, i: int) -> Polygon:
        if not isinstance(self.data[key], list):
            self.fail(key, "is not a list of polygons")
        return self.polygon(f"{key}[{i}]", self.data[key][i])


def nearest(word: str, words: Iterable[str], everything: bool = False) -> str:
    """What an error says of the known words: the one most like this, or all (`everything`)."""
    words = list(words)
    if near := difflib.get_close_matches(word, words, 1, 0.5):
        return f"; did you mean {near[0]!r}?"
    return f"; one of {', '.join(words)}" if everything else ""


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
