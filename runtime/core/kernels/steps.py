"""The compiled part of ways in whole steps."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from runtime.core.kernels import _compiled
from runtime.core.types import F32, F64, Mask

Place = tuple[float, float, float, int, int]
"""Where a grid lies: its corner, (x, y) m in the map frame, its cells' length, m, and the row and
column of the whole that it begins at."""


class Berth(NamedTuple):
    """`clearance_m` is what it needs, m, and less by no more than `slack_m` still is as much; read
    at so many `samples` along a step, its beginning left out."""

    clearance_m: float
    slack_m: float
    samples: int


def steps_clear(clearance_m: F32, place: Place, from_xy: F64, steps: F64, berth: Berth) -> Mask:
    """Clearances (r, c) m by cell; steps (N, 2) m from points (N, 2) m of the map frame
    -> (N,) whether the body keeps its clearance along each, or where it has less already loses no
    more. The clearance is read between the cells' centres; outside, and on the outermost cells, is
    none."""
    clear: Mask = np.empty(len(from_xy), bool)
    ends = np.ascontiguousarray(from_xy), np.ascontiguousarray(steps)
    _compiled.steps_clear(clear.reshape(1, -1), clearance_m, *ends, place, berth)
    return clear


def whole_steps(
    clearance_m: F32,
    place: Place,
    arrival_m: F64,
    field_place: Place,
    start: tuple[float, float],
    steps: F64,
    berth: Berth,
    *,
    reach_m: float,
    same_m: float,
    best_m: float,
    most_steps: int,
    turns: range,
) -> tuple[Sequence[int], tuple[float, float]]:
    """Breadth first over the places that `steps` reach from `start`: (F, 2) m, F odd, the middle
    one at the heading of the start, each other one turn beside it; any of `turns` may be made
    before each step. Places nearer than `same_m` count as one, with the fewest turns that lead
    there. The turns before each step of the way to where `arrival_m` (R, C) is `best_m` or less,
    of the fewest steps and the fewest turns, and that place, (x, y) m in the map frame; nothing,
    and the place with the least arrival, where `most_steps` within `reach_m` of the start lead to
    none. ValueError for numbers that cannot be."""
    rules = (reach_m, same_m, best_m, most_steps, turns[0], turns[-1])
    grids = clearance_m, arrival_m, steps
    way, *end = _compiled.whole_steps(*grids, place, field_place, berth, start, rules)
    return np.frombuffer(way, np.int8).tolist(), (end[0], end[1])
