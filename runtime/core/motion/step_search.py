"""Through a tight place in whole steps: which turns and steps, one after the other, lead on where
no single step does."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import SLOWEST, Terrain, clearance_between
from runtime.core.motion.courses import MARGIN_M
from runtime.core.motion.discrete_policy import FORWARD_M, SAMPLES, TURN_RAD, whole_turns
from runtime.core.types import F64, Action, Mask, Pose

STEPS = 10  # at most, one after the other
REACH_M = 1.2  # from the robot, within which a way is looked for
BEYOND_M = REACH_M / SLOWEST  # of arrival, that so much way can take
SAME_M = 0.03  # places nearer to each other count as one
GAIN_M = 0.2  # of arrival, that the way must win

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Way:
    """What leads through, nothing where there is no way; and the place, (x, y) m in the map frame,
    nearest to the field's sources that whole steps reach."""

    actions: tuple[Action, ...]
    nearest_xy: tuple[float, float]


def through(terrain: Terrain, field: Field, pose: Pose, radius_m: float, best_m: float) -> Way:
    """The fewest steps, and of those with the fewest turns, to where the arrival is below `best_m`
    by GAIN_M, or to the sources. Breadth first over all places that steps of FORWARD_M at
    headings TURN_RAD apart reach; the clearance is read between the cells' centres, as a
    finger's breadth decides."""
    turns = np.array(whole_turns())
    xy, heading, cost = pose.xy[None], np.zeros(1, np.int64), np.zeros(1, np.int64)
    seen = np.zeros(0, np.int64)
    nearest_m, nearest = field.at(pose.x_m, pose.y_m), pose.xy
    layers: list[tuple[Indices, Indices]] = []  # of each step: the place before it, and its turns
    for _ in range(STEPS):
        facing = heading[:, None] + turns
        step = _step(pose.yaw_rad + facing * TURN_RAD)
        ends = xy[:, None] + step
        arrival = field.of(field.frame.cells(ends))
        arrival[np.hypot(*(ends - pose.xy).transpose(2, 0, 1)) > REACH_M] = np.inf
        node, turn = np.nonzero(np.isfinite(arrival) & ~np.isin(_keys(ends), seen))
        free = _free(terrain, xy[node], step[node, turn], radius_m)
        node, turn = node[free], turn[free]
        if not node.size:
            break
        left_m, cost = arrival[node, turn], cost[node] + abs(turns[turn])
        new, seen = _new(_keys(ends[node, turn]), cost, seen)
        node, turn, left_m, cost = node[new], turn[new], left_m[new], cost[new]
        xy, heading = ends[node, turn], facing[node, turn]
        layers.append((node, turns[turn]))
        there = np.flatnonzero(left_m <= max(0.0, best_m - GAIN_M))
        if there.size:
            chosen = int(there[cost[there].argmin()])
            return Way(_traced(layers, chosen), _point(xy[chosen]))
        if left_m.size and left_m.min() < nearest_m:
            nearest_m, nearest = float(left_m.min()), xy[int(left_m.argmin())]
    return Way((), _point(nearest))


def clear(terrain: Terrain, pose: Pose, actions: Sequence[Action], radius_m: float) -> bool:
    """Whether the body keeps its clearance along all these actions."""
    for action in actions:
        if action is not Action.MOVE_FORWARD:
            turn = TURN_RAD if action is Action.TURN_LEFT else -TURN_RAD
            pose = replace(pose, yaw_rad=pose.yaw_rad + turn)
            continue
        step = _step(np.array([pose.yaw_rad]))
        if not _free(terrain, pose.xy[None], step, radius_m)[0]:
            return False
        x_m, y_m = _point(pose.xy + step[0])
        pose = replace(pose, x_m=x_m, y_m=y_m)
    return True


def _traced(layers: list[tuple[Indices, Indices]], at: int) -> tuple[Action, ...]:
    """The actions that end in place `at` of the last layer."""
    actions: list[Action] = []
    for node, turns in reversed(layers):
        way = Action.TURN_LEFT if turns[at] > 0 else Action.TURN_RIGHT
        actions += [Action.MOVE_FORWARD, *[way] * abs(int(turns[at]))]
        at = int(node[at])
    return tuple(reversed(actions))


def _keys(xy: F64) -> Indices:
    """(..., 2) m -> (...) a number for each place."""
    at = np.round(xy / SAME_M).astype(np.int64)
    keys: Indices = (at[..., 0] << 32) + at[..., 1]
    return keys


def _new(keys: Indices, cost: Indices, seen: Indices) -> tuple[Indices, Indices]:
    """Of N places that were not seen before the one with the fewest turns of each; and all that
    are seen from now on."""
    order = np.argsort(cost, kind="stable")
    places, first = np.unique(keys[order], return_index=True)
    return order[np.sort(first)], np.concatenate([seen, places])


def _step(heading_rad: F64) -> F64:
    """(...) -> (..., 2) m of one step."""
    ahead: F64 = FORWARD_M * np.stack([np.cos(heading_rad), np.sin(heading_rad)], axis=-1)
    return ahead


def _free(terrain: Terrain, xy: F64, step: F64, radius_m: float) -> Mask:
    """(N, 2) m places and steps from them -> (N,) whether the body keeps its clearance along each,
    or where it has less already loses no more."""
    share = np.linspace(0.0, 1.0, SAMPLES + 1)
    points = xy[:, None] + share[:, None] * step[:, None]
    cells, shape = terrain.frame.cells(points), np.array(terrain.frame.shape)
    inside = ((cells >= 1) & (cells < shape - 1)).all(axis=(1, 2))
    clearance = np.full(points.shape[:2], -math.inf)
    clearance[inside] = clearance_between(terrain, points[inside])
    needed = np.minimum(radius_m + MARGIN_M, np.maximum.accumulate(clearance, axis=1))
    short = (clearance[:, 1:] < needed[:, 1:] - 1e-6).any(axis=1)
    return np.asarray(inside & ~short, bool)


def _point(xy: F64) -> tuple[float, float]:
    return float(xy[0]), float(xy[1])
