"""The detector's default word lists."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from models.errors import ModelFileError
from models.toml_text import read_toml

PATH = Path(__file__).parents[1] / "vocabulary.toml"


@dataclass(frozen=True)
class Vocabulary:
    """`objects`: classes, each a tuple of names, canonical first. `rooms`: room types. By canonical
    name, `also`: what people call a class besides, which the detector is not asked for; `kinds`:
    other classes that are kinds of it. `small`: classes, by canonical name, that are seldom wider
    or higher than 0.4 m."""

    objects: tuple[tuple[str, ...], ...]
    rooms: tuple[str, ...]
    also: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    kinds: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    small: frozenset[str] = frozenset()


def load_vocabulary(path: Path = PATH) -> Vocabulary:
    """Read a word list; ModelFileError for what is none."""
    try:
        table = read_toml(path)
        found = Vocabulary(
            tuple(_names(c) for c in table["objects"]),
            _names(table["rooms"]),
            {name: _names(more) for name, more in table.get("also", {}).items()},
            {name: _names(kinds) for name, kinds in table.get("kinds", {}).items()},
            frozenset(_names(table["small"])) if "small" in table else frozenset(),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ModelFileError(
            f"{path}: not a word list ({error}); it needs `objects`, a list of lists of names, and "
            "`rooms`, a list of names"
        ) from error
    owner = {name: names[0] for names in found.objects for name in names}
    for name in sorted(found.small):
        if owner.get(name) != name:
            raise ModelFileError(f"{path}: small: no class of `objects` begins with {name!r}")
    for name, kinds in found.kinds.items():
        for kind in (name, *kinds):
            if owner.get(kind) != kind:
                raise ModelFileError(
                    f"{path}: kinds.{name}: no class of `objects` begins with {kind!r}"
                )
    for name, more in found.also.items():
        if owner.get(name) != name:
            raise ModelFileError(
                f"{path}: also.{name}: no class of `objects` begins with that name"
            )
        for other in more:
            if owner.setdefault(other, name) != name:
                raise ModelFileError(
                    f"{path}: also.{name}: {other!r} is {owner[other]}, too; keep one"
                )
    return found


def _names(names: object) -> tuple[str, ...]:
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise ValueError(f"{names!r:.60} is no list of names")
    return tuple(names)
