"""`rfnav doctor`: what a robot is like on the bus, and what keeps it from searching."""

import json
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import click

from runtime import config as configuration
from runtime.clock import SystemClock
from runtime.config import Config
from runtime.doctor.diagnosis import Diagnosis, can_search, fitting, verdict
from runtime.doctor.examination import Examined, Instruments, examine
from runtime.doctor.hearing import HeardTopic
from runtime.doctor.network import first_steps
from runtime.doctor.topics import table
from runtime.journal import plain
from runtime.log import say
from runtime.loops.process import prepare
from runtime.perception.configured_models import check_models, check_present
from runtime.perception.loaded_models import LoadedModels
from runtime.tracing.budgets import read_budgets

LISTEN_S = 10.0
ABOUT, GRADE = 17, 9  # columns of what a finding is about, and of how grave it is
NARROW, WIDE = 60, 130


@click.command(
    "doctor",
    epilog="Examples:  rfnav doctor   |   rfnav doctor --config robot.toml --turn",
)
@click.option(
    "--config", "path", type=click.Path(path_type=Path), help="TOML file; defaults otherwise."
)
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="As of rfnav run.")
@click.option(
    "--seconds",
    type=click.FloatRange(1.0, 120.0),
    default=LISTEN_S,
    show_default=True,
    help="How long it listens.",
)
@click.option(
    "--turn", is_flag=True, help="Turn the robot once on the spot, to the left. Ctrl-C stops it."
)
@click.option("--json", "as_json", is_flag=True, help="Print all of it as JSON.")
def doctor_command(
    path: Path | None, settings: tuple[str, ...], seconds: float, turn: bool, as_json: bool
) -> None:
    """Listen to the robot and say what of it is well, what is not, and what to do about that.

    Exit status 0 when a search could start, 1 when not.
    """
    config, budgets = configuration.load(path, settings), read_budgets(None)
    clock = SystemClock()
    if turn:
        prepare()

    def load(config: Config, book: Callable[[float], None]) -> LoadedModels:
        check_models(config.models)
        check_present(config.models)
        return LoadedModels(config, clock, book)

    by = Instruments(clock, budgets, load, say)
    examined = examine(config, seconds, turn, by)
    for line in [_json(examined, config)] if as_json else _text(examined, config):
        click.echo(line)
    sys.exit(0 if can_search(examined.found) else 1)


def _text(examined: Examined, config: Config) -> Iterator[str]:
    """The topics in columns, then every finding with its remedy, then what would fit."""
    columns = min(WIDE, max(NARROW, shutil.get_terminal_size((WIDE, 0)).columns))
    rows = table(examined.hearing, config)
    yield from rows
    for n, (part, found) in enumerate(examined.parts.items()):
        if found:
            yield from ("", part) if n or rows else (part,)
        for one in found:
            yield from _finding(one, columns)
    if fits := fitting(examined.found):
        yield from ("", "what would fit, for the configuration:", "", fits)
    yield from ("", verdict(examined.found))
    yield from first_steps(examined.hearing.network, config)


def _finding(one: Diagnosis, columns: int) -> Iterator[str]:
    head = f"  {one.grade:<{GRADE}} {one.about:<{ABOUT}} "
    yield from _wrapped(head, one.told, columns)
    if one.remedy:
        yield from _wrapped(" " * len(head) + "-> ", one.remedy, columns)


def _wrapped(head: str, text: str, columns: int) -> Iterator[str]:
    lines = textwrap.wrap(
        text, max(20, columns - len(head)), break_long_words=False, break_on_hyphens=False
    )
    for n, line in enumerate(lines or [""]):
        yield f"{head if n == 0 else ' ' * len(head)}{line}".rstrip()


def _json(examined: Examined, config: Config) -> str:
    told = {
        "ready": can_search(examined.found),
        "topics": {name: _figures(one, config) for name, one in examined.hearing.streams.items()},
        "found": [
            {"part": part, **plain(one)} for part, found in examined.parts.items() for one in found
        ],
    }
    return json.dumps(told, indent=1)


def _figures(heard: HeardTopic, config: Config) -> dict[str, object]:
    """What the table of topics has in columns."""
    return {
        "topic": config.bus.key(heard.topic),
        "kind": heard.kind,
        "received": heard.received,
        "bad": heard.bad,
        "rate_hz": heard.rate_hz,
        "jitter_s": heard.jitter_s,
        "age_s": heard.age_s,
        "what": heard.what,
        "frame": heard.frame,
        "error": heard.error,
    }
