"""The core's inner loops, compiled: what NumPy and OpenCV would do in many passes over arrays, or
not at all. Each takes arrays and changes or returns arrays; none keeps anything."""

import math
from typing import Any

from numpy.typing import NDArray

from runtime.core.kernels import _compiled
from runtime.core.types import F64


def march(arrival: F64, speed: NDArray[Any], cell_m: float, limit: float = math.inf) -> None:
    """Fast marching, in place. `arrival` (r, c) holds the times of a front where they are known, 0
    or more, and inf elsewhere; after it, how early the front is at each cell that it reaches by
    `limit`. It goes on from what is known and ends at the same bits as from the start. `speed`
    (r, c) is relative, float 0 to 1, 0 where it cannot move; or a mask of where it can, at 1. Times
    are in metres at speed 1. First-order upwind scheme of the eikonal equation (Sethian 1996).
    ValueError for shapes that differ and numbers that cannot be."""
    _compiled.march(arrival, speed, cell_m, limit)
