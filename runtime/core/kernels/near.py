"""The compiled part of what stands near the body."""

from typing import NamedTuple

from runtime.core.kernels import _compiled
from runtime.core.types import F32


class NearRules(NamedTuple):
    """Where a camera is in the base frame, what of its image counts as near, and how much of it is
    something. Heights are above the floor; all but pixels and the slack in m."""

    stride: int  # every n-th pixel of the image is used
    max_depth_m: float
    x_m: float  # the camera
    y_m: float
    z_m: float
    floor_m: float  # points are no floor that are this much off it and `slack` more a m away
    slack: float
    height_m: float  # what is higher is passed under
    ahead_m: float  # of the base: the grid
    aside_m: float
    behind_m: float
    cell_m: float
    least: float  # used pixels in a cell and the eight around it
    least_drops: float


def near_points(
    found: F32, depth_m: F32, forward: F32, left: F32, up: F32, rules: NearRules
) -> int:
    """Writes to `found` (M, 5) the middles of what a depth image (H, W) shows in the cells of a
    grid around the base: x, y, z, then 0 for an obstacle, 1 for a ray that crosses the floor's
    plane and ends below it (there x, y are where it crosses), and the lowest z that was seen there.
    How many were written. `forward`, `left`
    and `up` are those of the used pixels (h, w), m to a metre of depth. ValueError for shapes that
    do not fit."""
    return min(len(found), _compiled.near_points(found, depth_m, forward, left, up, *rules))
