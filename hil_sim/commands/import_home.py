"""`hil-sim import`: a home drawn with Sweet Home 3D, as a scene to try the robot in."""

import json
from pathlib import Path

import click

from hil_sim.importers.sweethome import ImportedHome, bring_in
from hil_sim.scenes.format import SceneError
from hil_sim.scenes.sweethome.importer import Report

GOALS = ("bed", "toilet", "sofa", "television", "plant", "chair")
"""Suggested first."""


@click.command(
    "import",
    epilog="Examples:  hil-sim import home.sh3d   |   "
    'hil-sim import home.sh3d --out out/our-home --level "Ground floor"',
)
@click.argument("home", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Default: out/HOME.")
@click.option("--level", help="Default: of the storeys with rooms, that nearest the ground.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Write the summary.")
@click.option("--check/--no-check", default=True, help="Whether to see which rooms can be reached.")
def import_command(
    home: Path, out: Path | None, level: str | None, json_file: Path | None, check: bool
) -> None:
    """Turn HOME, a Sweet Home 3D file (.sh3d), into a scene.

    Writes OUT/{scene.json, meshes/} and says what was understood. Models embedded as OBJ are kept;
    pieces with other models become boxes. Exit status: 0 done, 2 an error.
    """
    folder = out or Path("out") / (home.stem or "home")
    made = bring_in(home, folder, level, check)
    lines = _told(made.report)
    if made.reached is not None:
        lines.append(_reach_line(made.reached))
    click.echo("\n".join(lines))
    click.echo(f"written: {made.path}\nnext:    hil-sim show {made.path} --out {folder}")
    click.echo(f"         {_search_line(made)}")
    if json_file:
        _write_json(json_file, made)


def _told(report: Report) -> list[str]:
    counts = [f"{what} {n}" for what, n in report.counts.items() if n]
    lines = [", ".join(counts)]
    if report.rooms:
        lines.append("rooms: " + ", ".join(f"{n} ({kind})" for n, kind in report.rooms.items()))
    if report.categories:
        lines.append("pieces: " + ", ".join(f"{c} {n}" for c, n in report.categories.items()))
    return lines + [f"note: {note}" for note in report.notes]


def _search_line(made: ImportedHome) -> str:
    """What to type to have the robot search the home; where nothing can be a goal, what to do."""
    found = [category for category in made.report.categories if category != "other"]
    goal = next((c for c in (*GOALS, *found) if c in found), None)
    if goal is None:
        return (
            "no piece here can be a goal: place or rename one in the drawing "
            '(such as "Sofa" or "Bed"), and import it again'
        )
    return f'hil-sim demo --scene {made.path} --goal "{goal}"'


def _reach_line(reached: dict[str, bool]) -> str:
    cut_off = [name for name, there in reached.items() if not there]
    if not cut_off:
        return "the robot can reach every room"
    return (
        f"the robot cannot reach: {', '.join(cut_off)} (a door that is missing, blocked or under "
        "0.5 m wide, or a floor that is full)"
    )


def _write_json(file: Path, made: ImportedHome) -> None:
    data = {"scene": str(made.path), **vars(made.report), "reachable": made.reached}
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{file}: cannot be written ({error.strerror})") from None
