"""Where the robot's centre fits, and whether that floor hangs together. Cells of 5 cm."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import Door, Point, Polygon, Wall, on_wall
from hil_sim.scenes.furniture.boxes import ROBOT_M, Box
from hil_sim.scenes.generated.floorplan import Rect

CELL_M = 0.05
DOOR_ZONE_M = 0.75
"""How deep the space on either side of a door is that stays empty."""
REACH_M = 0.65
"""From floor that the robot can be on to the rectangle around a thing (a diagonal is longer)."""
POCKET_M2 = 0.3
"""Floor that a piece of furniture may cut off."""

Grid = NDArray[np.uint8]


def empty_floor(
    polygons: Iterable[Polygon], walls: Iterable[Wall], doors: Sequence[Door], high: Point
) -> Grid:
    """(H, W) 1 where the robot's centre fits between the walls; row along y, from the origin to
    `high`, m. The home's outer edge is no room for it."""
    shape = (math.ceil(high[1] / CELL_M), math.ceil(high[0] / CELL_M))
    open_ = np.zeros(shape, np.uint8)
    for polygon in polygons:
        fill(open_, np.array(polygon), 1)
    for wall in walls:
        for piece in pieces_of(wall, doors):
            fill(open_, piece.corners(), 0)
    open_[[0, -1]] = 0
    open_[:, [0, -1]] = 0
    far = cv2.distanceTransform(open_, cv2.DIST_L2, 5) * CELL_M
    return (far > ROBOT_M).astype(np.uint8)


def fill(grid: Grid, corners: NDArray[np.float64], value: int) -> None:
    """Write `value` into the cells of a convex or simple polygon (N, 2) m."""
    cells = corners / CELL_M - 0.5
    cv2.fillPoly(grid, [np.round(cells).astype(np.int32)], value)


def pieces_of(wall: Wall, doors: Iterable[Door]) -> list[Box]:
    """The wall as boxes, without its doors."""
    (ax, ay), (bx, by) = wall.start, wall.end
    length, yaw = math.dist(wall.start, wall.end), math.atan2(by - ay, bx - ax)
    ux, uy = (bx - ax) / length, (by - ay) / length
    spans = [(-wall.thickness_m / 2, length + wall.thickness_m / 2)]
    for door in doors:
        if on_wall(door, wall):
            cut = sorted((x - ax) * ux + (y - ay) * uy for x, y in (door.start, door.end))
            spans = [
                (low, high)
                for start, end in spans
                for low, high in ((start, min(end, cut[0])), (max(start, cut[1]), end))
                if high > low
            ]
    return [
        Box(ax + ux * (s + e) / 2, ay + uy * (s + e) / 2, e - s, wall.thickness_m, yaw, 0.0, 9.0)
        for s, e in spans
    ]


def passage_zone(a: Point, b: Point, deep_m: float = DOOR_ZONE_M) -> Box:
    """The strip `deep_m` to either side of the line from a to b."""
    (x0, y0), (x1, y1) = a, b
    yaw = math.atan2(y1 - y0, x1 - x0)
    return Box((x0 + x1) / 2, (y0 + y1) / 2, math.dist(a, b), 2 * deep_m, yaw, 0.0, 2.1)


def door_zone(door: Door, deep_m: float = DOOR_ZONE_M) -> Box:
    """The door's passage, `deep_m` to either side of the wall."""
    return passage_zone(door.start, door.end, deep_m)


@dataclass(frozen=True)
class Left:
    """Floor where the robot fits, the largest connected part of it, and how many cells are not in
    that part."""

    free: Grid
    main: NDArray[np.bool_]
    lost: int


class Floor:
    """The floor that is left, while furniture is put on it."""

    def __init__(self, free: Grid, doors: Sequence[Door]) -> None:
        self._left = _largest(free)
        self._doors = [
            (int((d.start[1] + d.end[1]) / 2 / CELL_M), int((d.start[0] + d.end[0]) / 2 / CELL_M))
            for d in doors
        ]

    def without(self, box: Box, room: Rect) -> Left | None:
        """The floor without the box and the robot's radius around it; None if that would cut off
        a door, the box itself, or more than a pocket. The box stands in that room."""
        trial = self._left.free.copy()
        fill(trial, box.corners(ROBOT_M), 0)
        left = self._still_whole(trial, room) or _largest(trial)
        if (left.lost - self._left.lost) * CELL_M**2 > POCKET_M2 or not _beside(left.main, box):
            return None
        return left if all(left.main[cell] for cell in self._doors) else None

    def take(self, left: Left) -> None:
        """Accept what `without` returned."""
        self._left = left

    def reaches(self, box: Box) -> bool:
        """Whether the robot can come near the box."""
        return _beside(self._left.main, box)

    def _still_whole(self, trial: Grid, room: Rect) -> Left | None:
        """A quick yes: whatever led through the room still does if the room's part is whole."""
        main = self._left.main & (trial > 0)
        window = _cells(room, 0.0)
        inside = main[window].astype(np.uint8)
        gone = np.count_nonzero(self._left.main) - np.count_nonzero(main)
        gone -= np.count_nonzero(self._left.main[window]) - np.count_nonzero(inside)
        if gone or cv2.connectedComponents(inside, connectivity=4)[0] != 2:
            return None
        return Left(trial, main, self._left.lost)


def _largest(free: Grid) -> Left:
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    if len(stats) < 2:
        return Left(free, np.zeros(free.shape, bool), 0)
    main = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    lost = int(stats[1:, cv2.CC_STAT_AREA].sum() - stats[main, cv2.CC_STAT_AREA])
    return Left(free, labels == main, lost)


def _beside(main: NDArray[np.bool_], box: Box) -> bool:
    """Whether some of that floor is within reach of the box."""
    return bool(main[_cells(Rect(*box.span), REACH_M)].any())


def _cells(rect: Rect, grow_m: float) -> tuple[slice, slice]:
    """Rows and columns of the cells in a rectangle grown on all sides."""
    x0, x1 = (rect.x0 - grow_m) / CELL_M, (rect.x1 + grow_m) / CELL_M
    y0, y1 = (rect.y0 - grow_m) / CELL_M, (rect.y1 + grow_m) / CELL_M
    return slice(max(0, int(y0)), int(y1) + 1), slice(max(0, int(x0)), int(x1) + 1)
