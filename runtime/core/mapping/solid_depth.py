"""Depth without flying pixels: where a pixel sees the edge of one thing and what is behind it, many
cameras read something between the two, in mid-air."""

from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.types import F32

REACH: Final = 2  # pixels to either side that a pixel is compared with: veils are one or two wide
JUMP_PER_M: Final = 0.02  # of inverse depth: more than noise explains; 2 cm at 1 m, 18 cm at 3 m
SAME_PER_M: Final = 0.005  # less than that from one pixel to the next: a surface, however narrow
_UNITS: Final = 1600  # of inverse depth to 1/m, so that it fits 16 bits
_NEAREST_M: Final = 0.2  # what is nearer counts as there

I16 = NDArray[np.int16]


def solid(depth_m: F32) -> F32:
    """(H, W) m along the optical axis, 0 or NaN where unknown -> a copy, 0 where a pixel flies.

    It does when it lies between what is to either side of it, far from both, with none like it
    next to it, and goes on to neither side as a plane would, whose inverse depth is linear in the
    image. What is nearer than both sides, such as a chair's leg, is left. Unknown counts as far.
    """
    inverse = np.zeros(depth_m.shape, np.float32)
    np.divide(_UNITS, np.maximum(depth_m, _NEAREST_M), out=inverse, where=depth_m > 0)
    nearness = inverse.astype(np.int16)
    inner, found = slice(2 * REACH, -2 * REACH), depth_m.copy()
    found[inner][_flies(nearness, 0)] = 0.0
    found[:, inner][_flies(nearness, 1)] = 0.0
    return found


def _flies(nearness: I16, axis: int) -> NDArray[np.bool_]:
    """(H, W) -> which do along an axis, but for 2 * REACH at either end of it."""

    def cut(array: NDArray[Any], start: int, stop: int) -> I16:
        kept = slice(start, array.shape[axis] - stop)
        part: I16 = array[kept] if axis == 0 else array[:, kept]
        return part

    n = REACH
    step = cv2.subtract(cut(nearness, n, 0), cut(nearness, 0, n))
    bend = cv2.absdiff(cut(step, n, 0), cut(step, 0, n))
    before, after = cut(step, n, 2 * n), cut(step, 2 * n, n)
    between = cv2.max(cv2.min(before, after), -cv2.max(before, after))
    off_line = cv2.min(cut(bend, 0, 2 * n), cut(bend, 2 * n, 0))
    next_to = cv2.absdiff(cut(nearness, 1, 0), cut(nearness, 0, 1))
    alone = cv2.min(cut(next_to, 2 * n - 1, 2 * n), cut(next_to, 2 * n, 2 * n - 1))
    jumps = np.asarray(cv2.min(between, off_line)) > round(JUMP_PER_M * _UNITS)
    return np.asarray(jumps & (alone > round(SAME_PER_M * _UNITS)), np.bool_)
