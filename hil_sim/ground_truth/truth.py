"""What only the harness knows of a home: free space, and how far success is from anywhere.

Kept per scene, in the package for the bundled homes (`python -m hil_sim.ground_truth.truth maple
cedar` makes it) and in the cache for others, where a goal's success positions take up to a minute
the first time.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hil_sim.ground_truth.episodes import Sees
from hil_sim.ground_truth.freespace import (
    LEAST_PIXELS,
    FreeSpace,
    Points,
    build_free_space,
    categories_of,
    instances,
    scene_hash,
    success_cells,
)
from hil_sim.scenes.format import Scene, SceneError, SceneObject
from hil_sim.scenes.furniture.assets import Assets, cache_dir
from hil_sim.scenes.furniture.boxes import Box
from hil_sim.simulation.camera import HM3D_CAMERA, CameraModel
from hil_sim.simulation.scene_physics import ScenePhysics
from runtime.core.types import Pose

Report = Callable[[str], None]
BUNDLED = Path(__file__).parent / "bundled"

SMALL = CameraModel(
    HM3D_CAMERA.width // 2, HM3D_CAMERA.height // 2, HM3D_CAMERA.hfov_rad, HM3D_CAMERA.z_m
)
"""Pixels are counted at half the size, each for four."""


class SceneTruth:
    """The truth about one scene; `report` hears of slow work before it begins."""

    def __init__(
        self, world: ScenePhysics, assets: Assets, report: Report = lambda text: None
    ) -> None:
        self._world, self._assets, self._report = world, assets, report
        key = scene_hash(world.scene)
        self._bundled, self._cache = BUNDLED / key, cache_dir() / "scenes" / key
        self._fields: dict[str, NDArray[np.float64]] = {}
        self.space = self._free_space()

    def distance_m(self, goal: str, pose: Pose) -> float:
        """Geodesic metres from a pose to the goal's nearest success position; inf if cut off."""
        return self.space.distance(self.field(goal), pose.x_m, pose.y_m)

    def success(self, goal: str) -> NDArray[np.int64]:
        """(N, 2) success cells (row, col) of a goal; SceneError when there are none."""
        scene = self._world.scene
        instances(scene, goal)  # SceneError names what there is
        file = self._file(f"success-{'+'.join(categories_of(goal))}.npy")
        cells: NDArray[np.int64]
        if file.is_file():
            cells = np.load(file)
        else:
            self._report(f"{scene.name}: looking for the places that see a {goal} (once)")
            cells = self.find_success(goal)
            _keep(file, lambda path: np.save(path, cells))
        if len(cells) == 0:
            raise SceneError(f"{scene.name}: goal {goal!r}: no free place sees one from 1 m")
        return cells

    def find_success(self, goal: str) -> NDArray[np.int64]:
        """(N, 2) success cells of a goal, by rendering; nothing is read from or kept in a file."""
        return success_cells(self.space, goal, self._footprints(), self._look)

    def boxes(self, goal: str) -> dict[int, Points]:
        """The goal's instances by their index in the scene: footprints (4, 2), m."""
        scene = self._world.scene
        return {i: self._box(scene, scene.objects[i]).corners() for i in instances(scene, goal)}

    def things(self) -> tuple[tuple[str, Points], ...]:
        """All objects of the scene: category and footprint (4, 2), m."""
        names = (obj.category for obj in self._world.scene.objects)
        return tuple(zip(names, self._footprints(), strict=True))

    def sees(self, goal: str) -> Sees:
        """Whether a pose has the goal in view, for choosing where episodes start."""
        wanted = instances(self._world.scene, goal)
        return lambda x, y, yaw: bool(self._look(x, y, yaw)[wanted].max() >= LEAST_PIXELS)

    def field(self, goal: str) -> NDArray[np.float64]:
        """(H, W) geodesic metres to success."""
        if goal not in self._fields:
            goals = self.space.points(self.success(goal))
            self._fields[goal] = self.space.distance_field(goals)
        return self._fields[goal]

    def _free_space(self) -> FreeSpace:
        scene, file = self._world.scene, self._file("free.npz")
        if file.is_file():
            with np.load(file) as kept:
                x, y = (float(v) for v in kept["origin_m"])
                return FreeSpace(scene, (x, y), kept["free"])
        self._report(f"{scene.name}: measuring the free space (once)")
        space = build_free_space(scene, self._world.obstacle_triangles())
        _keep(file, lambda path: np.savez(path, free=space.free, origin_m=space.origin_m))
        return space

    def _file(self, name: str) -> Path:
        """Where a file is, or belongs."""
        bundled = self._bundled / name
        return bundled if bundled.is_file() else self._cache / name

    def bundle(self, goals: Sequence[str]) -> Path:
        """Write the truth about these goals into the package."""
        for goal in goals:
            self.success(goal)
        self._bundled.mkdir(parents=True, exist_ok=True)
        for file in sorted(self._cache.iterdir()):
            (self._bundled / file.name).write_bytes(file.read_bytes())
        return self._bundled

    def _look(self, x_m: float, y_m: float, yaw_rad: float) -> NDArray[np.int64]:
        seen = self._world.render(x_m, y_m, yaw_rad, SMALL, colour=False).segmentation
        counts = np.bincount(seen[seen >= 0], minlength=len(self._world.scene.objects))
        return counts.astype(np.int64) * 4

    def _footprints(self) -> list[Points]:
        scene = self._world.scene
        return [self._box(scene, obj).corners() for obj in scene.objects]

    def _box(self, scene: Scene, obj: SceneObject) -> Box:
        base = scene.source.parent if scene.source else None
        w, d, h = obj.size_m or self._assets.mesh(obj.mesh, base).size_m
        x, y, z = obj.position_m
        return Box(x, y, w, d, obj.yaw_rad, z, z + h)


def _keep(file: Path, save: Callable[[Any], None]) -> None:
    """Write a cache file whole or not at all."""
    file.parent.mkdir(parents=True, exist_ok=True)
    draft = file.with_name(f".{os.getpid()}-{file.name}")
    save(draft)
    draft.replace(file)


if __name__ == "__main__":
    from hil_sim.ground_truth.episodes import HM3D_GOALS
    from hil_sim.scenes.scene_file import load_scene

    for name in sys.argv[1:]:  # one process a scene
        if len(sys.argv) > 2:
            subprocess.run([sys.executable, "-m", "hil_sim.ground_truth.truth", name], check=True)
            continue
        with ScenePhysics(load_scene(name), Assets()) as world:
            print(SceneTruth(world, Assets(), print).bundle(HM3D_GOALS))
