"""Where the robot's centre fits, and whether that floor hangs together. Cells of 5 cm."""

import math
from collections.abc import Iterable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.furnish import ROBOT_M, Box
from hil_sim.scene import Door, Point, Polygon, Wall, on_wall

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


class Floor:
    """The floor that is left, while furniture is put on it."""

    def __init__(self, free: Grid, doors: Sequence[Door]) -> None:
        self._free, self._cut_off = free, 0
        self._main = _largest(free)[0]
        self._doors = [
            (int((d.start[1] + d.end[1]) / 2 / CELL_M), int((d.start[0] + d.end[0]) / 2 / CELL_M))
            for d in doors
        ]

    def without(self, box: Box) -> Grid | None:
        """The floor without the box and the robot's radius around it; None if that would cut off
        a door, the box itself, or more than a pocket."""
        trial = self._free.copy()
        fill(trial, box.corners(ROBOT_M), 0)
        main, lost = _largest(trial)
        if (lost - self._cut_off) * CELL_M**2 > POCKET_M2 or not _beside(main, box):
            return None
        return trial if all(main[cell] for cell in self._doors) else None

    def take(self, free: Grid) -> None:
        """Accept what `without` returned."""
        self._free = free
        self._main, self._cut_off = _largest(free)

    def reaches(self, box: Box) -> bool:
        """Whether the robot can come near the box."""
        return _beside(self._main, box)


def _largest(free: Grid) -> tuple[NDArray[np.bool_], int]:
    """The largest connected part, and how many cells the others have."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    if len(stats) < 2:
        return np.zeros(free.shape, bool), 0
    main = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    lost = int(stats[1:, cv2.CC_STAT_AREA].sum() - stats[main, cv2.CC_STAT_AREA])
    return labels == main, lost


def _beside(main: NDArray[np.bool_], box: Box) -> bool:
    """Whether some of that floor is within reach of the box."""
    x0, y0, x1, y1 = ((v / CELL_M) for v in box.span)
    near = REACH_M / CELL_M
    rows = slice(max(0, int(y0 - near)), int(y1 + near) + 1)
    cols = slice(max(0, int(x0 - near)), int(x1 + near) + 1)
    return bool(main[rows, cols].any())
