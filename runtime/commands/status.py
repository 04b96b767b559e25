"""`rfnav status`: how the running service stands."""

import json
import os
import shutil
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import click

from runtime.commands.options import service_options
from runtime.commands.running import Running, running
from runtime.commands.status_screen import screen, wrong
from runtime.config import Config, load
from runtime.errors import BusError
from runtime.robot.heard_topics import heard_topics
from runtime.tracing.budgets import read_budgets

LIVELY: Final = ("color", "depth", "odom")
BETWEEN_S: Final = 1.0  # two answers, of which the second is shown with what came since the first
HOME, REST_OF_LINE, REST = "\x1b[H", "\x1b[K", "\x1b[J"


@click.command("status", epilog="Examples:  rfnav status   |   rfnav status --watch")
@click.option("--watch", is_flag=True, help="Go on, redrawn in place, until Ctrl-C.")
@click.option("--json", "as_json", is_flag=True, help="The service's own answer, with `wrong`.")
@service_options
def status_command(
    watch: bool, as_json: bool, path: Path | None, settings: tuple[str, ...]
) -> None:
    """Show on one screen what the service does, what it lives on and what is wrong with it.

    Exit status 0 when all is well, 1 when something is wrong, which is said first, 2 when nobody is
    there.
    """
    config = load(path, settings)
    needed = _needed(config)
    with running(config.bus) as runtime:
        problems = _watched(runtime, needed, as_json) if watch else _once(runtime, needed, as_json)
    sys.exit(1 if problems else 0)


def _once(runtime: Running, needed: Sequence[str], as_json: bool) -> list[str]:
    """Print it; what is wrong."""
    before = status = runtime.ask("status", {})
    if not as_json:
        time.sleep(BETWEEN_S)
        status = runtime.ask("status", {})
    click.echo("\n".join(_lines(status, before, needed, as_json)))
    return wrong(status, needed)


def _needed(config: Config) -> tuple[str, ...]:
    """Topics on which something new comes all the time, or no search goes on."""
    topics = heard_topics(config.bus)
    return tuple(topics[name].name for name in LIVELY)


def _watched(runtime: Running, needed: Sequence[str], as_json: bool) -> list[str]:
    """Print it again and again until Ctrl-C; what was wrong last. A service that is away for a
    while is waited for."""
    in_place = sys.stdout.isatty() and os.environ.get("TERM") != "dumb" and not as_json
    before, problems = dict[str, Any](), list[str]()
    with suppress(KeyboardInterrupt):
        while True:
            try:
                status = runtime.ask("status", {})
                lines, problems = _lines(status, before, needed, as_json), wrong(status, needed)
                before = status
            except BusError as error:
                lines = problems = [f"rfnav: {error}"]
            click.echo(_drawn(lines) if in_place else "\n".join(lines), color=True)
            time.sleep(BETWEEN_S)
    return problems


def _lines(
    status: dict[str, Any], before: dict[str, Any], needed: Sequence[str], as_json: bool
) -> list[str]:
    if as_json:
        return [json.dumps({"wrong": wrong(status, needed), **status}, ensure_ascii=False)]
    return screen(status, before, needed, read_budgets())


def _drawn(lines: Sequence[str]) -> str:
    """Over what was drawn before, as much as the terminal has room for."""
    columns, rows = shutil.get_terminal_size()
    shown = [line[:columns] for line in lines[: rows - 1]]
    return HOME + "".join(f"{line}{REST_OF_LINE}\n" for line in shown) + REST
