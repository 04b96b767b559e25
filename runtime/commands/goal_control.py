"""`rfnav cancel`, `rfnav pause`, `rfnav resume`, `rfnav ask`: what else is asked of the running
service."""

import json
import sys
from pathlib import Path
from typing import Any, Final

import click

from runtime.commands.options import service_options
from runtime.commands.running import running
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
@service_options
def cancel_command(id: str | None, path: Path | None, settings: tuple[str, ...]) -> None:
    """End the goal under way and all that wait, or the one of that ID alone.

    Exit status 1 when there is none, 2 when nobody answers.
    """
    body: dict[str, object] = {} if id is None else {"id": id}
    answer = _asked("cancel", {"reason": "rfnav cancel", **body}, path, settings)
    if "error" in answer or not answer.get("ended"):
        click.echo(f"rfnav: {answer.get('error', 'nothing is under way')}", err=True)
        sys.exit(1)
    click.echo(answer.get("sentence") or f"cancelled: {', '.join(answer.get('cancelled', ()))}")


@click.command("pause", epilog="Example:  rfnav pause")
@service_options
def pause_command(path: Path | None, settings: tuple[str, ...]) -> None:
    """Have the robot stand until `rfnav resume`; it goes on looking, and its time stands still.

    Exit status 1 when nothing is under way, 2 when nobody answers.
    """
    _told(_asked("pause", {}, path, settings), "paused")


@click.command("resume", epilog="Example:  rfnav resume")
@service_options
def resume_command(path: Path | None, settings: tuple[str, ...]) -> None:
    """Have a paused robot go on.

    Exit status 1 when nothing is under way, 2 when nobody answers.
    """
    _told(_asked("resume", {}, path, settings), "goes on")


def _told(answer: dict[str, Any], what: str) -> None:
    if "error" in answer:
        click.echo(f"rfnav: {answer['error']}", err=True)
        sys.exit(1)
    click.echo(f"{answer['id']}: {what}")


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
