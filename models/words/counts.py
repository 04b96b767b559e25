"""What stands in which room and what near what, as it was counted: the file that `hil-sim counts`
makes."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from models.errors import ModelFileError

PATH = Path(__file__).parent / "counts.json"

Rows = dict[str, dict[str, int]]


class Counted(NamedTuple):
    """Of one set of homes. `rooms`: how many there are of each type; `holding`: by thing, in how
    many of each type there is one; `things`: how many there are of each; `beside`: by thing, how
    many of it have each other thing near; `doors`: by room type, how many of its doors lead to each
    type. What a set has none of at all, it has not counted: it is left out."""

    rooms: dict[str, int]
    holding: Rows
    things: dict[str, int]
    beside: Rows
    doors: Rows


def load_counts(path: Path = PATH) -> tuple[Counted, ...]:
    """Read such a file; ModelFileError for what is none."""
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
        names, rooms = _names(table["names"]), _names(table["rooms"])
        return tuple(_counted(table["counts"][kind], names, rooms) for kind in table["counts"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ModelFileError(
            f"{path}: not a table of counts ({error}); reinstall rf-nav"
        ) from error


def _counted(table: dict[str, Any], names: Sequence[str], rooms: Sequence[str]) -> Counted:
    here = _kept(rooms, _numbers(table["rooms"], rooms))
    things = _kept(names, _numbers(table["things"], names))
    holding = {
        name: {room: n for room, n in zip(rooms, _numbers(row, rooms), strict=True) if room in here}
        for name, row in zip(names, table["holding"], strict=True)
        if name in things
    }
    beside = {
        name: _kept(names, _numbers(row, names))
        for name, row in zip(names, table["beside"], strict=True)
        if name in things
    }
    doors = {
        room: found
        for room, row in zip(rooms, table["doors"], strict=True)
        if (found := _kept(rooms, _numbers(row, rooms)))
    }
    return Counted(here, holding, things, beside, doors)


def _kept(names: Iterable[str], counts: Iterable[int]) -> dict[str, int]:
    return {name: n for name, n in zip(names, counts, strict=True) if n}


def _names(values: object) -> tuple[str, ...]:
    if not isinstance(values, list) or not all(isinstance(v, str) and v for v in values):
        raise TypeError("names are not texts")
    return tuple(values)


def _numbers(values: object, names: Sequence[str]) -> list[int]:
    if not isinstance(values, list) or len(values) != len(names):
        raise ValueError(f"a row has not {len(names)} counts")
    if not all(type(v) is int and 0 <= v < 2**31 for v in values):
        raise ValueError("a count is no whole number")
    return values
