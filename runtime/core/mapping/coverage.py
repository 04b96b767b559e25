"""What was seen from near: a place whose floor is known may still hide a small thing.

When no frontier is left, the robot looks for what it saw only from afar.
"""

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import polygon_patch
from runtime.core.types import F64, Mask

NEAR_M = 2.2  # what is closer to the camera has been looked at
MIN_CELLS = 120  # of a place that is worth going to


def look(looked: Mask, frame: GridFrame, outline: F64) -> None:
    """Mark what a view shows from near, in place. `outline` (V, 2) m begins with the camera."""
    offset = outline - outline[0]
    reach = np.hypot(*offset.T)
    scale = np.minimum(1.0, NEAR_M / np.maximum(reach, 1e-6))
    patch, window = polygon_patch(frame, outline[0] + offset * scale[:, None])
    looked[window] |= patch


def overlooked(grid: NavigationMap, looked: Mask, given_up: Mask) -> Mask:
    """(R, C) free cells that were never seen from near, but for what was given up."""
    cells: Mask = grid.free & ~looked & ~given_up
    return cells
