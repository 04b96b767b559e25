"""Where the runtime places what a camera sees, by boxes that are true, and where it is."""

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from hil_sim.ground_truth.freespace import build_free_space
from hil_sim.ground_truth.labels import LABELLED, CameraView, labels
from hil_sim.scenes.format import Scene
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.furniture.boxes import Box, box_of
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.camera import Frame
from hil_sim.simulation.protocol import HM3D
from hil_sim.simulation.scene_physics import ScenePhysics
from runtime.core.geometry import GridFrame, optical_rays
from runtime.core.mapping.grid import RESOLUTION_M
from runtime.core.objects.semantic_map import locate
from runtime.core.types import F64, Detections, Mask, Mount, Observation, Pose

MISPLACED_M: Final = 0.35  # from the nearest of it that is in view
HERE: Final = Pose(0.0, 0.0, 0.0)
MOUNT: Final = Mount(z_m=HM3D.camera_z_m)
SIDE: Final = 800  # cells of the map round the camera
GRID: Final = GridFrame(
    -SIDE * RESOLUTION_M / 2, -SIDE * RESOLUTION_M / 2, RESOLUTION_M, SIDE, SIDE
)
_NAMES: Final = ("thing",)


@dataclass(frozen=True)
class PlacedThing:
    """One thing in one image: how far it is, and how far from what of it is in view the middle of
    where it is placed is, m, on the plan; None where it is placed nowhere."""

    category: str
    range_m: float
    off_m: float | None

    @property
    def misplaced(self) -> bool:
        return self.off_m is not None and self.off_m > MISPLACED_M


def placed_things(homes: Sequence[str], views: int, seed: int) -> Iterator[list[PlacedThing]]:
    """From so many places of each home, the things in one image each that a detector would be
    taught, as the protocol `hm3d` has cameras."""
    for home in homes:
        scene, assets = open_scene(home), Assets()
        with ScenePhysics(scene, assets) as world:
            space = build_free_space(scene, world.obstacle_triangles())
            boxes = [box_of(thing) for thing in scene.objects]
            rng = random.Random(f"placed/{seed}/{home}")
            for _ in range(views):
                at = space.anywhere(rng)
                frame = world.render(at.x_m, at.y_m, at.yaw_rad, colour=False)
                yield in_frame(frame, labelled(frame, scene, boxes, at))


def labelled(frame: Frame, scene: Scene, boxes: list[Box], at: Pose) -> dict[int, str]:
    """The scene's objects of which enough is in view, by number, and what they are."""
    view = CameraView(at.x_m, at.y_m, HM3D.camera_z_m, at.yaw_rad, 0.0, HM3D.hfov_rad)
    told = labels(scene, boxes, view, frame.depth_m, frame.segmentation)
    seen = np.unique(frame.segmentation[frame.segmentation >= 0]).tolist()
    named = [index for index in seen if scene.objects[index].category in LABELLED]
    pairs = zip(named, told, strict=True)
    return {index: label.category for index, label in pairs if not label.ignore}


def in_frame(frame: Frame, things: Mapping[int, str]) -> list[PlacedThing]:
    """Some things of one image, by number, each by its true box alone."""
    depth_m = HM3D.sensed(frame.depth_m)
    blank = np.zeros((*depth_m.shape, 3), np.uint8)
    obs = Observation(0, blank, depth_m, HERE, HM3D.intrinsics)
    masks = ((name, frame.segmentation == index) for index, name in things.items())
    return [_placed(name, mask, frame, obs) for name, mask in masks]


def _placed(category: str, mask: Mask, frame: Frame, obs: Observation) -> PlacedThing:
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    box = np.array([[x, y, x + width, y + height]], np.float32)
    none = np.zeros((1, 0), np.float32)
    told = Detections(
        box, np.ones(1, np.float32), np.zeros(1, np.int32), none, np.zeros(0, np.float32)
    )
    seen = locate(obs, told, _NAMES, MOUNT, GRID)
    there = _on_plan(mask, frame)
    range_m = float(np.hypot(*there.T).min())
    if not seen:
        return PlacedThing(category, range_m, None)
    away = np.hypot(*(there - np.array(seen[0].thing.xy)).T)
    return PlacedThing(category, range_m, float(away.min()))


def _on_plan(mask: Mask, frame: Frame) -> F64:
    """(N, 2) m, where what is in view of a thing is, before a camera that is level."""
    ahead = frame.depth_m[mask].astype(np.float64)
    right = optical_rays(HM3D.intrinsics, 1)[mask][:, 0] * ahead
    return np.stack([ahead, -right], axis=1)
