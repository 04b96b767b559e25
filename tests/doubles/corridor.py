"""A home of one corridor, without PyBullet, and a runtime child that needs no models."""

import math
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hil_sim.driving.link import Runtime
from hil_sim.driving.stage import StagedHome
from hil_sim.ground_truth.episodes import Episode, Start
from hil_sim.scenes.format import Door, Room, Scene, SceneObject
from hil_sim.simulation.body import Body
from hil_sim.simulation.protocol import HM3D
from runtime.core.types import Pose

FAKE = Path(__file__).with_name("fake_runtime.py")
SMALL = replace(HM3D, width=64, height=48, max_steps=20)
EPISODE = Episode("e1", "corridor", Start(2.0, 3.0, math.pi / 2), "toilet", 1.0)


@dataclass(frozen=True)
class View:
    rgb: np.ndarray
    depth_m: np.ndarray
    segmentation: np.ndarray


ROOM = Room("hall", "hallway", ((1, 0), (3, 0), (3, 9), (1, 9)))
TOILET = SceneObject("t", "toilet", "builtin:box", (2.0, 4.7, 0.0), 0.0, (0.4, 0.4, 0.4))
SCENE = Scene("corridor", (), (Door((1.0, 3.8), (3.0, 3.8)),), (ROOM,), (TOILET,))
TOILET_BOX = np.array([[1.8, 4.5], [2.2, 4.5], [2.2, 4.9], [1.8, 4.9]])


@dataclass
class Corridor:
    """Runs along +y from y = 3; success is at y = 4, a toilet at y = 4.5, a wall at y = 4.6. From
    y = 3.5 on the toilet fills 240 pixels."""

    bodies: list[tuple[Body, ...]] = field(default_factory=list)  # one entry a change
    floor_until_m: float = math.inf  # of y

    def move(self, x: float, y: float, yaw: float, distance: float) -> tuple[float, float, bool]:
        end = y + distance * math.sin(yaw)
        doors = [body for body in (self.bodies or [()])[-1] if body.kind == "door"]
        if any(body.distance_m(x, end) < 0.18 for body in doors):
            return x, y, True
        return x + distance * math.cos(yaw), min(end, 4.6), end > 4.6

    def falls(self, x: float, y: float) -> bool:
        return y > self.floor_until_m

    def look(self, pose: Pose) -> View:
        rgb = np.full((48, 64, 3), (200, 10, 20), np.uint8)
        seen = np.full((48, 64), -1, np.int32)
        if pose.y_m >= 3.5:
            seen[10:22, 20:40] = 0
        return View(rgb, np.full((48, 64), 6.6 - pose.y_m, np.float32), seen)

    def home(self) -> StagedHome:
        return StagedHome(
            self,
            self.look,
            lambda pose: abs(4.0 - pose.y_m),
            SCENE,
            (0,),
            (TOILET_BOX,),
            self.bodies.append,
            lambda pose: np.full(360, 1.5, np.float32),
            things=(("toilet", TOILET_BOX),),
        )


def start(mode: str, log: Path, answer_s: float = 20.0) -> Runtime:
    return Runtime(log, command=[sys.executable, str(FAKE), mode], answer_s=answer_s)
