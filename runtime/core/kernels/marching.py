"""Fast marching, and the ways down what it gives."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from runtime.core.kernels import _compiled
from runtime.core.types import F32, F64, I32

NOWHERE = (-1, -1)


def march(
    arrival: F64,
    speed: NDArray[Any],
    cell_m: float,
    limit: float = math.inf,
    until: tuple[int, int] = NOWHERE,
    beyond: float = math.inf,
) -> float:
    """Fast marching, in place. `arrival` (r, c) holds the times of a front where they are known, 0
    or more, and inf elsewhere; after it, how early the front is at each cell that it reaches by
    `limit`, and by no more than `beyond` later than it is at the cell `until`; returned is the
    limit that came of both. It goes on from what is known, and ends within rounding, a few ulps,
    of where it would from the start. `speed` (r, c) is relative, float 0 to 1, 0 where it cannot
    move; or a mask of where it can, at 1. Times are in metres at speed 1. First-order upwind scheme
    of the eikonal equation (Sethian 1996). ValueError for shapes that differ, more cells than can
    be numbered, and numbers that cannot be."""
    return _compiled.march(arrival, speed, cell_m, limit, *until, beyond)


def descend(arrival: F64, start: tuple[int, int], limit: int) -> I32:
    """(r, c) and a cell of it -> (N, 2) row, col: from there always to that of the eight neighbours
    to which it falls most steeply, to an arrival of 0 or where none is lower, or for `limit` cells
    more; (0, 2) from outside or where the arrival is inf. ValueError for a limit below 0."""
    path = _compiled.descend(arrival, *start, limit)
    return np.frombuffer(path, np.int32).reshape(-1, 2)


def touched(arrival: F64, before: F32, speed: F32) -> float:
    """(r, c) arrivals of a front by the speeds `before`, and the speeds now -> the earliest arrival
    at a cell whose speed is another, or at one of its four neighbours: those before it hold. inf
    where none is touched. `before` then has the speeds of now."""
    return _compiled.touched(arrival, before, speed)
