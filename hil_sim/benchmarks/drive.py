"""A drive through one home, recorded once and then perceived again as often as is asked for."""

import json
import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.driving.rig import camera_of, open_world
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.ground_truth.true_labels import true_labels
from hil_sim.scenes.format import ROOM_TYPES
from hil_sim.scenes.furniture.assets import Assets, cache_dir
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.protocol import HM3D
from hil_sim.simulation.robot import Robot, act
from runtime import navigate
from runtime.config import Config, load
from runtime.core.types import Action, Ballot, Decision, Detections, Observation, Pose
from runtime.core.world import World
from runtime.robot.labels import read_labels

if TYPE_CHECKING:  # PyBullet prints when it is imported: see open_world
    from hil_sim.simulation.scene_physics import ScenePhysics

HOME = "val-3-rooms8"
FRAMES = 300
GOAL = "nothing"  # so that every frontier is gone to
BOXES = 20  # an image has so many: the truth's, and wrong ones
SHIFT_PX = 12.0  # of a wrong box's edges
WIDTH = 384  # of an embedding
BLUR = 0.7  # what a view adds to a thing's embedding: two views have a cosine of about 0.67
WRONG_SCORE = (0.05, 0.4)
START = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RecordedDrive:
    """What the robot saw: depth (N, 480, 640) uint16 mm, colour as JPEGs, poses (N, 3) in the map
    frame, and the truth's labels as `read_labels` takes them."""

    depth_mm: NDArray[np.uint16]
    colour: tuple[bytes, ...]
    poses: NDArray[np.float64]
    labels: tuple[dict[str, Any], ...]

    def frames(self) -> Iterator[tuple[Observation, Detections]]:
        """One observation after the other, and what a detector with embeddings might say."""
        for n, pose in enumerate(self.poses.tolist()):
            bgr = cv2.imdecode(np.frombuffer(self.colour[n], np.uint8), cv2.IMREAD_COLOR)
            rgb = np.ascontiguousarray(np.asarray(bgr, np.uint8)[..., ::-1])
            depth_m = self.depth_mm[n].astype(np.float32) / np.float32(1000)
            obs = Observation(_stamp_ns(n), rgb, depth_m, Pose(*pose), HM3D.intrinsics)
            yield obs, detected(self.labels[n], n)


def configuration() -> Config:
    """A robot as `hil-sim eval` has it, without experts."""
    return load(None, ("panel.experts=[]", *HM3D.settings))


def begin(config: Config) -> World:
    """A world before the first observation."""
    return World.begin(GOAL, LABELLED, ROOM_TYPES, START, config.navigate.robot.radius_m)


def step(world: World, obs: Observation, seen: Detections, config: Config) -> Action:
    """One step of the loop in lockstep, the nearest frontier elected."""
    navigate.perceive(world, obs, seen, config.camera, config.navigate)
    decide(world, config)
    command = navigate.act(world, config.navigate)
    return navigate.steer(world, command, config.navigate).action


def decide(world: World, config: Config) -> str:
    """Adopt the nearest frontier when a decision is due, or keep the one that is driven to;
    returns why it was due."""
    why = navigate.due(world, config.navigate)
    if why:
        near = sorted((f.distance_m, f.id) for f in world.frontiers if math.isfinite(f.distance_m))
        ids = [id for _, id in near]
        before, closest = world.standing.decision, ids[0] if ids else None
        chosen = before.frontier if before and before.frontier in ids else closest
        made = Decision(chosen, "nearest", (), closest, Ballot(), world.stamp_ns, why)
        navigate.adopt(world, made)
    return why


def detected(labels: dict[str, Any], seed: int) -> Detections:
    """The truth's boxes, and the same again up to BOXES: not quite there, of other names, of low
    scores, as detectors see one thing several times. None where nothing is in view."""
    rng, true = np.random.default_rng(seed), read_labels(labels, LABELLED, ROOM_TYPES)
    count = len(true.scores)
    again = np.arange(count, BOXES) % count if count else np.zeros(0, np.int64)
    shift = rng.uniform(-SHIFT_PX, SHIFT_PX, (len(again), 4))
    wrong = np.clip(true.boxes_px[again] + shift, 0, (639, 479, 639, 479))
    wrong = np.concatenate([wrong[:, :2], np.maximum(wrong[:, 2:], wrong[:, :2] + 4)], axis=1)
    other = (true.labels[again] * 7 + 1 + np.arange(count, BOXES)[: len(again)]) % len(LABELLED)
    thing = np.concatenate([true.labels, true.labels[again]])
    looks = unit(np.random.default_rng(0).normal(size=(len(LABELLED), WIDTH)))[thing]
    looks = unit(looks + BLUR * unit(rng.normal(size=looks.shape)))
    scores = np.concatenate([0.8 * true.scores, rng.uniform(*WRONG_SCORE, len(again))])
    return replace(
        true,
        boxes_px=np.concatenate([true.boxes_px, wrong]).astype(np.float32)[:BOXES],
        scores=scores.astype(np.float32)[:BOXES],
        labels=np.concatenate([true.labels, other]).astype(np.int32)[:BOXES],
        embeddings=looks.astype(np.float32)[:BOXES],
        scene=unit(rng.normal(size=(1, WIDTH)))[0].astype(np.float32),
        depths_m=np.zeros(0, np.float32),
    )


def unit(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, D) -> the same of length 1."""
    scaled: NDArray[np.float64] = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return scaled


def recorded(folder: Path | None = None) -> RecordedDrive:
    """The drive, from the cache or driven now, which needs the furniture and takes a minute."""
    path = (folder or cache_dir() / "benchmarks") / f"{HOME}-{FRAMES}.npz"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        _save(_driven(), path)
    with np.load(path, allow_pickle=False) as held:
        jpegs, ends = held["colour"].tobytes(), np.cumsum(held["sizes"]).tolist()
        colour = tuple(jpegs[a:b] for a, b in zip([0, *ends[:-1]], ends, strict=True))
        labels = tuple(json.loads(str(held["labels"])))
        return RecordedDrive(held["depth_mm"], colour, held["poses"], labels)


def _save(drive: RecordedDrive, path: Path) -> None:
    part = path.with_suffix(".part.npz")  # an interrupted drive leaves no half a file
    np.savez_compressed(
        part,
        depth_mm=drive.depth_mm,
        colour=np.frombuffer(b"".join(drive.colour), np.uint8),
        sizes=np.array([len(jpeg) for jpeg in drive.colour]),
        poses=drive.poses,
        labels=json.dumps(drive.labels),
    )
    part.replace(path)


def _driven() -> RecordedDrive:
    """Explore the home; where nothing is left to explore, begin anew from where the robot is."""
    with open_world(open_scene(HOME), Assets(), "auto") as world:
        start = _start(world)
        robot, camera, config = Robot(start), camera_of(HM3D), configuration()
        known, views = begin(config), []
        for n in range(FRAMES):
            at, odometry = robot.pose, robot.odometry(start)
            frame = world.render(at.x_m, at.y_m, at.yaw_rad, camera)
            labels = true_labels(world.scene, at, frame.segmentation, frame.depth_m)
            mm = np.round(HM3D.sensed(frame.depth_m) * 1000).astype(np.uint16)
            depth_m = mm.astype(np.float32) / np.float32(1000)
            obs = Observation(_stamp_ns(n), frame.rgb, depth_m, odometry, HM3D.intrinsics)
            views.append((mm, as_jpeg(frame.rgb), (odometry.x_m, odometry.y_m, odometry.yaw_rad),
                          labels))  # fmt: skip
            action = step(known, obs, detected(labels, n), config)
            if action is Action.STOP:
                known, action = begin(config), Action.TURN_LEFT
            robot = act(robot, action, world, HM3D)
    depth, colour, poses, told = zip(*views, strict=True)
    return RecordedDrive(np.stack(depth), colour, np.array(poses), told)


def as_jpeg(rgb: NDArray[np.uint8]) -> bytes:
    """(H, W, 3) as it is kept."""
    _, jpeg = cv2.imencode(".jpg", rgb[..., ::-1])
    return jpeg.tobytes()


def _start(world: "ScenePhysics") -> Pose:
    """A free place, drawn by the home's name."""
    from hil_sim.ground_truth.freespace import build_free_space

    space = build_free_space(world.scene, world.obstacle_triangles())
    cells = np.argwhere(space.free)
    cell = cells[random.Random(HOME).randrange(len(cells))]
    x, y = space.points(cell[None])[0]
    return Pose(float(x), float(y), 0.0)


def _stamp_ns(n: int) -> int:
    return round((n + 1) * HM3D.observe_s * 1e9)
