"""Keys of the configuration: a field of a frozen dataclass says its default, unit and meaning."""

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final, TypeVar

T = TypeVar("T")
RESEARCH = "research"
"""The table, outside of a robot's own keys, of what methods and questions are compared by."""
LETTERS: Final = 1000  # of a text
ITEMS: Final = 4000  # of a list: a harness names all that a home has
# By a key's unit: what a value too large was perhaps given in, and how many of those are one.
_MEANT: Final = {
    "m": ("mm", 1000.0), "m/s": ("mm/s", 1000.0), "m/s^2": ("mm/s^2", 1000.0), "s": ("ms", 1000.0),
    "rad": ("degrees", math.degrees(1.0)), "rad/s": ("degrees/s", math.degrees(1.0)),
    "rad/s^2": ("degrees/s^2", math.degrees(1.0)),
}  # fmt: skip


def key(
    default: T,
    meaning: str,
    unit: str = "",
    *,
    research: str = "",
    within: tuple[float, float] | None = None,
) -> T:
    """A field that the configuration may set. `meaning`: one sentence, as it is printed.
    `research`: its name in that table, where it is not a robot's own key. `within`: the least and
    the most that a number may be; infinity is none unless it is the most."""
    told = {"meaning": meaning, "unit": unit, "research": research, "within": within}
    return field(default=default, metadata=told)


@dataclass(frozen=True)
class Key:
    """A key as the configuration's file has it, `table.name`, and the field that it is, by the
    names that lead to it."""

    name: str
    path: tuple[str, ...]
    default: object
    meaning: str
    unit: str
    within: tuple[float, float] | None

    @property
    def table(self) -> str:
        return self.name.rpartition(".")[0]

    def value(self, config: object) -> Any:
        """What a configuration has it at."""
        for name in self.path:
            config = getattr(config, name)
        return config

    def wrong(self, value: object) -> str:
        """What is wrong with a value of the key's type, with what is right; "" for nothing."""
        if isinstance(value, str):
            return _wrong_text(value)
        if isinstance(value, tuple):
            if len(value) > ITEMS:
                return f"has {len(value)} items, must have at most {ITEMS}"
            return next((wrong for item in value if (wrong := self.wrong(item))), "")
        if isinstance(value, bool) or not isinstance(value, int | float):
            return ""
        if self.within is None:
            return "" if math.isfinite(value) else f"is {value}, must be finite"
        least, most = self.within
        if least <= value <= most:
            return ""
        unit = f" {self.unit}" if self.unit else ""
        right = f"{least:g}{unit} or more" if math.isinf(most) else f"{least:g} to {most:g}{unit}"
        return f"is {value}, must be {right}{self._meant(value, least, most)}"

    def _meant(self, value: float, least: float, most: float) -> str:
        """The value in the key's own unit, where it was perhaps given in another."""
        theirs, per_one = _MEANT.get(self.unit, ("", 1.0))
        ours = value / per_one
        if not theirs or abs(value) <= most or not least <= ours <= most:
            return ""
        return f"; {value:g} {theirs} are {ours:.3g} {self.unit}"


def _wrong_text(value: str) -> str:
    if len(value) > LETTERS:
        return f"has {len(value)} letters, must have at most {LETTERS}"
    strange = next((c for c in value if not c.isprintable()), "")
    return f"has {strange!r} in it, must be printable text" if strange else ""


def keys_of(config: Any, within: tuple[str, ...] = (), unseen: str = "") -> Iterator[Key]:
    """All keys of a configuration, an instance with the defaults, in the order of its fields;
    `unseen` is a part whose tables stand at the top level of the file."""
    for part in dataclasses.fields(config):
        value, path = getattr(config, part.name), (*within, part.name)
        if dataclasses.is_dataclass(value):
            yield from keys_of(value, path, unseen)
            continue
        told = part.metadata
        name = ".".join(step for step in path if step != unseen)
        if told.get("research"):
            name = f"{RESEARCH}.{told['research']}"
        yield Key(
            name, path, value, told.get("meaning", ""), told.get("unit", ""), told.get("within")
        )
