"""What was found of one thing, how grave it is, and what to do about it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum


class Grade(StrEnum):
    """From what needs nothing up to what no search can start with."""

    OK = "ok"
    UNKNOWN = "not known"
    WARNING = "warning"
    BAD = "bad"


@dataclass(frozen=True)
class Diagnosis:
    """`about`: what of, in a word or two; `told`: what was measured; `remedy`: what to do, one
    line, "" where nothing is to be done; `settings`: keys of the configuration and the values, as
    TOML has them, that would fit what was found."""

    about: str
    grade: Grade
    told: str
    remedy: str = ""
    settings: tuple[tuple[str, str], ...] = ()


def ok(about: str, told: str) -> Diagnosis:
    return Diagnosis(about, Grade.OK, told)


def unknown(about: str, why: str, remedy: str = "") -> Diagnosis:
    return Diagnosis(about, Grade.UNKNOWN, f"not known: {why}", remedy)


def warning(about: str, told: str, remedy: str, *settings: tuple[str, str]) -> Diagnosis:
    return Diagnosis(about, Grade.WARNING, told, remedy, settings)


def bad(about: str, told: str, remedy: str, *settings: tuple[str, str]) -> Diagnosis:
    return Diagnosis(about, Grade.BAD, told, remedy, settings)


def can_search(found: Iterable[Diagnosis]) -> bool:
    """Whether a search could start."""
    return all(one.grade is not Grade.BAD for one in found)


def verdict(found: Sequence[Diagnosis]) -> str:
    """The last line: whether a search could start, and what speaks against it."""
    counts = {grade: sum(one.grade is grade for one in found) for grade in Grade}
    less = [
        f"{count} {grade}{'s' if grade is Grade.WARNING and count > 1 else ''}"
        for grade in (Grade.BAD, Grade.WARNING, Grade.UNKNOWN)
        if (count := counts[grade])
    ]
    can = "a search can start" if can_search(found) else "NO SEARCH CAN START"
    return f"{can}: {', '.join(less) or 'all is well'}"


def fitting(found: Iterable[Diagnosis]) -> str:
    """The settings of all, as the lines of a TOML file; "" where there are none."""
    tables: dict[str, dict[str, str]] = {}
    for name, value in (setting for one in found for setting in one.settings):
        table, _, key = name.rpartition(".")
        tables.setdefault(table, {}).setdefault(key, value)
    blocks = (
        "\n".join([f"[{table}]", *(f"{key} = {value}" for key, value in keys.items())])
        for table, keys in sorted(tables.items())
    )
    return "\n\n".join(blocks)
