"""`hil-sim show`: a scene for people, as a top-down plan and four camera views."""

import math
from pathlib import Path

import click
import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import Polygon, Scene, contains, polygon_area
from hil_sim.scenes.open import open_scene
from hil_sim.scenes.plan_view import plan_image
from hil_sim.scenes.viewpoints import floor_of
from hil_sim.simulation.camera import HM3D_CAMERA
from hil_sim.simulation.quiet import hushed, keep_stdout_for_python

VIEWS = 4


def vantage_points(scene: Scene, count: int = VIEWS) -> list[tuple[float, float, float]]:
    """Poses (x m, y m, yaw rad) that look across the largest rooms from one of their ends."""
    floor, poses = floor_of(scene), list[tuple[float, float, float]]()
    cells = np.argwhere(floor.standing)
    points = (cells[:, ::-1] + 0.5) * floor.cell_m + floor.origin_m
    rooms = sorted(scene.rooms, key=lambda room: -polygon_area(room.polygon))
    for room in (rooms * count)[:count]:
        here = points[[contains(room.polygon, x, y) for x, y in points]]
        if len(here) == 0:
            continue
        middle = _middle(room.polygon)
        taken = [pose[:2] for pose in poses if contains(room.polygon, *pose[:2])]
        far = np.hypot(*(here - middle).T)
        for pose in taken:
            far += np.hypot(*(here - pose).T)
        x, y = here[int(np.argmax(far))]
        poses.append((float(x), float(y), math.atan2(middle[1] - y, middle[0] - x)))
    return poses


def _middle(polygon: Polygon) -> NDArray[np.float64]:
    middle: NDArray[np.float64] = np.array(polygon).mean(axis=0)
    return middle


@click.command("show")
@click.argument("scene")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder to write.")
def show_command(scene: str, out: Path) -> None:
    """Draw SCENE: a plan and four camera views as PNG. SCENE is a bundled home (maple, cedar), a
    scene file, a generated home (val-17, val-17-rooms7) or a RoboTHOR replica (FloorPlan_Val1_1).

    \b
    Example: hil-sim show maple --out out/maple
    """
    home = open_scene(scene)
    keep_stdout_for_python()
    with hushed():
        from hil_sim.scenes.furniture.assets import Assets
        from hil_sim.simulation.scene_physics import ScenePhysics

    out.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(out / "plan.png"), plan_image(home)[..., ::-1])
    with ScenePhysics(home, Assets(), "auto", None) as world:
        poses = vantage_points(home)
        for index, (x, y, yaw) in enumerate(poses, 1):
            frame = world.render(x, y, yaw, HM3D_CAMERA)
            cv2.imwrite(str(out / f"view{index}.png"), frame.rgb[..., ::-1])
    click.echo(f"{home.name}: plan.png and {len(poses)} views in {out}")
