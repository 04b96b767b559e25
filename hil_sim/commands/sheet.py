"""`hil-sim sheet`: every goal of the replicas from 1 m, as pages of pictures to look at."""

import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import click
import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from hil_sim.ground_truth.episodes import ROBOTHOR_GOALS
from hil_sim.ground_truth.goals import categories_of
from hil_sim.scenes.format import SceneError
from hil_sim.scenes.open import open_scene
from hil_sim.scenes.robothor.metadata import APARTMENTS
from hil_sim.scenes.viewpoints import floor_of
from hil_sim.simulation.quiet import hushed, keep_stdout_for_python

if TYPE_CHECKING:  # PyBullet prints when it is imported
    from hil_sim.ground_truth.closeups import CloseUp

TILE_PX = (200, 160)
CAPTION_PX = 16
COLUMNS, ROWS = 8, 5

Tile = tuple[str, "CloseUp | None"]
"""The object's id, and what is seen of it."""


@click.command("sheet")
@click.argument("scenes", nargs=-1)
@click.option("--goal", "goals", multiple=True, default=ROBOTHOR_GOALS, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder to write.")
@click.option("--workers", default=2, show_default=True, type=click.IntRange(1, 64))
def sheet_command(scenes: tuple[str, ...], goals: tuple[str, ...], out: Path, workers: int) -> None:
    """Draw every goal of SCENES (RoboTHOR's 75 replicas, if none are named) from 1 m, enlarged:
    pages a goal, each picture with its scene, its object and how far away it is seen from.

    \b
    Example: hil-sim sheet --goal vase --out out/sheet
    """
    names = scenes or APARTMENTS
    for name in names:  # what is wrong is told before the first is drawn
        for obj in open_scene(name).objects:
            if obj.size_m is None:
                raise SceneError(f"{name}: {obj.id}: size_m: missing, a sheet needs all sizes")
    categories = {goal: categories_of(goal) for goal in goals}
    wanted = tuple({c for some in categories.values() for c in some})
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawn, max_tasks_per_child=1) as pool:
        jobs = {name: pool.submit(_tiles, name, wanted) for name in names}
        drawn = {name: job.result() for name, job in tqdm(jobs.items(), unit="home", disable=None)}
    out.mkdir(parents=True, exist_ok=True)
    pages = 0
    for goal, some in categories.items():
        rows = [
            (f"{name.removeprefix('FloorPlan_')} {id}", seen)
            for name in names
            for category, id, seen in drawn[name]
            if category in some
        ]
        pages += _write(goal, rows, out)
        for label in [label for label, seen in rows if seen is None]:
            click.echo(f"{label}: seen from nowhere within 2 m")
    click.echo(f"{pages} pages in {out}")


def _tiles(name: str, categories: Sequence[str]) -> list[tuple[str, str, "CloseUp | None"]]:
    """Category, id and close-up of each of a home's goals. EGL draws one home a process."""
    keep_stdout_for_python()
    with hushed():
        from hil_sim.ground_truth.closeups import close_up
        from hil_sim.scenes.furniture.assets import Assets
        from hil_sim.simulation.scene_physics import ScenePhysics

    scene = open_scene(name)
    floor = floor_of(scene)
    with ScenePhysics(scene, Assets(), "auto", None) as world:
        return [
            (obj.category, obj.id, close_up(world, floor, index, TILE_PX))
            for index, obj in enumerate(scene.objects)
            if obj.category in categories
        ]


def _write(goal: str, rows: Sequence[Tile], out: Path) -> int:
    """A goal's pages; returns how many."""
    each = COLUMNS * ROWS
    for start in range(0, len(rows), each):
        tiles = [_tile(label, seen) for label, seen in rows[start : start + each]]
        tiles += [np.zeros_like(tiles[0])] * (-len(tiles) % COLUMNS)
        lines = [np.hstack(tiles[i : i + COLUMNS]) for i in range(0, len(tiles), COLUMNS)]
        page = out / f"{goal.replace(' ', '-')}-{start // each + 1}.png"
        cv2.imwrite(str(page), np.vstack(lines))
    return -(-len(rows) // each)


def _tile(label: str, seen: "CloseUp | None") -> NDArray[np.uint8]:
    """BGR, with a caption above."""
    width, height = TILE_PX
    tile = np.full((height + CAPTION_PX, width, 3), 30, np.uint8)
    text = f"{label}  {seen.away_m:.1f} m" if seen else f"{label}  unseen"
    cv2.putText(
        tile, text, (3, 12), cv2.FONT_HERSHEY_SIMPLEX, 0.38, (255, 255, 255), 1, cv2.LINE_AA
    )
    if seen is not None:
        tile[CAPTION_PX:] = seen.rgb[..., ::-1]
    return tile
