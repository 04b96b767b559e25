"""Drives through homes, as maps: one that is remembered, and beginnings elsewhere in the same home,
each by an odometry of its own that drifts and a depth camera that is noisy."""

import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hil_sim.benchmarks import drive
from hil_sim.driving.rig import camera_of, open_world
from hil_sim.scenes.furniture.assets import Assets, cache_dir
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.noise import USUAL, generator
from hil_sim.simulation.protocol import HM3D
from hil_sim.simulation.robot import Robot, act
from hil_sim.simulation.sensors import sense
from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import MapCopy
from runtime.core.types import Action, Detections, Observation, Pose

if TYPE_CHECKING:  # PyBullet prints when it is imported: see open_world
    from hil_sim.simulation.scene_physics import ScenePhysics

ROBOT = replace(HM3D, noise=replace(USUAL, motion=1.0))
REMEMBERED_FRAMES = 200
BEGINNING_FRAMES = 72
BEGINNINGS = 4  # in each home
LOOK_EVERY = 6  # frames
_NONE = Detections(
    np.zeros((0, 4), np.float32), np.zeros(0, np.float32), np.zeros(0, np.int32),
    np.zeros((0, 0), np.float32), np.zeros(0, np.float32),
)  # fmt: skip


@dataclass(frozen=True)
class MapLook:
    """A map after so many frames, and where odometry had the robot."""

    frames: int
    map: MapCopy
    pose: Pose


@dataclass(frozen=True)
class DrivenMap:
    """One drive. `start`: where its map's origin truly is, in the home's own frame."""

    start: Pose
    looks: tuple[MapLook, ...]


@dataclass(frozen=True)
class HomeDrives:
    """A home's first drive, of which the last map is remembered, and its beginnings."""

    home: str
    remembered: DrivenMap
    beginnings: tuple[DrivenMap, ...]


def drives(home: str, folder: Path | None = None) -> HomeDrives:
    """From the cache, or driven now, which takes minutes."""
    path = (folder or cache_dir() / "benchmarks" / "relocation") / f"{home}.npz"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part.npz")
        _save(part, _driven(home))
        part.replace(path)
    with np.load(path, allow_pickle=False) as held:
        return _unpacked(home, dict(held))


def _driven(home: str) -> list[DrivenMap]:
    with open_world(open_scene(home), Assets(), "auto") as world:
        from hil_sim.ground_truth.freespace import build_free_space

        space, rng = build_free_space(world.scene, world.obstacle_triangles()), random.Random(home)
        lengths = (REMEMBERED_FRAMES, *(BEGINNING_FRAMES,) * BEGINNINGS)
        told = []
        for number, frames in enumerate(lengths):
            start = space.anywhere(rng)
            looks = _looks(world, start, frames, generator(0, home, number, "relocation"))
            told.append(DrivenMap(start, tuple(looks)))
        return told


def _looks(
    world: "ScenePhysics", start: Pose, frames: int, rng: np.random.Generator
) -> Iterator[MapLook]:
    """Explore, the nearest frontier first; all that is left when nothing is, is to turn."""
    robot, camera, config = Robot(start), camera_of(ROBOT), drive.configuration()
    known = drive.begin(config)
    for n in range(frames):
        at, odometry = robot.pose, robot.odometry(start)
        frame = world.render(at.x_m, at.y_m, at.yaw_rad, camera)
        rgb, depth_m = sense(frame, world.scene, ROBOT, 0.0, rng)
        stamp_ns = round((n + 1) * ROBOT.observe_s * 1e9)
        obs = Observation(stamp_ns, rgb, depth_m, odometry, ROBOT.intrinsics)
        action = drive.step(known, obs, _NONE, config)
        if (n + 1) % LOOK_EVERY == 0:
            yield MapLook(n + 1, known.map.copied(known.map.known_window()), odometry)
        action = Action.TURN_LEFT if action is Action.STOP else action
        robot = act(robot, action, world, ROBOT, rng)


def _save(path: Path, told: list[DrivenMap]) -> None:
    arrays: dict[str, Any] = {}
    for number, known in enumerate(told):
        arrays[f"{number}.start"] = np.array(
            [known.start.x_m, known.start.y_m, known.start.yaw_rad]
        )
        for look in known.looks if number else known.looks[-1:]:
            f, at = look.map.frame, look.pose
            place = f.x0_m + f.first_col * f.resolution_m, f.y0_m + f.first_row * f.resolution_m
            arrays[f"{number}.{look.frames}"] = np.array([*place, at.x_m, at.y_m, at.yaw_rad])
            arrays[f"{number}.{look.frames}.map"] = look.map.occupied + 2 * look.map.free.view("u1")
    np.savez_compressed(path, **arrays)


def _unpacked(home: str, arrays: dict[str, Any]) -> HomeDrives:
    told: dict[int, list[MapLook]] = {}
    for name in sorted((n for n in arrays if n.count(".") == 1 and not n.endswith("t")),
                       key=lambda n: [int(p) for p in n.split(".")]):  # fmt: skip
        number, frames = (int(part) for part in name.split("."))
        x0_m, y0_m, *pose = arrays[name].tolist()
        cells = arrays[f"{name}.map"]
        frame = GridFrame(x0_m, y0_m, 0.05, *cells.shape)
        seen = MapCopy(frame, cells == 1, cells == 2, cells == 0)
        told.setdefault(number, []).append(MapLook(frames, seen, Pose(*pose)))
    known = [DrivenMap(Pose(*arrays[f"{n}.start"].tolist()), tuple(told[n])) for n in sorted(told)]
    return HomeDrives(home, known[0], tuple(known[1:]))
