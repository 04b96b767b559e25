"""`rfnav places`, `place`, `zone`: names for places, and where the robot may not be."""

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import click

from runtime.commands.options import asked, json_option, service_options
from runtime.commands.status_screen import printable

NUMBERS_FIRST: Final = {"ignore_unknown_options": True}  # -1.0,2.5 is a place


@click.command("places", epilog="Examples:  rfnav places   |   rfnav places --json")
@json_option
@service_options
def places_command(as_json: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """List the places that have names, in metres of odometry's frame.

    Exit status 1 when there is none, 2 when nobody answers.
    """
    told = asked(path, settings, "places", {"list": True})
    _tell_places(told, as_json)
    sys.exit(0 if told["places"] else 1)


@click.command(
    "place",
    context_settings=NUMBERS_FIRST,
    epilog="Examples:  rfnav place dock here   |   rfnav place sofa 2.0,-1.0,1.57   |   "
    "rfnav place dock i-am-here   |   rfnav place sofa remove",
)
@click.argument("name")
@click.argument("where")
@json_option
@service_options
def place_command(
    name: str, where: str, as_json: bool, path: Path | None, settings: tuple[str, ...]
) -> None:
    """Give a place a NAME: WHERE is here, where the robot stands now, or X,Y[,YAW] in odometry's
    frame. With i-am-here it is told that it stands at that place; remove takes the name away.

    Exit status 2 when it was refused, or nobody answers.
    """
    body: dict[str, object]
    match where:
        case "here":
            body = {"name": name}
        case "i-am-here":
            body = {"i_am_at": name}
        case "remove":
            body = {"remove": name}
        case _:
            at = _numbers(where, (2, 3), "here, i-am-here, remove or X,Y[,YAW]")
            body = {"name": name, "at": [*at, 0.0][:3]}
    _tell_places(asked(path, settings, "places", body), as_json)


@click.group("zone", epilog="Example:  rfnav zone add stairs 2,-1 3.5,-1 3.5,0.5 2,0.5")
def zone_command() -> None:
    """Zones that the robot's body stays out of."""


@zone_command.command("list", epilog="Example:  rfnav zone list")
@json_option
@service_options
def zone_list(as_json: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """List them, with their corners in metres of odometry's frame."""
    _tell_zones(asked(path, settings, "zones", {"list": True}), as_json)


@zone_command.command(
    "add",
    context_settings=NUMBERS_FIRST,
    epilog="Example:  rfnav zone add stairs 2,-1 3.5,-1 3.5,0.5 2,0.5",
)
@click.argument("name")
@click.argument("corners", nargs=-1, required=True)
@json_option
@service_options
def zone_add(
    name: str, corners: tuple[str, ...], as_json: bool, path: Path | None,
    settings: tuple[str, ...],
) -> None:  # fmt: skip
    """Draw a zone called NAME by its CORNERS, X,Y each, in order; one of that name is drawn anew.

    Exit status 2 when it was refused, or nobody answers.
    """
    polygon = [_numbers(corner, (2,), "X,Y") for corner in corners]
    _tell_zones(asked(path, settings, "zones", {"add": name, "polygon": polygon}), as_json)


@zone_command.command("remove", epilog="Example:  rfnav zone remove stairs")
@click.argument("name")
@json_option
@service_options
def zone_remove(name: str, as_json: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """Take the zone called NAME away.

    Exit status 2 when it was refused, or nobody answers.
    """
    _tell_zones(asked(path, settings, "zones", {"remove": name}), as_json)


@zone_command.command("clear", epilog="Example:  rfnav zone clear")
@json_option
@service_options
def zone_clear(as_json: bool, path: Path | None, settings: tuple[str, ...]) -> None:
    """Take all zones away."""
    _tell_zones(asked(path, settings, "zones", {"clear": True}), as_json)


def _tell_places(told: Mapping[str, Any], as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps(told, ensure_ascii=False))
        return
    for name, at in told["places"].items():
        where = "not known where" if at is None else "at {:.2f}, {:.2f} m, yaw {:.2f}".format(*at)
        click.echo(printable(f"{name}: {where}"))
    if not told["places"]:
        click.echo("no place has a name", err=True)
    if not told["memory"].startswith("none"):  # nothing is known from before a restart
        click.echo(printable(f"home: {told['memory']}"), err=True)


def _tell_zones(told: Mapping[str, Any], as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps(told, ensure_ascii=False))
        return
    for zone in told["zones"]:
        corners = " ".join(f"{x:.2f},{y:.2f}" for x, y in zone["polygon"])
        click.echo(printable(f"{zone['name']}: {corners}"))
    if not told["zones"]:
        click.echo("there is no zone", err=True)
    if warning := told.get("warning"):
        click.echo(printable(f"rfnav: {warning}"), err=True)


def _numbers(told: str, counts: tuple[int, ...], form: str) -> list[float]:
    try:
        numbers = [float(part) for part in told.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts:
        raise click.UsageError(f"{told}: must be {form}")
    return numbers
