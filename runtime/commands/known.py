"""`rfnav things`, `where`, `map`: what the running service knows of the home."""

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import click
import cv2

from runtime.commands.map_picture import picture
from runtime.commands.options import asked, json_option, service_options, taken
from runtime.commands.running import running
from runtime.commands.status_screen import printable
from runtime.config import load
from runtime.errors import ConfigError

NOTHING: Final = "nothing is known yet: rfnav find has it look around"


@click.command("things", epilog="Examples:  rfnav things   |   rfnav things --json")
@json_option
@service_options
def things_command(as_json: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """List the things on the robot's map, the surest first: where, how large, in which room.

    Positions are metres of odometry's frame. Exit status 1 when there is none, 2 when nobody
    answers.
    """
    told = asked(path, settings, "things", {})
    if as_json:
        click.echo(json.dumps(told, ensure_ascii=False))
    elif not told["things"]:
        click.echo(f"rfnav: {told.get('said') or 'no thing is on the map yet'}", err=True)
    else:
        click.echo(f"{'sure':>5}  {'thing':20}{'at x, y m':>15}{'size m':>18}  room")
        for thing in told["things"]:
            click.echo(printable(_row(thing)))
        if told.get("left_off"):
            click.echo(f"and {told['left_off']} more, less sure")
    sys.exit(0 if told["things"] else 1)


def _row(thing: Mapping[str, Any]) -> str:
    x, y = thing["xy"]
    at, size = f"{x:.1f}, {y:.1f}", " x ".join(f"{side:.1f}" for side in thing["size_m"])
    sure = f"{100 * thing['confidence']:.0f} %"
    return f"{sure:>5}  {thing['name']:20}{at:>15}{size:>18}  {thing['room'] or '?'}"


@click.command("where", epilog='Examples:  rfnav where mug   |   rfnav where "coffee table" --json')
@click.argument("name")
@json_option
@service_options
def where_command(name: str, as_json: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """Say where a thing called NAME was seen, or else where the search that is on expects it. The
    robot does not move for it.

    Exit status 0 when it was seen, 1 when not, 2 when nobody answers.
    """
    told = asked(path, settings, "where", {"name": name})
    if as_json:
        click.echo(json.dumps(told, ensure_ascii=False))
    else:
        for line in _where_lines(told):
            click.echo(printable(line))
    sys.exit(0 if told["found"] else 1)


def _where_lines(told: Mapping[str, Any]) -> list[str]:
    called = told["called"]
    lines = [f"{called}: {_at(one)}, {100 * one['confidence']:.0f} % sure" for one in told["found"]]
    if lines:
        return lines
    lines = [f"{called}: not seen yet{': ' + told['said'] if told.get('said') else ''}"]
    for one in told["expected"]:
        why = f": {one['why']}" if one["why"] else ""
        x, y = one["xy"]
        at = f"{one['kind']} {one['id']}, at ({x:.1f}, {y:.1f}) m"
        lines.append(f"  expected {100 * one['p']:.0f} %: {at}{why}")
    return lines


def _at(thing: Mapping[str, Any]) -> str:
    x, y = thing["xy"]
    return f"at ({x:.1f}, {y:.1f}) m" + (f" in the {thing['room']}" if thing["room"] else "")


@click.command("map", epilog="Examples:  rfnav map --out map.png   |   rfnav map --json")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="PNG to write.")
@json_option
@service_options
def map_command(
    out: Path | None, as_json: bool, path: Path | None, settings: tuple[str, ...]
) -> None:
    """Draw what the robot knows of the home: floor, obstacles, rooms, things, frontiers, zones and
    places, the way that it drove and the way that it plans.

    Exit status 1 while nothing is known, 2 when nobody answers.
    """
    if (out is None) == (not as_json):
        raise click.UsageError("say --out map.png, or --json")
    with running(load(path, settings).bus) as runtime:
        told = taken(runtime, "map", {})
        if out is not None and told["rows"]:
            things = taken(runtime, "things", {})["things"]
            zones = runtime.ask("zones", {"list": True}).get("zones", ())
            places = runtime.ask("places", {"list": True}).get("places", {})  # under a harness none
            _write(out, picture(told, things, zones, places))
    if as_json:
        click.echo(json.dumps(told, ensure_ascii=False))
    elif not told["rows"]:
        click.echo(f"rfnav: {NOTHING}", err=True)
    else:
        click.echo(f"{out}: {len(things)} things, {len(told['frontiers'])} frontiers")
    sys.exit(0 if told["rows"] else 1)


def _write(out: Path, image: Any) -> None:
    done, raw = cv2.imencode(".png", image)
    assert done
    try:
        out.write_bytes(raw.tobytes())
    except OSError as error:
        raise ConfigError(f"{out}: cannot be written ({error.strerror})") from error
