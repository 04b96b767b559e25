"""Ways that were open once and no more are: a door was closed, or somebody stands in it."""

import math
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np

from runtime.core.distances.planner import Field, descend
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.kernels import marching
from runtime.core.mapping.windows import Window
from runtime.core.types import F64, I32, Mask

CUT_OFF_M2: Final = 0.3  # of floor that is known and cannot be reached any more
LOOK_FROM_M: Final = (0.8, 1.3)  # before the first place that cannot be reached
FACE_M: Final = 0.3  # beyond that place


@dataclass(frozen=True)
class ClosedWay:
    """Where one is, m; cells of the terrain to look at it from, (N, 2) row, col; how far those are
    on foot, m."""

    xy: tuple[float, float]
    stands: I32
    away_m: float


@dataclass
class TriedWay:
    """How often a closed way was looked at again, and when last, s; since when it is watched;
    whether it is open by now."""

    id: int
    xy: tuple[float, float]
    looks: int = 0
    last_s: float = -math.inf
    since_s: float | None = None
    is_open: bool = False


@dataclass
class Passages:
    """Which cells of a map could be reached once, and what became of the ways that were closed."""

    tried: list[TriedWay] = field(default_factory=list)
    next_id: int = 1
    _frame: GridFrame | None = None
    _opened: Mask = field(default_factory=lambda: np.zeros((0, 0), bool), repr=False)

    @property
    def still_closed(self) -> list[TriedWay]:
        """Those that were looked at again in vain."""
        return [tried for tried in self.tried if tried.looks and not tried.is_open]

    def note(self, frame: GridFrame, reach: Field, tight: bool = False) -> None:
        """What can be reached now, of a map of that frame. What is beyond a `tight` gap was never
        open: it is let through when nothing else is left."""
        if self._frame != frame:
            before, opened = self._frame, np.zeros(frame.shape, bool)
            if before is not None:
                opened[_window(frame, before)] = self._opened
            self._frame, self._opened = frame, opened
        if not tight:
            self._opened[_window(frame, reach.frame)] |= np.isfinite(reach.arrival_m)
        for tried in self.tried:
            tried.is_open = math.isfinite(reach.at(*tried.xy))

    def closed(self, terrain: Terrain, reach: Field, barred: Mask) -> list[ClosedWay]:
        """The ways to floor that could be reached, and cannot now; the nearest first. None leads
        through what is `barred` (R, C) of the map."""
        assert self._frame is not None
        window = _window(self._frame, terrain.frame)
        opened = self._opened[window] & ~barred[window]
        reached = np.isfinite(reach.arrival_m)
        lost = (opened & terrain.traversable & ~reached).view(np.uint8)
        count, labels, stats, _ = cv2.connectedComponentsWithStats(lost, connectivity=8)
        least = CUT_OFF_M2 / terrain.frame.resolution_m**2
        large = (n for n in range(1, count) if stats[n, cv2.CC_STAT_AREA] >= least)
        ways = [_way(labels == n, opened, reach, reached) for n in large]
        return sorted((way for way in ways if way), key=lambda way: (way.away_m, way.xy))


def _window(frame: GridFrame, part: GridFrame) -> Window:
    """Where a part of a grid, or the grid as it was before it grew, lies in it."""
    (x, y) = part.centres(np.zeros(2, np.int32)).tolist()
    top, left = frame.cell(x, y)
    return slice(top, top + part.rows), slice(left, left + part.cols)


def _way(lost: Mask, opened: Mask, reach: Field, reached: Mask) -> ClosedWay | None:
    """The way to cells that are lost, where they were reached by before."""
    arrival: F64 = np.where(lost, 0.0, np.inf)
    marching.march(arrival, opened, reach.frame.resolution_m)
    left = np.where(reached, arrival, np.inf)
    first_m = float(left.min())
    if not math.isfinite(first_m):
        return None
    near, far = LOOK_FROM_M
    stands = (left >= first_m + near) & (left <= first_m + far)
    if not stands.any():
        stands = left <= first_m + near
    edge = np.unravel_index(int(left.argmin()), left.shape)
    x, y = reach.frame.centres(np.array(edge, np.int32)).tolist()
    beyond = descend(Field(reach.frame, arrival), (x, y), round(FACE_M / reach.frame.resolution_m))
    at_x, at_y = beyond[-1].tolist()
    cells = np.argwhere(stands).astype(np.int32)
    return ClosedWay((at_x, at_y), cells, float(reach.arrival_m[stands].min()))
