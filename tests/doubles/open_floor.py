"""A drawn floor without walls, and a bed on it at SPOT, seen from where a test says."""

import math

import numpy as np

from runtime.core.mapping.grid import NavigationMap
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.types import Pose

POSE, RADIUS_M = Pose(0.0, 0.0, 0.0), 0.18
SPOT = (2.0, 0.0)


def floor(half_m: float = 3.0) -> NavigationMap:
    """A square of free floor around the robot."""
    grid = NavigationMap.around(POSE, RADIUS_M)
    x, y = axes(grid)
    grid.evidence[(np.abs(x) < half_m) & (np.abs(y) < half_m)] = -10
    grid.changed()
    return grid


def axes(grid: NavigationMap) -> tuple[np.ndarray, np.ndarray]:
    frame = grid.frame
    rows, cols = np.indices(frame.shape)
    xy = frame.centres(np.stack([rows.ravel(), cols.ravel()], 1).astype(np.int32))
    return xy[:, 0].reshape(frame.shape), xy[:, 1].reshape(frame.shape)


def open_floor() -> tuple[NavigationMap, Pose]:
    grid, pose = NavigationMap.around(Pose(0, 0, 0), 0.18), Pose(0.0, 0.0, 0.0)
    low, high = grid.frame.cells(np.array([[-1.0, -3.0], [5.0, 3.0]]))
    grid.evidence[low[0] : high[0], low[1] : high[1]] = -10
    row, col = grid.frame.cell(*SPOT)
    grid.evidence[row - 3 : row + 4, col - 3 : col + 4] = 10
    grid.changed()
    return grid, pose


def at(bearing_rad: float, range_m: float) -> Pose:
    """A pose that looks at the spot from a direction, as seen from the spot."""
    x, y = SPOT[0] + range_m * math.cos(bearing_rad), SPOT[1] + range_m * math.sin(bearing_rad)
    return Pose(x, y, math.atan2(SPOT[1] - y, SPOT[0] - x))


def bed(*views: Pose, odds: float = 4.0, range_m: float = 1.0) -> Instance:
    cells = np.array([[SPOT[0] + 0.025, SPOT[1] + 0.025]])
    known = Evidence(odds, backing=list(views), near_m=range_m)
    return Instance(1, {"bed": known}, SPOT, 0.4, cells, range_m=range_m, views=list(views))
