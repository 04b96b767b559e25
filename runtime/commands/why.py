"""`rfnav why`: a decision, or a stop of the base, in words."""

import json
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

from runtime.commands.options import service_options
from runtime.commands.running import Running, running
from runtime.commands.status_screen import printable
from runtime.config import load
from runtime.core.motion.stops import stop_in_full
from runtime.core.voting.in_full import in_full
from runtime.service.told_journal import told_decisions, told_stops

NONE = {"decision": "Nothing was decided yet.", "stop": "Nothing has held the base yet."}


@click.command(
    "why",
    epilog="Examples:  rfnav why   |   rfnav why 12   |   rfnav why --stop   |   "
    "rfnav why --journal decisions.jsonl 3",
)
@click.argument("number", required=False, type=click.IntRange(1, 1_000_000_000))
@click.option("--stop", is_flag=True, help="A stop of the base, in place of a decision.")
@click.option(
    "--journal",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Of a search that is over: its decisions.jsonl.",
)
@service_options
@click.option("--json", "as_json", is_flag=True, help="As one JSON object.")
def why_command(
    number: int | None,
    stop: bool,
    journal: Path | None,
    path: Path | None,
    settings: tuple[str, ...],
    as_json: bool,
) -> None:
    """Say why the robot goes where it goes, and why it stood: who voted for what and what each had
    to go by; what held the base and what to do. Without NUMBER what it does now, the last decision
    and the last stop.

    Exit status 1 when there is none of that number, 2 when nobody answers.
    """
    kind = "stop" if stop else "decision"
    if journal is not None:
        answer = _of_journal(journal, kind, number)
    else:
        with running(load(path, settings).bus) as runtime:
            answer = _of_runtime(runtime, kind, number)
    if "error" in answer:
        click.echo(f"rfnav: {printable(str(answer['error']))}", err=True)
        sys.exit(1)
    if stop or journal is not None:
        answer = {kind: answer.get(kind)}
    lines = [json.dumps(answer)] if as_json else map(printable, _lines(answer))
    click.echo("\n".join(lines))


def _lines(answer: dict[str, Any]) -> Iterable[str]:
    if "now" in answer:
        yield f"Now: {answer['now']}."
    for n, kind in enumerate(kind for kind in NONE if kind in answer):
        if n or "now" in answer:
            yield ""
        told = answer[kind]
        yield from (told["in_words"] if told else [NONE[kind]])


def _of_runtime(runtime: Running, kind: str, number: int | None) -> dict[str, Any]:
    """A decision that it remembers no more is in the journal of its search, if that can be read."""
    answer = runtime.ask("why", {} if number is None else {kind: number})
    if "error" not in answer or kind != "decision":
        return answer
    journal = Path(runtime.ask("status", {}).get("journal") or "")
    if not journal.is_file() or not os.access(journal, os.R_OK):
        return answer
    kept = _of_journal(journal, kind, number)
    return answer if "error" in kept else kept


def _of_journal(path: Path, kind: str, number: int | None) -> dict[str, Any]:
    """As the runtime answers it."""
    told: dict[str, Any] | None = None
    if kind == "stop":
        stops = [s for s in told_stops(path) if number in (None, s.number)]
        if stops:
            told = vars(stops[-1]) | {"in_words": stop_in_full(stops[-1], None)}
    else:
        found = None
        for one in told_decisions(path):  # of which each is large
            found = one if number in (None, one.number) else found
        if found is not None:
            told = {"number": found.number, "goal": found.goal, "in_words": in_full(found)}
    if told is None and number is not None:
        return {"error": f"{path}: {kind} {number}: there is none"}
    return {kind: told}
