"""The way to an aim, kept from frame to frame: what changes on the map seldom touches it."""

import math
from dataclasses import dataclass, replace

import numpy as np

from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.kernels import marching
from runtime.core.mapping.windows import widened
from runtime.core.types import F32, I32, Pose

BEYOND_M = 1.5  # of arrival beyond the robot's own, that choosing its next step may look at


@dataclass(frozen=True)
class _Plan:
    """A field toward sources, (2, N) row, col of the whole grid, over the speeds it was made of."""

    sources: I32
    speed: F32  # nobody else's: kept up to date in place
    field: Field
    limit_m: float  # up to which its arrivals are those of `planner.march`; later ones are inf


class KeptPlan:
    """One plan, the last. What it gives is what `planner.march` would, within rounding, as far as
    BEYOND_M beyond the robot: an arrival depends on earlier ones alone, so that those before the
    earliest that a change of the terrain can have touched are kept, and the front goes on from
    there."""

    def __init__(self) -> None:
        self._plan: _Plan | None = None

    def toward(self, terrain: Terrain, sources: I32, pose: Pose) -> Field:
        """Arrival times from the traversable ones of the source cells, (N, 2) row, col, at the
        robot and before it, and BEYOND_M beyond it; what is later may be inf. All that can be
        reached, where the robot cannot."""
        frame = terrain.frame
        inside = sources[((sources >= 0) & (sources < frame.shape)).all(axis=1)]
        rows, cols = inside[terrain.traversable[inside[:, 0], inside[:, 1]]].T
        at = np.stack([rows + frame.first_row, cols + frame.first_col])
        self._plan = self._known(terrain, at)
        return self._as_far(self._plan, terrain, pose, BEYOND_M)

    def farther(self, field: Field, terrain: Terrain, pose: Pose, beyond_m: float) -> Field:
        """What `toward` gave of this terrain, with arrivals as far beyond the robot as that; a
        field that it did not give, as it is."""
        plan = self._plan
        if plan is None or plan.field is not field:
            return field
        return self._as_far(plan, terrain, pose, beyond_m)

    def _as_far(self, plan: _Plan, terrain: Terrain, pose: Pose, beyond_m: float) -> Field:
        frame = terrain.frame
        if plan.limit_m >= plan.field.at(pose.x_m, pose.y_m) + beyond_m:
            return plan.field
        arrival, here = plan.field.arrival_m.copy(), frame.cell(pose.x_m, pose.y_m)
        rows, cols = plan.sources
        arrival[rows - frame.first_row, cols - frame.first_col] = 0.0
        limit_m = marching.march(
            arrival, terrain.speed, frame.resolution_m, until=here, beyond=beyond_m
        )
        self._plan = replace(plan, field=Field(frame, arrival), limit_m=limit_m)
        return self._plan.field

    def _known(self, terrain: Terrain, sources: I32) -> _Plan:
        """What of the plan still holds; of another plan nothing."""
        plan, frame = self._plan, terrain.frame
        if (
            plan is None
            or not _of_one_grid(plan.field.frame, frame)
            or not np.array_equal(plan.sources, sources)
        ):
            nothing = Field(frame, np.full(frame.shape, np.inf))
            return _Plan(sources, terrain.speed.copy(), nothing, -1.0)
        lost_m = math.inf
        if plan.field.frame != frame:
            plan, lost_m = _moved(plan, frame)
        arrival = plan.field.arrival_m
        touched_m = min(lost_m, marching.touched(arrival, plan.speed, terrain.speed))
        if math.isinf(touched_m):
            return plan
        held = Field(frame, np.where(arrival < touched_m, arrival, np.inf))
        return replace(plan, field=held, limit_m=math.nextafter(touched_m, 0.0))


def _of_one_grid(a: GridFrame, b: GridFrame) -> bool:
    return (a.x0_m, a.y0_m, a.resolution_m) == (b.x0_m, b.y0_m, b.resolution_m)


def _moved(plan: _Plan, frame: GridFrame) -> tuple[_Plan, float]:
    """A plan over another window of the same grid, and the earliest arrival that is outside."""
    old = plan.field.frame
    arrival, speed = np.full(frame.shape, np.inf), np.zeros(frame.shape, np.float32)
    down, right = old.first_row - frame.first_row, old.first_col - frame.first_col
    into = widened((slice(down, down + old.rows), slice(right, right + old.cols)), 0, frame)
    of = tuple(slice(s.start - n, s.stop - n) for s, n in zip(into, (down, right), strict=True))
    arrival[into], speed[into] = plan.field.arrival_m[of], plan.speed[of]
    outside = np.ones(old.shape, bool)
    outside[of] = False
    lost_m = float(plan.field.arrival_m.min(where=outside, initial=math.inf))
    return replace(plan, field=Field(frame, arrival), speed=speed), lost_m
