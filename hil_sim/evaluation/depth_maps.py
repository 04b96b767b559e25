"""What a depth camera's faults and a mount that sways do to the map: looks around in homes, each
mapped as it truly is and as the camera shows it."""

import math
import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from typing import Final

import cv2
import numpy as np

from hil_sim.ground_truth.freespace import build_free_space
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.camera import CameraModel
from hil_sim.simulation.depth_cameras import CAMERAS
from hil_sim.simulation.noise import generator, parse_noise
from hil_sim.simulation.protocol import HM3D
from hil_sim.simulation.scene_physics import ScenePhysics
from hil_sim.simulation.sensors import sense
from runtime.core.mapping.floor_plane import mount_by_floor
from runtime.core.mapping.grid import MapConfig, NavigationMap, integrate
from runtime.core.mapping.solid_depth import solid
from runtime.core.settings import RobotConfig
from runtime.core.types import F32, Mask, Mount, Observation, Pose

TURNS: Final = 12  # of a look around
SWAY_RAD: Final = math.radians(5.0)  # of the tilt, to either side,
SWAY_M: Final = 0.05  # and of the height,
SWAY_TURNS: Final = (5.0, 7.0)  # in so many turns once to and fro
NOMINAL: Final = Mount(z_m=HM3D.camera_z_m)
_BESIDE: Final = np.ones((3, 3), np.uint8)


@dataclass(frozen=True)
class MapCase:
    """How a map is made: with which noise, with flying pixels dropped or not, and how the mount is
    known: "fixed" (as configured), "floor" or "tf" (as it is)."""

    noise: str
    drops: bool
    mount: str = "fixed"


@dataclass(frozen=True)
class MapScore:
    """Cells of the true map: free and occupied ones, and what another map has in their place."""

    floor: int = 0
    kept: int = 0  # of the floor, still free
    false: int = 0  # of it, held for obstacles, with no true one beside
    obstacles: int = 0
    missed: int = 0  # of them, with none held for one beside

    def __add__(self, other: "MapScore") -> "MapScore":
        return MapScore(*(a + b for a, b in zip(astuple(self), astuple(other), strict=True)))

    @property
    def shares(self) -> tuple[float, float, float]:
        """Free share of the floor, false obstacles as a share of it, share of obstacles missed."""
        floor, obstacles = max(1, self.floor), max(1, self.obstacles)
        return self.kept / floor, self.false / floor, self.missed / obstacles


def scored(true: NavigationMap, made: NavigationMap) -> MapScore:
    """A map against the true one, over one frame."""
    beside = _widened(true.occupied)
    return MapScore(
        int(true.free.sum()),
        int((true.free & made.free).sum()),
        int((true.free & made.occupied & ~beside).sum()),
        int(true.occupied.sum()),
        int((true.occupied & ~_widened(made.occupied)).sum()),
    )


def compare(
    homes: Sequence[str], places: int, cases: Sequence[MapCase], sways: bool, seed: int
) -> Iterator[dict[MapCase, MapScore]]:
    """A look around from so many places of each home; yields the scores of each place."""
    for home in homes:
        scene, assets = open_scene(home), Assets()
        with ScenePhysics(scene, assets) as world:
            space = build_free_space(scene, world.obstacle_triangles())
            rng = random.Random(f"depth/{seed}/{home}")
            for number in range(places):
                place = f"{home}/{number}"
                yield _around(world, space.anywhere(rng), cases, sways, seed, place)


def _around(
    world: ScenePhysics, at: Pose, cases: Iterable[MapCase], sways: bool, seed: int, place: str
) -> dict[MapCase, MapScore]:
    start = Pose(0.0, 0.0, 0.0)
    made = {case: _Mapping.at(start) for case in cases}
    true = {case.noise: _Mapping.at(start) for case in made}
    for turn in range(TURNS):
        pose, mount = Pose(0.0, 0.0, turn * math.tau / TURNS), _mount(turn, sways)
        camera = CameraModel(z_m=mount.z_m)
        frame = world.render(at.x_m, at.y_m, at.yaw_rad + pose.yaw_rad, camera, mount.pitch_rad)
        for name, mapping in true.items():
            protocol = replace(HM3D, noise=parse_noise([name]))
            mapping.add(_in_range(frame.depth_m, protocol.noise.camera), pose, mount)
            rng = generator(seed, place, turn, "camera")
            _, depth_m = sense(frame, world.scene, protocol, 0.0, rng)
            for case in (w for w in made if w.noise == name):
                made[case].look(depth_m, pose, case, mount)
    return {case: scored(true[case.noise].map, m.map) for case, m in made.items()}


@dataclass
class _Mapping:
    """A map in the making, and the mount that it went by last."""

    map: NavigationMap
    mount: Mount = NOMINAL

    @classmethod
    def at(cls, start: Pose) -> "_Mapping":
        return cls(NavigationMap.around(start, RobotConfig().radius_m))

    def look(self, depth_m: F32, pose: Pose, case: MapCase, mount: Mount) -> None:
        if case.drops:
            depth_m = solid(depth_m)
        if case.mount == "tf":
            self.mount = mount
        elif case.mount == "floor":
            self.mount = mount_by_floor(depth_m, HM3D.intrinsics, NOMINAL, self.mount)
        self.add(depth_m, pose, self.mount)

    def add(self, depth_m: F32, pose: Pose, mount: Mount) -> None:
        robot, blank = RobotConfig(), np.zeros((*depth_m.shape, 3), np.uint8)
        obs = Observation(0, blank, depth_m, pose, HM3D.intrinsics)
        far_m = MapConfig().max_depth_m
        integrate(self.map, obs, mount, robot.radius_m, robot.height_m, far_m)


def _mount(turn: int, sways: bool) -> Mount:
    """Where the camera truly is."""
    if not sways:
        return NOMINAL
    tilt, height = (math.sin(math.tau * (turn + 0.5) / n) for n in SWAY_TURNS)
    return Mount(z_m=NOMINAL.z_m + SWAY_M * height, pitch_rad=SWAY_RAD * tilt)


def _in_range(depth_m: F32, camera: str) -> F32:
    """True depth, as far as that camera sees."""
    near_m, far_m = 0.0, math.inf
    if camera:
        near_m, far_m = CAMERAS[camera].near_m, CAMERAS[camera].far_m
    inside = (depth_m >= near_m) & (depth_m <= far_m)
    return HM3D.sensed(np.where(inside, depth_m, np.float32(0)))


def _widened(mask: Mask) -> Mask:
    return np.asarray(cv2.dilate(mask.view(np.uint8), _BESIDE), np.uint8).view(bool)
