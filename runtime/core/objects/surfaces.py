"""Where in an image things stand on tables, shelves and counters: worth a closer look for what is
small."""

import cv2
import numpy as np

from runtime.core.geometry import rays
from runtime.core.types import Mount, Observation

STRIDE = 4  # every n-th pixel
SHARE = 0.625  # of the image's sides, the window's
ABOVE_FLOOR_M = (0.25, 1.4)  # heights of surfaces that small things stand on
RANGE_M = (0.6, 3.5)  # beyond, even a closer look shows little
LEVEL = 0.25  # of the way along a column of the image that a level surface rises at most
OVER = 0.2  # of the image's height: what stands on a surface is seen above it
LEAST = 0.02  # of the window's pixels; fewer are not worth a look

Window = tuple[int, int, int, int]
"""x0, y0, x1, y1 in image px."""


def surfaces_window(obs: Observation, mount: Mount) -> Window | None:
    """The part of the image with most of level surfaces near by, and of what is just above them;
    None where there is hardly any."""
    table, half = rays(obs.intrinsics, mount, STRIDE), STRIDE // 2
    depth = np.nan_to_num(obs.depth_m[half::STRIDE, half::STRIDE], posinf=0.0)
    up = depth * table.up + np.float32(mount.z_m)
    rise = np.abs(np.diff(up, axis=0))
    run = np.abs(np.diff(depth, axis=0))
    level = np.zeros(depth.shape, np.float32)
    low, high = ABOVE_FLOOR_M
    near, far = RANGE_M
    level[1:] = (
        (rise < LEVEL * run) & (up[1:] > low) & (up[1:] < high) & (depth[1:] > near)
        & (depth[1:] < far) & (depth[:-1] > 0)
    )  # fmt: skip
    rows, cols = depth.shape
    over = round(OVER * rows)
    level[:-over] = np.maximum(level[:-over], level[over:])
    height, width = round(SHARE * rows), round(SHARE * cols)
    sums = cv2.integral(level)
    inside = (
        sums[height:, width:] - sums[:-height, width:] - sums[height:, :-width]
        + sums[:-height, :-width]
    )  # fmt: skip
    if inside.max() < LEAST * height * width:
        return None
    y, x = (int(v) * STRIDE for v in np.unravel_index(int(inside.argmax()), inside.shape))
    return x, y, x + width * STRIDE, y + height * STRIDE
