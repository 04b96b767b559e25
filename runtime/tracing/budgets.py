"""How long each stage may take, and what is left out for a while where that does not suffice:
budgets.toml, read once."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from importlib.resources import files
from pathlib import Path
from typing import Any

from runtime.errors import ConfigError
from runtime.toml_values import parse_toml
from runtime.tracing.stages import Stage


class Shed(StrEnum):
    """What is done less of where a stage overruns; control is never."""

    NOTHING = "nothing"
    DETECTOR = "detector"  # the detectors look less often, then as EXPERTS
    EXPERTS = "experts"  # nothing is rehearsed, no words are scored ahead


@dataclass(frozen=True)
class StageBudget:
    """Of one stage; what takes longer than `p99_ms` is an overrun."""

    median_ms: float
    p99_ms: float
    shed: Shed = Shed.NOTHING


@dataclass(frozen=True)
class LoopBudget:
    """Of the process as a whole. `late_*`: how late control ticks may be above a thread that only
    sleeps, at the same percentile."""

    late_p99_ms: float
    late_p999_ms: float
    late_max_ms: float
    detector_hz: float  # at least
    experts_share: float  # of the time that they score words, at least: else it was no test
    ready_s: float  # from the start until goals are taken
    first_command_s: float  # from the goal
    memory_mb: float
    growth_mb_h: float  # of memory, in an hour of driving


@dataclass(frozen=True)
class Budgets:
    """budgets.toml."""

    stages: Mapping[Stage, StageBudget]
    loop: LoopBudget


def read_budgets(path: Path | None = None) -> Budgets:
    """A file of budgets, the one that is shipped unless told; ConfigError, one line, for what
    cannot be read or is not known."""
    shipped = files("runtime.tracing") / "budgets.toml"
    place = str(path) if path else "budgets.toml"
    try:
        text = (path or shipped).read_text(encoding="utf-8")
        table = parse_toml(text)
    except OSError as error:
        raise ConfigError(f"{place}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise ConfigError(f"{place}: not valid TOML: {error}") from error
    _known(table, ("stages", "loop"), place)
    stages = _table(table.get("stages", {}), f"{place}: stages")
    _known(stages, tuple(Stage), f"{place}: stages")
    return Budgets(
        {Stage(name): _stage(value, f"{place}: stages.{name}") for name, value in stages.items()},
        _loop(_table(table.get("loop", {}), f"{place}: loop"), f"{place}: loop"),
    )


def _stage(value: Any, place: str) -> StageBudget:
    table = _table(value, place)
    _known(table, tuple(f.name for f in fields(StageBudget)), place)
    shed = table.get("shed", Shed.NOTHING)
    if shed not in tuple(Shed):
        raise ConfigError(f"{place}.shed: is {shed!r}; known are {', '.join(Shed)}")
    median_ms, p99_ms = (_number(table, name, place) for name in ("median_ms", "p99_ms"))
    return StageBudget(median_ms, p99_ms, Shed(shed))


def _loop(table: Mapping[str, Any], place: str) -> LoopBudget:
    names = tuple(f.name for f in fields(LoopBudget))
    _known(table, names, place)
    return LoopBudget(**{name: _number(table, name, place) for name in names})


def _table(value: Any, place: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise ConfigError(f"{place}: must be a table")
    return value


def _number(table: Mapping[str, Any], name: str, place: str) -> float:
    value = table.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not value > 0:
        raise ConfigError(f"{place}.{name}: is {value!r}, must be a number more than 0")
    return float(value)


def _known(table: Mapping[str, Any], names: tuple[str, ...], place: str) -> None:
    for name in table:
        if name not in names:
            raise ConfigError(f"{place}.{name}: unknown; known are {', '.join(names)}")
