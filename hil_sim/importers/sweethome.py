"""A home drawn with Sweet Home 3D as a scene, and which of its rooms the robot can reach."""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from hil_sim.scenes.format import Scene, SceneError, contains
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.scene_file import load_scene, save_scene
from hil_sim.scenes.sweethome.importer import Report, import_home
from hil_sim.simulation.quiet import hushed, keep_stdout_for_python

SCENE_FILE = "scene.json"


@dataclass(frozen=True)
class ImportedHome:
    """Where the scene was written, what became of the drawing, and for each room whether the
    robot can reach it (None: not asked)."""

    path: Path
    report: Report
    reached: dict[str, bool] | None


def bring_in(home: Path, folder: Path, level: str | None, check: bool) -> ImportedHome:
    """Write FOLDER/{scene.json, meshes/} of a `.sh3d` drawing. The robot begins where most of the
    home can be reached from, where that was to be found out (`check`). SceneError is one line."""
    keep_stdout_for_python()
    assets = Assets()
    known = frozenset(assets.catalog.models) if assets.present else frozenset[str]()
    with hushed():  # OpenCV comments on damaged textures
        scene, report = import_home(home, folder, level, known)
    path = folder / SCENE_FILE
    _write(scene, path)
    reached: dict[str, bool] | None = None
    if check:
        reached = reachable(load_scene(path), assets)
        spawn = tuple(r.polygon for r in scene.rooms if reached[r.name])
        if spawn and len(spawn) < len(scene.rooms):
            _write(replace(scene, spawn=spawn), path)
    return ImportedHome(path, report, reached)


def reachable(scene: Scene, assets: Assets) -> dict[str, bool]:
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


def _write(scene: Scene, path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save_scene(scene, path)
    except OSError as error:
        raise SceneError(f"{path}: cannot be written ({error.strerror})") from None
