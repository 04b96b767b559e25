"""A lens that bends straight lines, as OpenCV models it, and images as a pinhole would have taken
them."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import cv2
import numpy as np

from runtime.core.optics.upright import upright_image, upright_intrinsics
from runtime.core.types import F32, F64, U8, Intrinsics, Mask

NOWHERE: Final = -1e4  # px: outside of any image
LEAST_SHARE: Final = 0.3  # of a straightened image that the lens must have seen, else it is none


@dataclass(frozen=True)
class Lens:
    """A camera's image as it is published. coefficients: as OpenCV has them, () for a pinhole: k1,
    k2, p1, p2, k3, ... or, of a fisheye, k1 to k4."""

    intrinsics: Intrinsics
    coefficients: tuple[float, ...] = ()
    fisheye: bool = False


@dataclass(frozen=True)
class Straightened:
    """What makes upright pinhole images of a lens's. `intrinsics`: theirs. `share`: of their pixels
    that the lens has seen."""

    lens: Lens
    quarters: int
    intrinsics: Intrinsics
    share: float
    _smooth: tuple[np.ndarray, np.ndarray] | None  # where each pixel is in the lens's image,
    _nearest: tuple[np.ndarray, np.ndarray] | None  # and the nearest to that

    def color(self, rgb: U8) -> U8:
        """(H, W, 3) as published -> upright, straight; black where the lens saw nothing."""
        if self._smooth is None:
            return upright_image(rgb, self.quarters)
        return np.asarray(cv2.remap(rgb, *self._smooth, cv2.INTER_LINEAR), np.uint8)

    def depth(self, depth_m: F32) -> F32:
        """(H, W) m -> the same; no two readings are mixed. 0 where the lens saw nothing."""
        if self._nearest is None:
            return upright_image(depth_m, self.quarters)
        return np.asarray(cv2.remap(depth_m, *self._nearest, cv2.INTER_NEAREST), np.float32)


@lru_cache(maxsize=8)
def straightened(lens: Lens, quarters: int = 0) -> Straightened:
    """Computed once for a lens and how its camera is turned: the focal lengths stay."""
    upright = upright_intrinsics(lens.intrinsics, quarters)
    if not lens.coefficients:
        return Straightened(lens, quarters, upright, 1.0, None, None)
    x, y = _in_image(lens)
    i = lens.intrinsics
    seen = (x > -1) & (x < i.width) & (y > -1) & (y < i.height)
    across, down = (
        np.rot90(np.where(seen, v, NOWHERE), -quarters).astype(np.float32) for v in (x, y)
    )
    smooth = cv2.convertMaps(across, down, cv2.CV_16SC2)
    nearest = cv2.convertMaps(across, down, cv2.CV_16SC2, nninterpolation=True)
    return Straightened(lens, quarters, upright, float(seen.mean()), smooth, nearest)


@lru_cache(maxsize=4)
def lens_rays(lens: Lens) -> tuple[F32, F32]:
    """(H, W) each: m to the right and down per m of depth, of every pixel as published; shared."""
    i = lens.intrinsics
    u, v = np.meshgrid(np.arange(i.width, dtype=np.float64), np.arange(i.height, dtype=np.float64))
    if not lens.coefficients:
        across, down = (u + 0.5 - i.cx) / i.fx, (v + 0.5 - i.cy) / i.fy
    else:
        pixels = np.stack([u, v], axis=-1).reshape(-1, 1, 2)
        undo = cv2.fisheye.undistortPoints if lens.fisheye else cv2.undistortPoints
        found = undo(pixels, _matrix(i), np.array(lens.coefficients))
        rays = np.asarray(found, np.float64).reshape(i.height, i.width, 2)
        across, down = rays[..., 0], rays[..., 1]
    return np.ascontiguousarray(across, np.float32), np.ascontiguousarray(down, np.float32)


def _in_image(lens: Lens) -> tuple[F64, F64]:
    """(H, W) each: where a pinhole's pixel is in the lens's image, px, nowhere where its model has
    turned back."""
    i, matrix, bent = lens.intrinsics, _matrix(lens.intrinsics), np.array(lens.coefficients)
    size = i.width, i.height
    if lens.fisheye:
        made = cv2.fisheye.initUndistortRectifyMap(
            matrix, bent, np.eye(3), matrix, size, cv2.CV_32FC1
        )
    else:
        made = cv2.initUndistortRectifyMap(matrix, bent, np.eye(3), matrix, size, cv2.CV_32FC1)
    x, y = (np.where(np.isfinite(v), v, NOWHERE).astype(np.float64) for v in made)
    folded = _folded(x, y)
    x[folded], y[folded] = NOWHERE, NOWHERE
    return x, y


def _folded(x: F64, y: F64) -> Mask:
    """Where a polynomial beyond what it was fitted to shows the image once more, inside out."""
    (x_down, x_across), (y_down, y_across) = np.gradient(x), np.gradient(y)
    return np.asarray(x_across * y_down - x_down * y_across <= 0, bool)


def _matrix(i: Intrinsics) -> F64:
    """As OpenCV has it, where the middle of the first pixel is (0, 0)."""
    return np.array([[i.fx, 0, i.cx - 0.5], [0, i.fy, i.cy - 0.5], [0, 0, 1]])
