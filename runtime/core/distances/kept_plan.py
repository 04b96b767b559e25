"""The way to an aim, kept from frame to frame: what changes on the map seldom touches it."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core import kernels
from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.mapping.windows import widened
from runtime.core.types import F32, F64, Mask, Pose

BEYOND_M = 1.5  # of arrival beyond the robot's own, that choosing its next steps may look at
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


@dataclass(frozen=True)
class _Plan:
    """A field toward sources, (N, 2) row, col of the whole grid, over the speeds it was made of."""

    sources: NDArray[np.int64]
    speed: F32
    field: Field
    limit_m: float  # up to which its arrivals are those of `planner.march`; later ones are inf


class KeptPlan:
    """One plan, the last. What it gives is what `planner.march` would, to the last bit, as far as
    BEYOND_M beyond the robot: an arrival depends on earlier ones alone, so that those before the
    earliest that a change of the terrain can have touched are kept, and the front goes on from
    there."""

    def __init__(self) -> None:
        self._plan: _Plan | None = None

    def toward(self, terrain: Terrain, sources: Mask, pose: Pose) -> Field:
        """Arrival times from the source cells, (r, c), at the robot and before it, and BEYOND_M
        beyond it; what is later may be inf. All that can be reached, where the robot cannot."""
        frame = terrain.frame
        rows, cols = np.divmod(np.flatnonzero(sources & terrain.traversable), frame.cols)
        at = np.stack([rows + frame.first_row, cols + frame.first_col], axis=1)
        arrival, limit_m = self._known(terrain, at)
        here = frame.cell(pose.x_m, pose.y_m)
        if limit_m < Field(frame, arrival).at(pose.x_m, pose.y_m) + BEYOND_M:
            arrival = arrival.copy()  # others still go by what was
            arrival[rows, cols] = 0.0
            cell_m = frame.resolution_m
            marched_m = kernels.march(arrival, terrain.speed, cell_m, until=here, beyond=BEYOND_M)
            limit_m = max(limit_m, marched_m)
        kept = self._plan is not None and arrival is self._plan.field.arrival_m
        field = self._plan.field if self._plan and kept else Field(frame, arrival)
        self._plan = _Plan(at, terrain.speed.copy(), field, limit_m)
        return field

    def _known(self, terrain: Terrain, sources: NDArray[np.int64]) -> tuple[F64, float]:
        """(r, c) arrivals that still hold, inf for others, and up to which arrival they are all."""
        plan, frame = self._plan, terrain.frame
        if plan is None or not _of_one_grid(plan.field.frame, frame):
            return np.full(frame.shape, np.inf), -1.0
        if not np.array_equal(plan.sources, sources):
            return np.full(frame.shape, np.inf), -1.0
        arrival, before, lost_m = plan.field.arrival_m, plan.speed, math.inf
        if plan.field.frame != frame:
            arrival, before, lost_m = _moved(plan, frame)
        changed = before != terrain.speed
        if math.isinf(lost_m) and not changed.any():
            return arrival, plan.limit_m
        beside = cv2.dilate(changed.view(np.uint8), _CROSS).view(bool)
        touched_m = float(arrival.min(where=beside, initial=lost_m))
        if math.isinf(touched_m):
            return arrival, plan.limit_m
        return np.where(arrival < touched_m, arrival, np.inf), math.nextafter(touched_m, 0.0)


def _of_one_grid(a: GridFrame, b: GridFrame) -> bool:
    return (a.x0_m, a.y0_m, a.resolution_m) == (b.x0_m, b.y0_m, b.resolution_m)


def _moved(plan: _Plan, frame: GridFrame) -> tuple[F64, F32, float]:
    """A plan's arrivals and speeds over another window of the same grid, and the earliest arrival
    that is outside."""
    old = plan.field.frame
    arrival, speed = np.full(frame.shape, np.inf), np.zeros(frame.shape, np.float32)
    down, right = old.first_row - frame.first_row, old.first_col - frame.first_col
    into = widened((slice(down, down + old.rows), slice(right, right + old.cols)), 0, frame)
    of = tuple(slice(s.start - n, s.stop - n) for s, n in zip(into, (down, right), strict=True))
    arrival[into], speed[into] = plan.field.arrival_m[of], plan.speed[of]
    outside = np.ones(old.shape, bool)
    outside[of] = False
    return arrival, speed, float(plan.field.arrival_m.min(where=outside, initial=math.inf))
