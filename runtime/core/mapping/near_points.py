"""What stands near the body, and where near it the floor is missing, by one depth image alone: no
evidence is gathered, for what has just stepped in front has none."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from runtime.core.geometry import rays
from runtime.core.kernels import near as kernels
from runtime.core.mapping.grid import FLOOR_BELOW_M
from runtime.core.types import F32, Intrinsics, Mount

AHEAD_M: Final = 2.5  # of the base's middle; what is farther is the map's
ASIDE_M: Final = 1.5  # to either side
BEHIND_M: Final = 0.3
CELL_M: Final = 0.04  # points in one are told as their middle
SLACK: Final = 0.02  # m a metre away: a tilt that is off by a degree makes no obstacle of the floor
LEAST_PX: Final = 36  # of the image, in a cell and around it, that are something
LEAST_DROP_PX: Final = 72  # of floor that is missing: what mirrors is smaller, or the map's
_SAMPLES: Final = 200  # across an image
_MOST: Final = 2000  # points


@dataclass(frozen=True)
class NearPoints:
    """In the base frame at the moment of the image, m. obstacles: (N, 3) x, y, z of what stands on
    the floor or hangs lower than the body is high; lowest_m: (N,) the lowest that was seen of each.
    drops: (M, 3) where rays that end below the floor cross it; their z is 0."""

    obstacles: F32
    lowest_m: F32
    drops: F32


def near_points(
    depth_m: F32, intrinsics: Intrinsics, mount: Mount, height_m: float, max_depth_m: float
) -> NearPoints:
    """(H, W) m along the optical axis, `solid`, 0 or NaN where unknown, for a body of that height.
    What has too few pixels is nothing."""
    stride = max(1, round(intrinsics.width / _SAMPLES))
    table = rays(intrinsics, mount, stride)
    found = np.empty((_MOST, 5), np.float32)
    rules = kernels.NearRules(
        stride, max_depth_m, mount.x_m, mount.y_m, mount.z_m, FLOOR_BELOW_M, SLACK, height_m,
        AHEAD_M, ASIDE_M, BEHIND_M, CELL_M, LEAST_PX / stride**2, LEAST_DROP_PX / stride**2,
    )  # fmt: skip
    count = kernels.near_points(found, depth_m, table.forward, table.left, table.up, rules)
    found = found[:count]
    drops = found[found[:, 3] > 0, :3]
    drops[:, 2] = 0
    stands = found[found[:, 3] == 0]
    return NearPoints(stands[:, :3], stands[:, 4], drops)
