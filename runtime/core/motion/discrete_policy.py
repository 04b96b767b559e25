"""The action of the benchmark protocols that follows an arrival field."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import wrap_angle
from runtime.core.motion.courses import MARGIN_M
from runtime.core.types import F64, Action, Mask, Pose

FORWARD_M = 0.25  # a step, as the benchmark protocols have it
TURN_RAD = math.radians(30.0)  # and a turn
TURN_COST_M = 0.04  # what a turn must win in arrival time; keeps headings steady
SAMPLES = 5  # points checked along a step
FEET_M = 0.1  # ahead of the body's middle something still carries it


def follow(terrain: Terrain, field: Field, pose: Pose, radius_m: float) -> Action | None:
    """The action toward the field's sources: of all headings that a whole number of turns reaches,
    the one whose next step ends nearest to them. None when no heading can be driven."""
    here = field.at(pose.x_m, pose.y_m)
    best: tuple[float, int, int] | None = None
    turnings = whole_turns()
    arrivals = _after_step(terrain, field, _step(pose, turnings), radius_m)
    for turns, arrival in zip(turnings, arrivals, strict=True):
        if arrival >= here + 2 * FORWARD_M:
            continue
        cost = (float(arrival) + TURN_COST_M * abs(turns), abs(turns), -turns)
        best = min(best, cost) if best else cost
    if best is None:
        return None
    return _begin(-best[2])


def squeeze(terrain: Terrain, pose: Pose, no_floor: Callable[[F64], Mask]) -> Action:
    """Out of a place where the map leaves no heading to drive: toward the one whose next step keeps
    the most clearance. The robot came here, so one is wider than the map says; but not to where
    there is `no_floor`, told of (..., 2) m points. Where that is all around it stays, and turns."""
    turnings = sorted(whole_turns(), key=abs)
    steps = _step(pose, turnings)
    cells = terrain.frame.cells(steps[:, 1:])
    inside = ((cells >= 0) & (cells < terrain.frame.shape)).all(axis=(1, 2))
    least = np.full(len(turnings), -1.0)
    least[inside] = terrain.clearance_m[cells[inside, :, 0], cells[inside, :, 1]].min(axis=1)
    feet = steps + (steps[:, -1:] - steps[:, :1]) * (FEET_M / FORWARD_M)
    falls = (no_floor(steps) | no_floor(feet)).any(axis=1)
    least[falls] = -math.inf
    return _begin(turnings[int(least.argmax())]) if not falls.all() else Action.TURN_LEFT


def whole_turns() -> range:
    """All headings that a whole number of turns reaches, as that number; left is positive."""
    half_turns = round(math.pi / TURN_RAD)
    return range(-half_turns + 1, half_turns + 1)


def _begin(turns: int) -> Action:
    """The first action of so many turns and a step."""
    if turns == 0:
        return Action.MOVE_FORWARD
    return Action.TURN_LEFT if turns > 0 else Action.TURN_RIGHT


def _step(pose: Pose, turnings: Sequence[int]) -> F64:
    """(H, SAMPLES + 1, 2) m: points along one step after each number of turns."""
    headings = pose.yaw_rad + np.array(turnings) * TURN_RAD
    reach = np.linspace(0.0, FORWARD_M, SAMPLES + 1)
    along = np.stack([np.cos(headings), np.sin(headings)], axis=1)
    return np.asarray(pose.xy + reach[None, :, None] * along[:, None], np.float64)


def face(pose: Pose, toward_rad: float) -> Action | None:
    """The turn that brings the heading closer to `toward_rad`; None when no turn would."""
    error = wrap_angle(toward_rad - pose.yaw_rad)
    if abs(error) <= TURN_RAD / 2 + 1e-6:
        return None
    return Action.TURN_LEFT if error > 0 else Action.TURN_RIGHT


def _after_step(terrain: Terrain, field: Field, points: F64, radius_m: float) -> F64:
    """(H, N, 2) points along steps -> (H,) arrival time at the end of each; inf where the body
    would touch."""
    fits = _fits(terrain, points, radius_m + MARGIN_M)
    ends = np.full(len(points), np.inf)
    rows, cols = field.frame.cells(points[fits, -1]).T
    ends[fits] = field.arrival_m[rows, cols]
    return ends


def _fits(terrain: Terrain, points_xy: F64, clear_m: float) -> Mask:
    """(H, N, 2) m -> (H,) whether the body keeps its clearance along each line of points. A way
    out of a tight spot may begin within the clearance, as long as it never loses more."""
    cells = terrain.frame.cells(points_xy)
    inside = ((cells >= 0) & (cells < terrain.frame.shape)).all(axis=(1, 2))
    fits = np.zeros(len(points_xy), bool)
    clearance = terrain.clearance_m[cells[inside, :, 0], cells[inside, :, 1]]
    needed = np.minimum(clear_m, np.maximum.accumulate(clearance, axis=1))
    fits[inside] = ~(clearance[:, 1:] < needed[:, 1:] - 1e-6).any(axis=1)
    return fits
