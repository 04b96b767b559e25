"""Camera poses in a furnished home: where a robot could stand, mostly looking at something."""

import math
import random
from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import Scene
from hil_sim.scenes.furniture.boxes import Box, box_of

CELL_M = 0.05
BODY_M = 0.2
LOOK_AT = 0.7
"""Share of the poses that look at some object; the others look anywhere."""
NEAR_M, FAR_M = 0.7, 5.0
FAR_SIZES = 16.0
"""A thing is looked at from no farther than this many times its size: a mug of 10 cm from 1.6 m."""
FOV_SHARE_RAD = math.radians(33)
"""How far off the middle of the view the object looked at may be."""
PLAIN = {"other": 0.0, "picture": 0.3, "mirror": 0.5, "cabinet": 0.7, "trash can": 0.8}
"""Weights of categories worth fewer looks; the others weigh 1."""

Pose = tuple[float, float, float]


@dataclass(frozen=True)
class StandingFloor:
    """Cells of 5 cm from `origin_m`: where the camera may stand, and where walls block a look."""

    origin_m: tuple[float, float]
    standing: NDArray[np.bool_]
    walls: NDArray[np.bool_]
    cell_m: float = CELL_M

    def cell(self, x: float, y: float) -> tuple[int, int] | None:
        row, col = int((y - self.origin_m[1]) / CELL_M), int((x - self.origin_m[0]) / CELL_M)
        inside = 0 <= row < self.walls.shape[0] and 0 <= col < self.walls.shape[1]
        return (row, col) if inside else None


def floor_of(scene: Scene) -> StandingFloor:
    """Rasterise walls and furniture footprints (objects with a known size)."""
    points = np.array([p for wall in scene.walls for p in (wall.start, wall.end)])
    low, high = points.min(axis=0) - 0.3, points.max(axis=0) + 0.3
    cols, rows = np.ceil((high - low) / CELL_M).astype(int)
    walls, rooms, things = (np.zeros((rows, cols), np.uint8) for _ in range(3))

    def px(xy: NDArray[np.float64]) -> NDArray[np.int32]:
        return np.asarray(np.floor((xy - low) / CELL_M), np.int32)

    for room in scene.rooms:
        cv2.fillPoly(rooms, [px(np.array(room.polygon))], 1)
    for wall in scene.walls:
        ends, thick = px(np.array([wall.start, wall.end])), round(wall.thickness_m / CELL_M)
        cv2.line(walls, ends[0].tolist(), ends[1].tolist(), 1, max(2, thick))
    for door in scene.doors:
        ends = px(np.array([door.start, door.end]))
        cv2.line(walls, ends[0].tolist(), ends[1].tolist(), 0, 6)
    for box in (box_of(obj) for obj in scene.objects):
        if box.z0 < 1.0 and box.z1 > 0.04:
            cv2.fillPoly(things, [px(box.corners())], 1)
    reach = round(BODY_M / CELL_M)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    blocked = cv2.dilate(np.maximum(walls, things), disc.astype(np.uint8))
    return StandingFloor((float(low[0]), float(low[1])), (rooms > 0) & (blocked == 0), walls > 0)


def viewpoints(rng: random.Random, scene: Scene, count: int) -> list[Pose]:
    """`count` poses (x m, y m, yaw rad)."""
    floor = floor_of(scene)
    cells = np.argwhere(floor.standing)
    if len(cells) == 0:
        return []
    weights, boxes = _weights(scene), [box_of(obj) for obj in scene.objects]
    poses: list[Pose] = []
    while len(poses) < count:
        pose = None
        if rng.random() < LOOK_AT and sum(weights) > 0:
            pose = _look_at(rng, floor, rng.choices(boxes, weights)[0])
        if pose is None:
            row, col = cells[rng.randrange(len(cells))]
            x, y = floor.origin_m[0] + (col + rng.random()) * CELL_M, floor.origin_m[1]
            pose = (x, y + (row + rng.random()) * CELL_M, rng.uniform(-math.pi, math.pi))
        poses.append(pose)
    return poses


def _weights(scene: Scene) -> list[float]:
    count = Counter(obj.category for obj in scene.objects)
    return [
        PLAIN.get(obj.category, 1.0) / float(count[obj.category]) ** 0.6 for obj in scene.objects
    ]


def _look_at(rng: random.Random, floor: StandingFloor, box: Box) -> Pose | None:
    size = max(box.width, box.depth, box.z1 - box.z0)
    far = min(max(FAR_SIZES * size, 2 * NEAR_M), FAR_M)
    for _ in range(40):
        bearing = rng.uniform(-math.pi, math.pi)
        distance = NEAR_M + (far - NEAR_M) * rng.random()
        x, y = box.x + distance * math.cos(bearing), box.y + distance * math.sin(bearing)
        cell = floor.cell(x, y)
        if cell is None or not floor.standing[cell] or not _in_sight(floor, x, y, box):
            continue
        yaw = math.atan2(box.y - y, box.x - x)
        return x, y, yaw + rng.uniform(-FOV_SHARE_RAD, FOV_SHARE_RAD)
    return None


def _in_sight(floor: StandingFloor, x: float, y: float, box: Box) -> bool:
    """No wall between the point and the box's middle (its last stretch excepted)."""
    steps = max(2, int(math.hypot(box.x - x, box.y - y) / CELL_M))
    last = 0.92 if box.depth > 0.2 else 0.98
    for i in range(int(steps * last)):
        t = i / steps
        cell = floor.cell(x + (box.x - x) * t, y + (box.y - y) * t)
        if cell is None or floor.walls[cell]:
            return i > steps * 0.85
    return True
