"""Depth of one camera as another one beside it would have measured it, pixel by pixel."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from runtime.core.geometry import mount_of, optical_to_base
from runtime.core.kernels import optics as kernels
from runtime.core.optics.lens import Lens, lens_rays
from runtime.core.types import F32, F64, Intrinsics, Mount

_DIGITS = 4  # of a mount: 0.1 mm, 0.1 mrad


@dataclass(frozen=True)
class Extrinsics:
    """Where a camera is in the optical frame of another: rows of the (3, 4) that takes a point from
    the first frame to the second, m."""

    rows: tuple[tuple[float, float, float, float], ...]

    @classmethod
    def of(cls, matrix: F64) -> "Extrinsics":
        """(3 or 4, 4); told to a micrometre."""
        rounded = [[round(float(v), 6) for v in row] for row in matrix[:3]]
        return cls(tuple((a, b, c, d) for a, b, c, d in rounded))

    @property
    def matrix(self) -> F64:
        return np.array(self.rows)


def registered(depth_m: F32, lens: Lens, placed: Extrinsics, target: Intrinsics) -> F32:
    """(H, W) m as a lens's image is published, 0 where unknown -> (h, w) m in the image of a
    pinhole that `placed` leads to: of what falls on one pixel the nearest, each as wide as a pixel
    of the first image is there. 0 where nothing falls."""
    across, down = lens_rays(lens)
    seen = np.empty((target.height, target.width), np.float32)
    i = lens.intrinsics
    wide, high = target.fx / i.fx, target.fy / i.fy
    camera = kernels.Camera(target.fx, target.fy, target.cx, target.cy, wide, high)
    kernels.register_depth(seen, depth_m, across, down, placed.rows, camera)
    return seen


def resized(depth_m: F32, width: int, height: int) -> F32:
    """(H, W) m of the same view, in so many pixels: each the reading that lies nearest."""
    found = cv2.resize(depth_m, (width, height), interpolation=cv2.INTER_NEAREST_EXACT)
    return np.asarray(found, np.float32)


def resized_intrinsics(intrinsics: Intrinsics, width: int, height: int) -> Intrinsics:
    """Of the same view in so many pixels."""
    i = intrinsics
    across, down = width / i.width, height / i.height
    return Intrinsics(i.fx * across, i.fy * down, i.cx * across, i.cy * down, width, height)


@lru_cache(maxsize=64)
def mount_beside(mount: Mount, placed: Extrinsics) -> Mount:
    """The mount of a camera that `placed` leads from, to one of that mount."""
    matrix, turn = placed.matrix, optical_to_base(mount)
    offset = turn @ matrix[:, 3] + (mount.x_m, mount.y_m, mount.z_m)
    return mount_of(turn @ matrix[:, :3], offset, _DIGITS)
