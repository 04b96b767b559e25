"""Keys of the configuration: a field of a frozen dataclass says its default, unit and meaning."""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, TypeVar

T = TypeVar("T")
RESEARCH = "research"
"""The table, outside of a robot's own keys, of what methods and questions are compared by."""


def key(
    default: T, meaning: str, unit: str = "", *, research: str = "", positive: bool = False
) -> T:
    """A field that the configuration may set. `meaning`: one sentence, as it is printed.
    `research`: its name in that table, where it is not a robot's own key. `positive`: it must be
    more than 0."""
    told = {"meaning": meaning, "unit": unit, "research": research, "positive": positive}
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
    positive: bool

    @property
    def table(self) -> str:
        return self.name.rpartition(".")[0]

    def value(self, config: object) -> Any:
        """What a configuration has it at."""
        for name in self.path:
            config = getattr(config, name)
        return config


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
            name, path, value, told.get("meaning", ""), told.get("unit", ""),
            bool(told.get("positive")),
        )  # fmt: skip
