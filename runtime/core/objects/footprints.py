"""The map cells under a thing."""

from collections.abc import Sequence

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.types import F64

LEAST_M = 0.15  # what is so near to an instance's middle is of it
STRAY = 2.4  # times the median distance from its middle: cells beyond are not of it


def footprint(frame: GridFrame, xy: F64) -> F64:
    """(N, 2) m -> (M, 2) centres of the cells under them, each once, in scan order."""
    scaled = np.subtract(xy.T, ((frame.x0_m,), (frame.y0_m,)), order="C") / frame.resolution_m
    cells = np.floor(scaled, out=scaled).astype(np.int64)
    (left, top), (right, bottom) = cells.min(axis=1).tolist(), cells.max(axis=1).tolist()
    (cols, rows), width = cells, right - left + 1
    flat = (rows - top) * width + (cols - left)
    held = np.zeros((bottom - top + 1) * width, bool)
    held[flat] = True
    row, col = np.divmod(held.nonzero()[0], width)
    found = np.empty((len(row), 2))
    found[:, 0] = (col + (left + 0.5)) * frame.resolution_m + frame.x0_m
    found[:, 1] = (row + (top + 0.5)) * frame.resolution_m + frame.y0_m
    return found


def footprints(frame: GridFrame, many: Sequence[F64]) -> list[F64]:
    """`footprint` of each, all at once: of a view's things, each of few points."""
    if not many:
        return []
    scaled = np.concatenate([xy.T for xy in many], axis=1)
    scaled -= np.array([[frame.x0_m], [frame.y0_m]])
    scaled /= frame.resolution_m
    cells = np.floor(scaled, out=scaled).astype(np.int64)
    count = np.array([len(xy) for xy in many])
    starts = np.cumsum(count) - count
    low = np.minimum.reduceat(cells, starts, axis=1)
    wide, high = np.maximum.reduceat(cells, starts, axis=1) - low + 1
    ends = np.cumsum(wide * high)  # each has a rectangle of its own in one row of cells
    first = ends - wide * high
    flat = cells[1] * np.repeat(wide, count)
    flat += cells[0]
    flat += np.repeat(first - low[1] * wide - low[0], count)
    held = np.zeros(int(ends[-1]), bool)
    held[flat] = True
    kept = held.nonzero()[0]
    parts = np.searchsorted(kept, ends)
    count = np.diff(parts, prepend=0)
    row, col = np.divmod(kept - np.repeat(first, count), np.repeat(wide, count))
    found = np.empty((len(kept), 2))
    found[:, 0] = (col + np.repeat(low[0] + 0.5, count)) * frame.resolution_m + frame.x0_m
    found[:, 1] = (row + np.repeat(low[1] + 0.5, count)) * frame.resolution_m + frame.y0_m
    return np.split(found, parts[:-1])


def without_strays(cells_xy: F64) -> F64:
    """(N, 2) m -> those not much farther from the middle than most: of a long rectangle all (its
    farthest cell is twice as far as the median), of a thing on a table not the table before it."""
    gap = cells_xy - middle(cells_xy)
    away, half = np.hypot(gap[:, 0], gap[:, 1]), len(cells_xy) // 2
    near = away <= max(STRAY * float(np.partition(away, half)[half]), LEAST_M)
    return cells_xy if near.all() else np.asarray(cells_xy[near])


def middle(points: F64) -> F64:
    """(N, K) -> (K,) the medians."""
    low, high = (len(points) - 1) // 2, len(points) // 2
    ordered = np.partition(points.T, (low, high), axis=1)
    return np.asarray((ordered[:, low] + ordered[:, high]) / 2)
