"""`rfnav find`, `rfnav go`: ask the service for something, and wait for what comes of it."""

import json
import shutil
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TextIO

import click

from runtime.commands.running import Running, running
from runtime.commands.status_screen import printable
from runtime.config import load
from runtime.errors import BusError, SilentError

TAKEN_S: Final = 60.0  # a goal's words may have to be understood by a model that is slow
EVERY_S: Final = 0.5
AWAY_S: Final = 90.0  # so long a service that is started anew is waited for
LOADED_S: Final = 300.0  # and one whose models load
SILENT: Final = "rfnav run is there, and answers nothing yet: its models load, or it is busy"
TAKEN_YET: Final = "it may be taken yet: rfnav cancel ends all goals"
START, REST_OF_LINE = "\r", "\x1b[K"
STOPPED: Final = "Ctrl-C in rfnav find"


OPTIONS: Final = (
    click.option("--queue", is_flag=True, help="Wait for what is under way; else take its place."),
    click.option("--limit-time", type=float, metavar="S", help="Seconds that each may take."),
    click.option("--limit-distance", type=float, metavar="M", help="Metres that each may take."),
    click.option("--return", "returns", is_flag=True, help="Then go back to where it began."),
    click.option("--return-to", metavar="PLACE", help="Then go to that place."),
    click.option("--no-wait", is_flag=True, help="Only ask; it goes on by itself."),
    click.option("--json", "as_json", is_flag=True, help="The answer with all results, as JSON."),
    click.option(
        "--config", "path", type=click.Path(path_type=Path), help="The robot's TOML file."
    ),
    click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="Override one key."),
)
"""Of all goals."""


def with_options(command: Callable[..., None]) -> Callable[..., None]:
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@click.command(
    "find",
    epilog='Examples:  rfnav find "a red mug" --limit-time 300 --return   |   '
    'rfnav find "a mug, then a chair"   |   rfnav find bed --queue --no-wait',
)
@click.argument("text")
@click.option("--then", multiple=True, metavar="TEXT", help="Look for that after it; repeatable.")
@click.option("--each", is_flag=True, help="Of several things in a text, one after the other.")
@click.option("--limit-money", type=float, metavar="USD", help="What each may cost in a cloud.")
@click.option("--area-room", metavar="ROOM", help="Only in rooms of that type.")
@click.option("--area-place", metavar="PLACE", help="Only about that place.")
@with_options
def find_command(
    text: str,
    then: tuple[str, ...],
    each: bool,
    limit_money: float | None,
    area_room: str | None,
    area_place: str | None,
    **how: Any,
) -> None:
    """Have the robot look for TEXT, and wait: how it was understood, how it goes, what came of it.

    Ctrl-C cancels it. Exit status 0 when all that was asked for was found, 1 when not, 2 when it
    was not taken or nobody answers.
    """
    body: dict[str, Any] = {"goal": [text, *then] if then else text}
    body |= {"several": "in_turn"} if each else {}
    area = {"room": area_room, "place": area_place}
    if any(area.values()):
        body["area"] = {kind: name for kind, name in area.items() if name}
    _ask_for(body, limit_money, **how)


@click.command(
    "go",
    context_settings={"ignore_unknown_options": True},  # -1.0,2.5 is a place
    epilog='Examples:  rfnav go "kitchen table"   |   rfnav go -1.5,2.0   |   rfnav go 1,0,3.14',
)
@click.argument("place")
@with_options
def go_command(place: str, **how: Any) -> None:
    """Have the robot go to PLACE, a name or X,Y[,YAW] in odometry's frame, and wait.

    Ctrl-C cancels it. Exit status 0 when it has arrived, 1 when not, 2 when it was not taken or
    nobody answers.
    """
    _ask_for({"go_to": _place(place)}, None, **how)


def _place(told: str) -> str | dict[str, float]:
    parts = told.split(",")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        return told
    if len(numbers) not in (2, 3):
        raise click.UsageError(f"{told}: a place is a name or X,Y[,YAW]")
    return dict(zip(("x_m", "y_m", "yaw_rad"), numbers, strict=False))


def _ask_for(
    body: dict[str, Any],
    limit_money: float | None,
    queue: bool,
    limit_time: float | None,
    limit_distance: float | None,
    returns: bool,
    return_to: str | None,
    no_wait: bool,
    as_json: bool,
    path: Path | None,
    settings: tuple[str, ...],
) -> None:
    """Ask, wait, and end with the exit status."""
    amounts = {"time_s": limit_time, "distance_m": limit_distance, "money_usd": limit_money}
    body["limits"] = {name: value for name, value in amounts.items() if value is not None}
    body |= {"if_busy": "queue"} if queue else {}
    body |= {"afterwards": "return"} if returns else {}
    body |= {"afterwards": {"place": return_to}} if return_to else {}
    with running(load(path, settings).bus) as runtime:
        _await_answers(runtime, as_json)
        answer = _taken(runtime, body)
        if not answer.get("accepted"):
            why = json.dumps(answer) if as_json else printable(f"rfnav: {answer['error']}")
            click.echo(why, err=not as_json)
            sys.exit(2)
        goals = [answer, *answer.get("then", ())]
        for goal in () if as_json else goals:
            click.echo(printable(f"{goal['id']}: {goal['how']}"))
        results = [] if no_wait else _waited(runtime, [str(g["id"]) for g in goals], as_json)
    if as_json:
        told = answer if no_wait else {**answer, "results": results}
        click.echo(json.dumps(told, ensure_ascii=False))
    sys.exit(0 if all(told["code"] == 0 for told in results) else 1)


def _await_answers(runtime: Running, quiet: bool) -> None:
    """Return once it answers at all: what is asked of it before that waits there, and would be
    begun when nobody is here any more. BusError after a while, or where nobody is there."""
    progress, by_s = SoFar(sys.stderr, quiet), time.monotonic() + LOADED_S
    while True:
        try:
            told = runtime.ask("status", {})
            if told.get("accepted") is not False:
                progress.clear()
                return
            why = BusError(f"{runtime.where}: {told['error']}")  # as many wait as may
        except SilentError as error:
            why = error
        if time.monotonic() > by_s:
            raise why
        progress.say(SILENT)
        time.sleep(EVERY_S)


def _taken(runtime: Running, body: Mapping[str, Any]) -> dict[str, Any]:
    """The answer. Until it comes the goal has no id that it could be cancelled by."""
    try:
        return runtime.ask("goal", body, TAKEN_S)
    except SilentError as error:
        raise BusError(f"{error}; {TAKEN_YET}") from error
    except KeyboardInterrupt:
        click.echo(f"rfnav: {TAKEN_YET}", err=True)
        sys.exit(130)


def _waited(runtime: Running, ids: Sequence[str], quiet: bool) -> list[dict[str, Any]]:
    """The results, in order, each said when it comes."""
    progress, results = SoFar(sys.stderr, quiet), list[dict[str, Any]]()
    try:
        for id in ids:
            told = _result(runtime, id, progress)
            progress.clear()
            results.append(told)
            if not quiet:
                click.echo(printable(told["sentence"]))
    except KeyboardInterrupt:
        progress.clear()
        for id in reversed(ids[len(results) :]):  # or the next would begin
            runtime.ask("cancel", {"id": id, "reason": STOPPED}, TAKEN_S)
            click.echo(f"{id}: cancelled", err=True)
        sys.exit(130)
    return results


def _result(runtime: Running, id: str, progress: "SoFar") -> dict[str, Any]:
    """What came of a goal, when it has ended; BusError when that will not be known."""
    away_s: float | None = None
    while True:
        try:
            told = runtime.ask("result", {"id": id, "wait": False})
            if told.get("accepted") is False:  # it ends just now, or is busy
                raise BusError(f"{runtime.where}: {told['error']}")
            away_s = None
        except BusError:
            away_s = time.monotonic() if away_s is None else away_s
            if time.monotonic() - away_s > AWAY_S:
                raise
            progress.say("nobody answers: is the service started anew?")
            time.sleep(EVERY_S)
            continue
        if "error" in told:
            raise BusError(f"{runtime.where}: {told['error']}: the service was started anew")
        if told["result"] is not None:
            return told
        progress.show(told)
        time.sleep(EVERY_S)


class SoFar:
    """On a terminal one line that is drawn anew; elsewhere a line where something has changed."""

    def __init__(self, out: TextIO, quiet: bool) -> None:
        self._out, self._quiet, self._in_place = out, quiet, out.isatty()
        self._said = ""

    def show(self, told: Mapping[str, Any]) -> None:
        """How a goal stands that has not ended, as `rfnav/result` answers it."""
        newest = told["feedback"]
        if told["ahead"] or not newest:
            self.say(f"{told['id']}: waits for {told['ahead']} before it" if told["ahead"] else "")
            return
        spent = f", {newest['usd']:.3f} USD" if newest.get("usd") else ""
        so_far = f"{newest['elapsed_s']:.0f} s, {newest['driven_m']:.1f} m{spent}"
        left = f"frontiers left: {newest['frontiers']}"
        self.say(str(newest["reason"] or newest["state"]), f"{so_far}, {left}")

    def say(self, what: str, so_far: str = "") -> None:
        if self._quiet or not what or (what == self._said and not self._in_place):
            return
        self._said = what
        line = printable(f"{what} ({so_far})" if so_far else what)
        if self._in_place:
            self._out.write(
                f"{START}{line[: shutil.get_terminal_size().columns - 1]}{REST_OF_LINE}"
            )
            self._out.flush()
        else:
            self._out.write(f"{line}\n")

    def clear(self) -> None:
        """A line of another kind follows."""
        if self._in_place and self._said:
            self._out.write(f"{START}{REST_OF_LINE}")
            self._out.flush()
        self._said = ""
