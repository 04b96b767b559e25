"""What a keyframe shows toward a frontier, as an expert that sees is shown it: parts of the image
in the grid that the detector's backbone has them in, letterboxed and centred."""

import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import map_to_optical, project
from runtime.core.types import F16, F32, F64, Intrinsics, Mount, Pose

Index = NDArray[np.intp]
FAR_M = 10.0
"""Depth beyond it says no more."""
NEAREST_M = 0.05
"""What stands nearer, or behind, is told at the image's edge."""
STEP = 4
"""Every so many-th row and column of the depth image is looked at."""


def sight_depth(depth_m: F32, rows: int, cols: int) -> F32:
    """(H, W) m along the optical axis, 0 or not finite where unknown -> (2, rows, cols): mean
    depth of what is known in each part, m, clipped at FAR_M, 0 where nothing is; share known."""
    seen = depth_m[STEP // 2 :: STEP, STEP // 2 :: STEP]
    known = np.isfinite(seen) & (seen > 0)
    row, col = (
        _part(np.arange(n), n, other, parts, others)
        for n, other, parts, others in (
            (*seen.shape, rows, cols), (*seen.shape[::-1], cols, rows))
    )  # fmt: skip
    part = (row[:, None] * cols + col[None]).ravel()
    weight = known.ravel().astype(np.float64)
    metres = np.where(known, np.minimum(np.where(known, seen, 0), FAR_M), 0).ravel()
    count, size = rows * cols, np.bincount(part, minlength=rows * cols)
    valid = np.bincount(part, weight, count)
    mean = np.bincount(part, metres, count) / np.maximum(valid, 1)
    planes = np.stack((mean, valid / np.maximum(size, 1)))
    return planes.reshape(2, rows, cols).astype(np.float32)


def halved(values: F32) -> F16:
    """In half precision; what is larger than it has becomes the largest that it has."""
    most = float(np.finfo(np.float16).max)
    return np.clip(values, -most, most).astype(np.float16)


def way_of(
    cells_xy: F64, pose: Pose, mount: Mount, k: Intrinsics, rows: int, cols: int
) -> tuple[float, float]:
    """Cells (N, 2) m of the map, a keyframe's pose and camera -> where their middle stands in it:
    column of the letterboxed image, 0 left to 1 right; how far on the floor, m."""
    x, y = cells_xy.mean(axis=0)
    at = map_to_optical(np.array([[x, y, mount.z_m]]), pose, mount)
    at[:, 2] = np.maximum(at[:, 2], NEAREST_M)
    u_px = float(project(at, k)[0, 0])
    return column_of(u_px, k, rows, cols), float(np.hypot(x - pose.x_m, y - pose.y_m))


def column_of(u_px: float, k: Intrinsics, rows: int, cols: int) -> float:
    """An image column, px -> where it stands in the letterboxed image, 0 left to 1 right."""
    return float(
        np.clip(0.5 + (u_px / k.width - 0.5) * _share(k.width, k.height, cols, rows), 0, 1)
    )


def _share(length: float, other: float, parts: int, others: int) -> float:
    """Of one side of the letterboxed image, how much the image fills."""
    return min(1.0, length / other * others / parts)


def _part(at: Index, length: int, other: int, parts: int, others: int) -> Index:
    """Pixels along one side -> which of the `parts` each lies in."""
    centred = 0.5 + ((at + 0.5) / length - 0.5) * _share(length, other, parts, others)
    return np.minimum((centred * parts).astype(np.intp), parts - 1)
