"""The truth about where the robot can be: free cells, geodesic distances, success positions.

Only the harness reads this; the runtime never does.
"""

import hashlib
import json
import math
import random
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
import skfmm
from numpy.typing import NDArray

from hil_sim.ground_truth.goals import categories_of as categories_of
from hil_sim.scenes.format import Scene, SceneError
from hil_sim.scenes.scene_file import scene_to_json
from runtime.core.types import Pose

CELL_M = 0.05
BODY_RADIUS_M = 0.18
BODY_Z_M = (0.05, 0.88)
"""Obstacles between these heights stop the body."""
SUCCESS_RANGE_M = 1.0
LEAST_PIXELS = 200
"""Visible pixels in a 640x480 frame that count as seeing the goal."""
COARSE = 3
"""Views are rendered once in a block of 3 x 3 cells, which stands for the block."""
LEAST_REGION_M2 = 1.0
CACHE_VERSION = 2

Points = NDArray[np.float64]


class Looking(Protocol):
    """What seeing needs from a world: visible pixels of the objects, facing along a yaw."""

    def __call__(self, x_m: float, y_m: float, yaw_rad: float) -> NDArray[np.int64]:
        """(len(scene.objects),) pixels in a 640x480 frame."""
        ...


@dataclass(frozen=True)
class FreeSpace:
    """Free cells of a scene, inflated by the body's radius.

    `free` (H, W) bool, row along y, column along x; `origin_m` is the corner of cell (0, 0).
    """

    scene: Scene
    origin_m: tuple[float, float]
    free: NDArray[np.bool_]

    def cell(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """(row, col) of a point, None outside the grid."""
        col = math.floor((x_m - self.origin_m[0]) / CELL_M)
        row = math.floor((y_m - self.origin_m[1]) / CELL_M)
        inside = 0 <= row < self.free.shape[0] and 0 <= col < self.free.shape[1]
        return (row, col) if inside else None

    def points(self, cells: NDArray[np.integer]) -> Points:
        """(N, 2) cells (row, col) -> (N, 2) their middles, scene frame, metres."""
        return (np.asarray(cells)[:, ::-1] + 0.5) * CELL_M + self.origin_m

    def is_free(self, x_m: float, y_m: float) -> bool:
        cell = self.cell(x_m, y_m)
        return cell is not None and bool(self.free[cell])

    def anywhere(self, rng: random.Random) -> Pose:
        """A free place and a heading, drawn, scene frame."""
        cells = np.argwhere(self.free)
        x, y = self.points(cells[rng.randrange(len(cells))][None])[0]
        return Pose(float(x), float(y), rng.uniform(-math.pi, math.pi))

    def nearest_free(self, x_m: float, y_m: float, within_m: float = 0.15) -> Points | None:
        """(2,) middle of the nearest free cell, None if none is `within_m`."""
        cells = self.points(np.argwhere(self.free))
        gaps = np.hypot(*(cells - (x_m, y_m)).T)
        best = int(np.argmin(gaps))
        return cells[best] if gaps[best] <= within_m else None

    def distance_field(self, goals: Points) -> NDArray[np.float64]:
        """(N, 2) goal points, m -> (H, W) geodesic metres to the nearest; inf where cut off."""
        seeds = np.zeros(self.free.shape, bool)
        for x, y in goals:
            cell = self.cell(x, y)
            if cell is not None and self.free[cell]:
                seeds[cell] = True
        field = np.full(self.free.shape, np.inf)
        if not seeds.any():
            return field
        reach = _flood(self.free, seeds)
        phi = np.ma.MaskedArray(np.where(seeds, -1.0, 1.0), ~reach)
        if seeds[reach].all():
            field[seeds] = 0.0
            return field
        found = skfmm.distance(phi, dx=CELL_M)
        # The zero contour runs half a cell outside the seeds' middles.
        ahead = np.maximum(np.ma.filled(found, np.inf) + CELL_M / 2, 0.0)
        field[reach] = np.where(seeds[reach], 0.0, ahead[reach])
        return field

    def distance(self, field: NDArray[np.float64], x_m: float, y_m: float) -> float:
        """Metres from a point by a distance field; a point off the free cells uses the nearest."""
        cell = self.cell(x_m, y_m)
        if cell is None or not self.free[cell]:
            near = self.nearest_free(x_m, y_m)
            if near is None:
                return math.inf
            step = math.hypot(near[0] - x_m, near[1] - y_m)
            cell = self.cell(*near)
            assert cell is not None
            return float(field[cell]) + step
        return float(field[cell])


def build_free_space(scene: Scene, triangles: NDArray[np.floating]) -> FreeSpace:
    """Free cells of a scene whose obstacles are `triangles` (N, 3, 3), m, scene frame.

    Triangles are cut to the body's height; free is what lies in a room, further from every
    obstacle and every hole in the floor than the body's radius and half a cell.
    """
    corners = np.vstack([np.array(room.polygon) for room in scene.rooms])
    low, high = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
    cols, rows = np.ceil((high - low) / CELL_M).astype(int)
    inside, solid = np.zeros((rows, cols), np.uint8), np.zeros((rows, cols), np.uint8)
    for room in scene.rooms:
        cv2.fillPoly(inside, [_fixed(np.array(room.polygon), low)], 1, shift=_SHIFT)
    for hole in scene.holes:
        cv2.fillPoly(solid, [_fixed(np.array(hole.polygon), low)], 1, shift=_SHIFT)
    for shape in _cut(triangles):
        cv2.fillConvexPoly(solid, _fixed(shape, low), 1, shift=_SHIFT)
    away = cv2.distanceTransform(1 - solid, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
    free = _without_pockets((inside > 0) & (away > BODY_RADIUS_M + CELL_M / 2))
    return FreeSpace(scene, (float(low[0]), float(low[1])), free)


_SHIFT = 8
"""Fractional bits of OpenCV's fixed-point coordinates."""


def _fixed(xy: NDArray[np.floating], low: NDArray[np.float64]) -> NDArray[np.int32]:
    # OpenCV puts whole coordinates at the middles of cells.
    cells = (xy - low) / CELL_M - 0.5
    return np.asarray(np.round(cells * (1 << _SHIFT)), np.int32)


def _cut(triangles: NDArray[np.floating]) -> list[NDArray[np.float64]]:
    """The parts of triangles within the body's height, as convex polygons (n, 2) on the plan."""
    bottom, top = BODY_Z_M
    z = triangles[:, :, 2]
    near = (z.max(axis=1) > bottom) & (z.min(axis=1) < top)
    whole = near & (z.min(axis=1) >= bottom) & (z.max(axis=1) <= top)
    shapes = list(np.asarray(triangles[whole][:, :, :2], float))
    for triangle in triangles[near & ~whole]:
        polygon = np.asarray(triangle, float)
        for height, sign in ((bottom, 1.0), (top, -1.0)):
            polygon = _above(polygon, height, sign)
        if len(polygon):
            shapes.append(cv2.convexHull(polygon[:, :2].astype(np.float32))[:, 0].astype(float))
    return shapes


def _above(polygon: NDArray[np.float64], height: float, sign: float) -> NDArray[np.float64]:
    """Sutherland-Hodgman: the part of a polygon (n, 3) with sign * (z - height) >= 0."""
    kept = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        da, db = sign * (a[2] - height), sign * (b[2] - height)
        if da >= 0:
            kept.append(a)
        if (da >= 0) != (db >= 0):
            kept.append(a + (b - a) * da / (da - db))
    return np.array(kept).reshape(-1, 3)


def _without_pockets(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Without regions under 1 m²: the hollow insides of furniture are not places to be."""
    _, names, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] * CELL_M**2 >= LEAST_REGION_M2
    large[0] = False
    kept: NDArray[np.bool_] = large[names]
    return kept


def _flood(free: NDArray[np.bool_], seeds: NDArray[np.bool_]) -> NDArray[np.bool_]:
    _, names = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    reached: NDArray[np.bool_] = np.isin(names, np.unique(names[seeds])) & free
    return reached


def success_cells(
    space: FreeSpace, goal: str, boxes: "list[Points]", look: Looking
) -> NDArray[np.int64]:
    """(N, 2) free cells (row, col) from which an instance of the goal is near and seen.

    `boxes`: footprints (4, 2) of the scene's objects; `look` renders. Near is within 1.0 m of
    the footprint, seen is 200 pixels when facing it.
    """
    good = np.zeros(space.free.shape, bool)
    for index in instances(space.scene, goal):
        near = space.free & (distance_to(space, boxes[index]) <= SUCCESS_RANGE_M)
        middle = boxes[index].mean(axis=0)
        known: dict[tuple[int, int], bool] = {}
        for row, col in np.argwhere(near & ~good):
            # A representative that is itself near stands for its block of cells.
            block = (int(row) // COARSE, int(col) // COARSE)
            if block not in known:
                x, y = space.points(np.array([[row, col]]))[0]
                yaw = math.atan2(middle[1] - y, middle[0] - x)
                known[block] = bool(look(x, y, yaw)[index] >= LEAST_PIXELS)
            good[row, col] = known[block]
    return np.argwhere(good)


def instances(scene: Scene, goal: str) -> list[int]:
    """Indices of the objects that satisfy a goal; SceneError if there are none, and of "other",
    which is never labelled."""
    wanted = {*categories_of(goal)} - {"other"}
    found = [i for i, obj in enumerate(scene.objects) if obj.category in wanted]
    if not found:
        here = ", ".join(sorted({obj.category for obj in scene.objects} - {"other"}))
        what = (
            f"no such object here; there are: {here}"
            if here
            else 'no object here can be a goal; place one, such as a "bed" (docs/own-home.md)'
        )
        raise SceneError(f"{scene.name}: goal {goal!r}: {what}")
    return found


def distance_to(space: FreeSpace, footprint: Points) -> NDArray[np.float64]:
    """(H, W) metres from each cell's middle to a footprint (4, 2)."""
    rows, cols = np.indices(space.free.shape)
    points = np.stack([cols.ravel(), rows.ravel()], axis=1) + 0.5
    points = points * CELL_M + space.origin_m
    best = np.full(len(points), np.inf)
    inside = np.ones(len(points), bool)
    for a, b in zip(footprint, np.roll(footprint, -1, axis=0), strict=True):
        side, from_a = b - a, points - a
        t = np.clip(from_a @ side / (side @ side), 0.0, 1.0)
        best = np.minimum(best, np.hypot(*(from_a - t[:, None] * side).T))
        inside &= side[0] * from_a[:, 1] - side[1] * from_a[:, 0] >= 0
    return np.where(inside, 0.0, best).reshape(space.free.shape)


def scene_hash(scene: Scene) -> str:
    """Names a scene's content, so that what is computed from it can be kept."""
    text = json.dumps([CACHE_VERSION, scene_to_json(scene)], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:20]
