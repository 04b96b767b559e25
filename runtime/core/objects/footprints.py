"""The map cells under a thing."""

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.types import F64

LEAST_M = 0.15  # what is so near to an instance's middle is of it
STRAY = 2.4  # times the median distance from its middle: cells beyond are not of it


def footprint(frame: GridFrame, xy: F64) -> F64:
    """(N, 2) m -> (M, 2) centres of the cells under them, each once, in scan order."""
    rows, cols = np.ascontiguousarray(frame.cells(xy).T)
    top, left = rows.min(), cols.min()
    width = int(cols.max() - left) + 1
    held = np.zeros((int(rows.max() - top) + 1) * width, bool)
    held[(rows - top) * width + (cols - left)] = True
    row, col = np.divmod(np.flatnonzero(held), width)
    return frame.centres(np.stack([row + top, col + left], axis=1).astype(np.int32))


def without_strays(cells_xy: F64) -> F64:
    """(N, 2) m -> those not much farther from the middle than most: of a long rectangle all (its
    farthest cell is twice as far as the median), of a thing on a table not the table before it."""
    away = np.hypot(*(cells_xy - middle(cells_xy)).T)
    half = len(away) // 2
    near = away <= max(STRAY * float(np.partition(away, half)[half]), LEAST_M)
    return np.asarray(cells_xy[near])


def middle(points: F64) -> F64:
    """(N, K) -> (K,) the medians."""
    low, high = (len(points) - 1) // 2, len(points) // 2
    ordered = np.partition(points.T, (low, high), axis=1)
    return np.asarray((ordered[:, low] + ordered[:, high]) / 2)
