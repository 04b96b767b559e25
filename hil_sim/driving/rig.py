"""What a driver needs of a scene: the world, seen through a protocol's camera, and its truth."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hil_sim.driving.oracle import ShortestPath
from hil_sim.driving.stage import RenderedView, StagedHome
from hil_sim.ground_truth.episodes import Episode
from hil_sim.scenes.format import Scene
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.simulation.camera import CameraModel, Frame
from hil_sim.simulation.protocol import Protocol
from hil_sim.simulation.quiet import hushed
from runtime.core.types import Action, Pose

if TYPE_CHECKING:  # PyBullet prints when it is imported: see open_world
    from hil_sim.ground_truth.truth import SceneTruth
    from hil_sim.simulation.scene_physics import ScenePhysics


def open_world(scene: Scene, assets: Assets, renderer: str) -> "ScenePhysics":
    """A scene in PyBullet, without the lines that PyBullet and EGL print when they start."""
    with hushed():
        from hil_sim.simulation.scene_physics import ScenePhysics

        return ScenePhysics(scene, assets, renderer)


def camera_of(protocol: Protocol) -> CameraModel:
    """The protocol's camera."""
    return CameraModel(protocol.width, protocol.height, protocol.hfov_rad, protocol.camera_z_m)


def home_of(
    world: "ScenePhysics",
    truth: "SceneTruth",
    protocol: Protocol,
    goal: str,
    look: Callable[[Pose], Frame] | None = None,
) -> StagedHome:
    """A world, seen through the protocol's camera, and the truth about one goal."""
    camera, boxes = camera_of(protocol), truth.boxes(goal)
    return StagedHome(
        ground=world,
        look=look
        or (lambda pose: world.render(pose.x_m, pose.y_m, pose.yaw_rad, camera, protocol.tilt_rad)),
        distance_m=lambda pose: truth.distance_m(goal, pose),
        scene=world.scene,
        wanted=tuple(boxes),
        goal_boxes=tuple(boxes.values()),
        populate=world.populate,
        scan=world.scan,
        cliffs=world.flooring.cliffs,
        things=truth.things(),
    )


def shortest(
    truth: "SceneTruth", home: StagedHome, episode: Episode, protocol: Protocol
) -> tuple[ShortestPath, StagedHome]:
    """A driver that follows the shortest path, and a home that tells it where it is. Only the
    frame that it stops at is rendered, since a rule may look at it."""
    here = [start_of(episode)]

    def aim(pose: Pose) -> float | None:
        middles = [box.mean(axis=0) - (pose.x_m, pose.y_m) for box in home.goal_boxes]
        x, y = min(middles, key=lambda d: float(d @ d))
        return math.atan2(y, x)

    cells = truth.success(episode.goal)
    driver = ShortestPath(truth.space, cells, protocol, lambda: here[0], aim)
    shape = 12, 16
    blank = Frame(  # nobody looks at it
        np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.float32), np.full(shape, -1, np.int32)
    )

    def look(pose: Pose) -> RenderedView:
        here[0] = pose
        return home.look(pose) if driver.next_action(pose) is Action.STOP else blank

    return driver, replace(home, look=look)


def start_of(episode: Episode) -> Pose:
    """Where an episode begins, scene frame."""
    return Pose(episode.start.x_m, episode.start.y_m, episode.start.yaw_rad)
