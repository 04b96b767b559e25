"""The map cells under a thing."""

import math
from typing import NamedTuple

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.kernels import objects as kernels
from runtime.core.types import F64

LEAST_M = 0.15  # what is so near to an instance's middle is of it
STRAY = 2.4  # times the median distance from its middle: cells beyond are not of it, which
"""leaves all of a long rectangle (its farthest cell is twice as far as the median), and of a thing
on a table not the table before it."""
STRAYS = STRAY, LEAST_M
ROUNDED_M = 1e-3  # OpenCV's rectangles are of single precision


class Joined(NamedTuple):
    """Cells (N, 2) m under two views of a thing, whether none of them was a stray, and medians."""

    cells_xy: F64
    whole: bool
    xy: tuple[float, float]


def numbers(frame: GridFrame) -> tuple[float, float, float]:
    """The frame as kernels take it."""
    return frame.x0_m, frame.y0_m, frame.resolution_m


def unpacked(cells: bytes) -> F64:
    """(N, 2) m, not to be written to."""
    return np.ndarray((len(cells) // 16, 2), np.float64, cells)


def joined(frame: GridFrame, cells_xy: F64, others_xy: F64, settled: bool) -> Joined | None:
    """(N, 2), (M, 2) m: the cells under both, strays left out; None where the first are `settled`,
    none of them being a stray, and the others are no news."""
    told = kernels.joined_cells(cells_xy, others_xy, numbers(frame), STRAYS, settled)
    if told is None:
        return None
    packed, whole, x, y = told
    return Joined(unpacked(packed), bool(whole), (x, y))


def middle(cells_xy: F64) -> tuple[float, float]:
    """(N, 2) m -> the medians."""
    low, high = (len(cells_xy) - 1) // 2, len(cells_xy) // 2
    ordered = np.partition(cells_xy.T, (low, high), axis=1)
    x, y = ((ordered[:, low] + ordered[:, high]) / 2).tolist()
    return x, y


def length_bounds(cells_xy: F64) -> tuple[float, float]:
    """(N, 2) m -> between which lengths the longer side of the tightest rectangle round them is, m:
    its diagonal is no less than any extent, and its sides no more than any rectangle's diagonal."""
    wide, high = kernels.cells_extent(cells_xy)
    return max(wide, high) * math.sqrt(0.5) - ROUNDED_M, math.hypot(wide, high) + ROUNDED_M
