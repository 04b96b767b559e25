"""Homes as sets of walls and boxes, and what a robot that stands in one has mapped of it, in a
frame of its own."""

import math
from collections.abc import Sequence

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import RESOLUTION_M, MapCopy
from runtime.core.types import Pose
from runtime.core.world import World

Box = tuple[float, float, float, float]  # x0, y0, x1, y1, m

ROOMS: tuple[Box, ...] = (
    (0.0, 0.0, 9.0, 0.1), (0.0, 6.9, 9.0, 7.0), (0.0, 0.0, 0.1, 7.0), (8.9, 0.0, 9.0, 7.0),
    (4.5, 0.0, 4.6, 2.6), (4.5, 3.6, 4.6, 7.0),  # a wall with a door
    (0.6, 0.7, 1.9, 2.6), (3.0, 5.6, 4.2, 6.4), (0.4, 4.6, 0.9, 6.1),
    (6.4, 0.3, 8.0, 0.9), (5.4, 5.2, 6.0, 6.6), (7.6, 3.4, 8.5, 5.0), (2.6, 3.0, 3.1, 3.5),
)  # fmt: skip
OTHER_ROOMS: tuple[Box, ...] = (
    (0.0, 0.0, 7.0, 0.1), (0.0, 8.4, 7.0, 8.5), (0.0, 0.0, 0.1, 8.5), (6.9, 0.0, 7.0, 8.5),
    (0.0, 4.0, 2.4, 4.1), (3.4, 4.0, 7.0, 4.1),
    (5.2, 0.8, 6.4, 1.6), (0.5, 2.2, 1.3, 3.7), (4.6, 6.3, 6.6, 7.4), (0.6, 7.3, 2.2, 8.1),
    (3.0, 1.4, 3.9, 2.3),
)  # fmt: skip
TWINS: tuple[Box, ...] = tuple(
    (x0 + far, y0, x1 + far, y1)
    for far in (0.0, 4.5)
    for x0, y0, x1, y1 in (
        (0.0, 0.0, 4.5, 0.1), (0.0, 4.9, 4.5, 5.0), (0.0, 0.0, 0.1, 5.0), (4.4, 0.0, 4.5, 5.0),
        (0.4, 0.4, 1.6, 1.3), (3.0, 3.4, 4.0, 4.4), (0.5, 3.6, 1.0, 4.6),
    )
)  # fmt: skip
CORRIDOR: tuple[Box, ...] = ((0.0, 0.0, 30.0, 0.1), (0.0, 1.9, 30.0, 2.0))


def mapped(
    boxes: Sequence[Box], within: Box, start: Pose, noise: np.random.Generator | None = None
) -> MapCopy:
    """What lies in a part of the home, for a robot that began at `start` there: cells in its own
    frame, whose origin that is. With noise some obstacle cells are unknown."""
    x0, y0, x1, y1 = within
    corners = [_own(start, x, y) for x in (x0, x1) for y in (y0, y1)]
    low, high = np.min(corners, axis=0) - 0.3, np.max(corners, axis=0) + 0.3
    cols, rows = np.ceil((high - low) / RESOLUTION_M).astype(int).tolist()
    frame = GridFrame(float(low[0]), float(low[1]), RESOLUTION_M, rows, cols)
    stands, seen = _cells(frame, boxes, within, start)
    told = seen & (noise.random(stands.shape) > 0.1) if noise is not None else seen
    return MapCopy(frame, stands & told, ~stands & seen, ~seen | (stands & ~told))


def survey(world: World, boxes: Sequence[Box], within: Box, start: Pose) -> None:
    """Have a world know that, and nothing else."""
    stands, seen = _cells(world.map.frame, boxes, within, start)
    world.map.evidence[:] = np.where(stands, 20, -20) * seen
    world.map.swept[:] = False
    world.map.changed()


def _cells(
    frame: GridFrame, boxes: Sequence[Box], within: Box, start: Pose
) -> tuple[np.ndarray, np.ndarray]:
    """(R, C) what stands in a cell, and which are seen."""
    centres = frame.centres(np.stack(np.indices(frame.shape), axis=-1).astype(np.int32))
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    x = start.x_m + c * centres[..., 0] - s * centres[..., 1]
    y = start.y_m + s * centres[..., 0] + c * centres[..., 1]
    stands = np.zeros(frame.shape, bool)
    for a, b, p, q in boxes:
        stands |= (x >= a) & (x <= p) & (y >= b) & (y <= q)
    x0, y0, x1, y1 = within
    return stands, (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)


def _own(start: Pose, x: float, y: float) -> tuple[float, float]:
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    dx, dy = x - start.x_m, y - start.y_m
    return c * dx + s * dy, c * dy - s * dx
