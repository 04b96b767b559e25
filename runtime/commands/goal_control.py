"""`rfnav cancel`, `rfnav pause`, `rfnav resume`, `rfnav ask`: what else is asked of the running
service."""

import json
import sys
from pathlib import Path
from typing import Any, Final

import click

from runtime.commands.options import json_option, service_options
from runtime.commands.running import running
from runtime.commands.status_screen import printable
from runtime.config import load
from runtime.errors import SensorError
from runtime.robot.json_text import parse_json
from runtime.service.limits import MOST

ANSWERED_S: Final = 60.0  # what is written at a search's end takes a while on a slow disk
RESULT_S: Final = MOST["time_s"]  # answered when the goal ends


def _asked(
    kind: str, body: dict[str, object], path: Path | None, settings: tuple[str, ...]
) -> dict[str, Any]:
    with running(load(path, settings).bus) as runtime:
        return runtime.ask(kind, body, RESULT_S if kind == "result" else ANSWERED_S)


@click.command("cancel", epilog="Examples:  rfnav cancel   |   rfnav cancel 5f3a09c1")
@click.argument("id", required=False)
@json_option
@service_options
def cancel_command(
    id: str | None, as_json: bool, path: Path | None, settings: tuple[str, ...]
) -> None:
    """End the goal under way and all that wait, or the one of that ID alone.

    Exit status 1 when there is none, 2 when nobody answers.
    """
    body: dict[str, object] = {} if id is None else {"id": id}
    answer = _asked("cancel", {"reason": "rfnav cancel", **body}, path, settings)
    if "error" not in answer and not answer.get("ended"):
        answer = {"error": "nothing is under way"}
    _tell(
        answer,
        answer.get("sentence") or f"cancelled: {', '.join(answer.get('cancelled', ()))}",
        as_json,
    )


@click.command("pause", epilog="Example:  rfnav pause")
@json_option
@service_options
def pause_command(as_json: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """Have the robot stand until `rfnav resume`; it goes on looking, and its time stands still.

    Exit status 1 when nothing is under way, 2 when nobody answers.
    """
    _told(_asked("pause", {}, path, settings), "paused", as_json)


@click.command("resume", epilog="Example:  rfnav resume")
@json_option
@service_options
def resume_command(as_json: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """Have a paused robot go on.

    Exit status 1 when nothing is under way, 2 when nobody answers.
    """
    _told(_asked("resume", {}, path, settings), "goes on", as_json)


def _told(answer: dict[str, Any], what: str, as_json: bool) -> None:
    _tell(answer, f"{answer.get('id')}: {what}", as_json)


def _tell(answer: dict[str, Any], in_words: str, as_json: bool) -> None:
    """What came of it; exit status 1 where nothing did."""
    if as_json:
        click.echo(json.dumps(answer, ensure_ascii=False))
    elif "error" in answer:
        click.echo(printable(f"rfnav: {answer['error']}"), err=True)
    else:
        click.echo(printable(in_words))
    sys.exit(1 if "error" in answer else 0)


@click.command("ask", epilog="Examples:  rfnav ask stop   |   rfnav ask zones '{\"list\": true}'")
@click.argument("kind")
@click.argument("request", default="{}")
@service_options
def ask_command(kind: str, request: str, path: Path | None, settings: tuple[str, ...]) -> None:
    """Send the JSON REQUEST to rfnav/KIND and print the JSON that is answered: goal, cancel, pause,
    resume, result, status, why, things, where, map, zones, places, stop, release.

    Exit status 1 when it was refused, 2 when it is no JSON or nobody answers.
    """
    try:
        body = parse_json(request, "REQUEST")
    except SensorError as error:
        raise click.UsageError(str(error)) from error
    answer = _asked(kind.removeprefix("rfnav/"), body, path, settings)
    click.echo(json.dumps(answer, ensure_ascii=False))
    sys.exit(1 if answer.get("accepted") is False or "error" in answer else 0)
