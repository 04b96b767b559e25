"""A home as a plan alone: what the body runs into, what hides what is behind it, which room a cell
is of, and what stands where."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.ground_truth.freespace import BODY_RADIUS_M, BODY_Z_M, LEAST_PIXELS
from hil_sim.ground_truth.goals import categories_of
from hil_sim.scenes.format import ROOM_TYPES, Scene
from hil_sim.scenes.furniture.boxes import Box, box_of
from hil_sim.simulation.protocol import HM3D
from runtime.core.kernels import marching, walking
from runtime.core.types import F64, I32, Mask

Indices = NDArray[np.intp]
CELL_M = 0.1
EDGE_M = 0.5  # round the plan
HIDES_M = 1.05  # what is as high hides what is behind it; the backs of chairs do not
SLACK_M = 0.1  # how far a thing's own cells may hide it
ASIDE = 0.7  # of the way from a thing's middle to its side
HIDDEN = 2.0  # how many times the pixels that count as seeing it a thing must have, unhidden
FARTHEST_M = 5.0  # at which a camera's depth tells where a thing is
NEAR_M = 1.0  # from which success counts
_SHIFT = 8  # fractional bits of OpenCV's fixed-point coordinates


@dataclass(frozen=True)
class FlatThing:
    """Lengths in cells: `at` (row, col) its middle, `half` from there to its nearer sides, `seen`
    from how far it is large enough in the image."""

    name: str
    at: tuple[float, float]
    half: float
    seen: float
    outline: F64  # (4, 2) row, col


@dataclass(frozen=True)
class FlatHome:
    """(H, W) cells of CELL_M, rows along y. solid: the body runs into it; hiding: nothing is seen
    behind it; free: where the body's middle may be; rooms: index of the type in ROOM_TYPES, -1
    outside. Points are (row, col), a cell's middle half a cell from its corner."""

    name: str
    solid: Mask
    hiding: Mask
    free: Mask
    rooms: NDArray[np.int8]
    things: tuple[FlatThing, ...]
    _ways: dict[str, F64] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def spots(self) -> F64:
        """(T, 4): row, col, half and seen of all things."""
        return np.array([(*t.at, t.half, t.seen) for t in self.things]).reshape(-1, 4)

    @staticmethod
    def middle(cell: tuple[int, int]) -> F64:
        """(2,) the point at a cell's middle."""
        return np.array([cell[0] + 0.5, cell[1] + 0.5])

    def wanted(self, goal: str) -> list[int]:
        """Indices of the things that satisfy a goal."""
        names = {*categories_of(goal)}
        return [i for i, thing in enumerate(self.things) if thing.name in names]

    def rays(
        self, here: F64, heading_rad: float, fov_rad: float, range_m: float, count: int
    ) -> tuple[F64, I32]:
        """What is in view from a point: its outline (count + 1, 2) as (col, row), the point first;
        and the cells (N, 2) that end a ray."""
        azimuths = heading_rad + np.linspace(-fov_rad / 2, fov_rad / 2, count)
        along = np.arange(1, round(2 * range_m / CELL_M) + 1) / 2
        rows = (np.sin(azimuths)[:, None] * along + here[0]).astype(np.int32)
        cols = (np.cos(azimuths)[:, None] * along + here[1]).astype(np.int32)
        height, width = self.hiding.shape
        np.clip(rows, 0, height - 1, out=rows)
        np.clip(cols, 0, width - 1, out=cols)
        blocked = self.hiding.ravel()[rows * width + cols]
        hit, first = blocked.any(axis=1), blocked.argmax(axis=1)
        reach = np.where(hit, along[first], along[-1])
        outline = np.empty((count + 1, 2))
        outline[0] = here[::-1]
        outline[1:, 0] = here[1] + reach * np.cos(azimuths)
        outline[1:, 1] = here[0] + reach * np.sin(azimuths)
        rays, ends = np.flatnonzero(hit), first[hit]
        return outline, np.stack([rows[rays, ends], cols[rays, ends]], axis=1)

    def in_view(self, here: F64, heading_rad: float, things: Indices) -> Mask:
        """(N,) of things by index: in the image, near enough, and not hidden."""
        away = self.spots[things, :2] - here
        aside = np.arctan2(away[:, 0], away[:, 1]) - heading_rad
        aside = np.abs(np.remainder(aside + math.pi, math.tau) - math.pi)
        near = np.hypot(*away.T) <= self.spots[things, 3]
        shown: Mask = near & (aside <= HM3D.hfov_rad / 2)
        if shown.any():
            shown[shown] = self.open_to(here, things[shown])
        return shown

    def open_to(self, here: F64, things: Indices) -> Mask:
        """(N,) whether of these things, by index, the middle or a side is not hidden from there."""
        spots, half = self.spots[things, :2], self.spots[things, 2]
        away = here - spots
        far = np.maximum(np.hypot(*away.T), 1e-6)
        back = spots + away * np.minimum(1.0, (half + SLACK_M / CELL_M) / far)[:, None]
        aside = np.stack([-away[:, 1], away[:, 0]], axis=1) * (ASIDE * half / far)[:, None]
        ends = np.concatenate([back, back + aside, back - aside])[:, ::-1]
        steps = 2 * math.ceil(FARTHEST_M / CELL_M)
        start = float(here[1]), float(here[0])
        shown = walking.in_sight(self.hiding, (0.0, 0.0, 1.0, 0, 0), start, ends, steps)
        return np.asarray(shown.reshape(3, -1).any(axis=0), bool)

    def way_m(self, goal: str) -> F64:
        """(H, W) metres from each free cell to where one of the goal is near and seen; inf where no
        way leads. Worked out once."""
        if goal not in self._ways:
            self._ways[goal] = self._way_m(goal)
        return self._ways[goal]

    def _way_m(self, goal: str) -> F64:
        arrival = np.full(self.free.shape, np.inf)
        for index in self.wanted(goal):
            bare = np.ones(self.free.shape, np.uint8)
            cv2.fillPoly(bare, [_fixed(self.things[index].outline)], 0, shift=_SHIFT)
            gap_m = cv2.distanceTransform(bare, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
            for row, col in np.argwhere(self.free & (gap_m <= NEAR_M)).tolist():
                if self.open_to(self.middle((row, col)), np.array([index]))[0]:
                    arrival[row, col] = 0.0
        if np.isfinite(arrival).any():
            marching.march(arrival, self.free, CELL_M)
        return arrival


def flat_home(scene: Scene) -> FlatHome:
    """The plan of a home whose things all have a size."""
    corners = np.vstack([np.array(room.polygon) for room in scene.rooms])
    low, high = corners.min(axis=0) - EDGE_M, corners.max(axis=0) + EDGE_M
    cols, rows = (int(n) for n in np.ceil((high - low) / CELL_M))

    def drawn(points: object) -> NDArray[np.int32]:
        return _fixed(((np.asarray(points) - low) / CELL_M)[:, ::-1])

    solid, inside = np.zeros((2, rows, cols), np.uint8)
    rooms = np.full((rows, cols), -1, np.int16)
    for room in scene.rooms:
        cv2.fillPoly(inside, [drawn(room.polygon)], 1, shift=_SHIFT)
        kind = ROOM_TYPES.index(room.type) if room.type in ROOM_TYPES else -1
        cv2.fillPoly(rooms, [drawn(room.polygon)], kind, shift=_SHIFT)
    for wall in scene.walls:
        bar = _bar(wall.start, wall.end, wall.thickness_m, 0.5)
        cv2.fillPoly(solid, [drawn(bar)], 1, shift=_SHIFT)
    for door in scene.doors:
        cv2.fillPoly(solid, [drawn(_bar(door.start, door.end, 0.4, -0.125))], 0, shift=_SHIFT)
    hiding, boxes = solid.copy(), [box_of(each) for each in scene.objects]
    for box in boxes:
        if box.z0 < BODY_Z_M[1] and box.z1 > BODY_Z_M[0]:
            cv2.fillPoly(solid, [drawn(box.corners())], 1, shift=_SHIFT)
        if box.z0 < HM3D.camera_z_m and box.z1 > HIDES_M:
            cv2.fillPoly(hiding, [drawn(box.corners())], 1, shift=_SHIFT)
    away_m = cv2.distanceTransform(1 - solid, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
    free = (inside > 0) & (away_m > BODY_RADIUS_M)
    things = tuple(
        _thing(thing.category, box, ((box.corners() - low) / CELL_M)[:, ::-1])
        for thing, box in zip(scene.objects, boxes, strict=True)
    )
    return FlatHome(scene.name, solid > 0, hiding > 0, free, rooms.astype(np.int8), things)


def _thing(name: str, box: Box, outline: F64) -> FlatThing:
    row, col = outline.mean(axis=0).tolist()
    across, up = max(box.width, box.depth), box.z1 - box.z0
    pixels_m2 = across * up * HM3D.intrinsics.fx * HM3D.intrinsics.fy
    seen_m = min(FARTHEST_M, math.sqrt(pixels_m2 / (HIDDEN * LEAST_PIXELS)))
    half = min(box.width, box.depth) / 2 / CELL_M
    return FlatThing(name, (row, col), half, seen_m / CELL_M, outline)


def _bar(start: tuple[float, float], end: tuple[float, float], wide_m: float, over: float) -> F64:
    """(4, 2) m: a line as wide as that, and longer at both ends by a share of the width."""
    a, b = np.array(start), np.array(end)
    along = (b - a) / max(float(np.hypot(*(b - a))), 1e-9)
    aside = np.array([-along[1], along[0]]) * wide_m / 2
    a, b = a - along * wide_m * over, b + along * wide_m * over
    return np.array([a - aside, b - aside, b + aside, a + aside])


def _fixed(points: F64) -> NDArray[np.int32]:
    """(N, 2) row, col -> as OpenCV wants them: whole coordinates are at the middles of cells."""
    return np.asarray(np.round((points[:, ::-1] - 0.5) * (1 << _SHIFT)), np.int32)
