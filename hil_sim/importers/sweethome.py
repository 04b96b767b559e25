"""`hil-sim import`: a home drawn with Sweet Home 3D, as a scene to try the robot in."""

import json
from pathlib import Path
from typing import Any

import click
import cv2
import numpy as np

from hil_sim.scenes.format import Scene, SceneError, contains, load_scene, save_scene
from hil_sim.scenes.sweethome.importer import Report, import_home
from hil_sim.simulation.quiet import hushed, keep_stdout_for_python

SCENE_FILE = "scene.json"
GOALS = ("bed", "toilet", "sofa", "television", "plant", "chair")
"""Suggested first."""


@click.command(
    "import",
    epilog="Examples:  hil-sim import home.sh3d   |   "
    'hil-sim import home.sh3d --out out/our-home --level "Ground floor"',
)
@click.argument("home", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Default: out/HOME.")
@click.option("--level", help="The storey to import; default: the ground floor.")
@click.option("--json", "json_file", type=click.Path(path_type=Path), help="Write the summary.")
@click.option("--check/--no-check", default=True, help="Whether to see which rooms can be reached.")
def import_command(
    home: Path, out: Path | None, level: str | None, json_file: Path | None, check: bool
) -> None:
    """Turn HOME, a Sweet Home 3D file (.sh3d), into a scene.

    Writes OUT/{scene.json, meshes/} and says what was understood. Models embedded as OBJ are kept;
    pieces with other models become boxes. Exit status: 0 done, 2 an error.
    """
    keep_stdout_for_python()
    with hushed():
        from hil_sim.scenes.furniture.assets import Assets

    folder = out or Path("out") / (home.stem or "home")
    assets = Assets()
    known = frozenset(assets.catalog.models) if assets.present else frozenset[str]()
    with hushed():  # OpenCV comments on damaged textures
        scene, report = import_home(home, folder, level, known)
    path = folder / SCENE_FILE
    _write(scene, path)
    lines = _told(report)
    reached: dict[str, bool] | None = None
    if check:
        reached = reachable(load_scene(path), assets)
        lines.append(_reach_line(reached))
        spawn = tuple(r.polygon for r in scene.rooms if reached[r.name])
        if spawn and len(spawn) < len(scene.rooms):
            _write(Scene(**{**vars(scene), "spawn": spawn}), path)
    click.echo("\n".join(lines))
    click.echo(f"written: {path}\nnext:    hil-sim show {path} --out {folder}")
    goal = next((c for c in (*GOALS, *report.categories) if c in report.categories), "bed")
    click.echo(f'         hil-sim demo --scene {path} --goal "{goal}"')
    if json_file:
        _write_json(json_file, path, report, reached)


def reachable(scene: Scene, assets: Any) -> dict[str, bool]:
    """Room -> whether the robot can stand in it and drive there from most of the home."""
    with hushed():
        from hil_sim.ground_truth.freespace import build_free_space
        from hil_sim.simulation.scene_physics import ScenePhysics

    with ScenePhysics(scene, assets, "tiny") as world:
        space = build_free_space(scene, world.obstacle_triangles())
    count, names = cv2.connectedComponents(space.free.astype(np.uint8), connectivity=4)
    if count < 2:
        return dict.fromkeys((room.name for room in scene.rooms), False)
    largest = 1 + int(np.argmax(np.bincount(names.ravel(), minlength=count)[1:]))
    points = space.points(np.argwhere(names == largest))
    return {room.name: any(contains(room.polygon, x, y) for x, y in points) for room in scene.rooms}


def _told(report: Report) -> list[str]:
    counts = [f"{what} {n}" for what, n in report.counts.items() if n]
    lines = [", ".join(counts)]
    if report.rooms:
        lines.append("rooms: " + ", ".join(f"{n} ({kind})" for n, kind in report.rooms.items()))
    if report.categories:
        lines.append("pieces: " + ", ".join(f"{c} {n}" for c, n in report.categories.items()))
    return lines + [f"note: {note}" for note in report.notes]


def _reach_line(reached: dict[str, bool]) -> str:
    cut_off = [name for name, there in reached.items() if not there]
    if not cut_off:
        return "the robot can reach every room"
    return (
        f"the robot cannot reach: {', '.join(cut_off)} (a door that is missing, blocked or under "
        "0.5 m wide, or a floor that is full)"
    )


def _write(scene: Scene, path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save_scene(scene, path)
    except OSError as error:
        raise SceneError(f"{path}: cannot be written ({error.strerror})") from None


def _write_json(file: Path, scene: Path, report: Report, reached: dict[str, bool] | None) -> None:
    data = {"scene": str(scene), **vars(report), "reachable": reached}
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{file}: cannot be written ({error.strerror})") from None


if __name__ == "__main__":
    import_command()
