"""How far away the object in a box is: its surface lies within the box, while what hides a part of
it, or is behind it, mostly goes on beyond."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.types import F32, I32, Mask

Labels = NDArray[np.intp]  # what numpy indexes and counts by without a copy

CORE_SHARE = 0.6  # of a box's width and height, where its depth is read,
NEAR_QUANTILE = 0.3  # of the depths there: the nearest substantial surface
EDGE_M = 0.1  # between two neighbours' depths, from which on surfaces meet there,
EDGE_SHARE = 0.05  # or that share of the depth
FLOOR_M = 0.05  # what is lower is floor, and of no surface
WITHIN_SHARE = 0.9  # a surface with less of it than this in a box goes on beyond it,
SPAN_SHARE = 0.1  # then one is the object's that does not, and spans so much of the box

_SIDES = [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]


class Surfaces(NamedTuple):
    """What hangs together in a depth image: `label` (h, w), 0 for edges, floor and nothing;
    of each label, (n,): `size` in pixels, and `span`, pixels of the rectangle round it."""

    label: Labels
    size: I32
    span: I32


def segment(depth_m: F32, high_m: F32) -> Surfaces:
    """Depth (h, w) m, 0 for unknown, and the height (h, w) m of what is seen there."""
    limit = np.maximum(EDGE_M, EDGE_SHARE * depth_m)
    inside = (depth_m > 0) & (high_m > FLOOR_M)
    inside[:, 1:] &= np.abs(depth_m[:, 1:] - depth_m[:, :-1]) <= limit[:, 1:]
    inside[1:] &= np.abs(depth_m[1:] - depth_m[:-1]) <= limit[1:]
    _, label, found, _ = cv2.connectedComponentsWithStats(inside.view(np.uint8), connectivity=4)
    stats: I32 = np.asarray(found, np.int32)
    size, span = stats[:, cv2.CC_STAT_AREA], np.prod(stats[:, _SIDES], axis=1, dtype=np.int32)
    return Surfaces(np.asarray(label, np.intp), size, span)


def distance_m(depth_m: F32, label: Labels, size: I32, span: I32) -> float:
    """Of a box's patch (h, w) of depth and of `Surfaces.label`: how far its object is, m; 0 where
    no depth is known. That is the nearest substantial surface in the middle of the box or, where
    that one goes on beyond, the one within the box that spans most of it, if there is one."""
    core = _core(depth_m.shape)
    known = depth_m[core]
    known = known[known > 0]
    if not known.size:
        return 0.0
    nearest_m = quantile(known, NEAR_QUANTILE)
    nearest = _most(label[_as_far(depth_m, nearest_m)])
    if not nearest or np.count_nonzero(label == nearest) >= WITHIN_SHARE * size[nearest]:
        return nearest_m
    count = np.bincount(label.ravel())
    # One that spans too little of the image spans no more of the box.
    wide = np.flatnonzero((count > 0) & (span[: len(count)] >= SPAN_SHARE * label.size))
    own = _spanning(label, wide[count[wide] >= WITHIN_SHARE * size[wide]])
    if own is None:
        return nearest_m
    middle = depth_m[core][own[core]]
    return quantile(middle if middle.size else depth_m[own], NEAR_QUANTILE)


def quantile(values: F32, share: float) -> float:
    """`np.quantile`, of (N,) alone and in a tenth of the time."""
    at = (len(values) - 1) * share
    low = int(at)
    high = min(low + 1, len(values) - 1)
    ordered = np.partition(values, (low, high))
    below, above, part = ordered[low], ordered[high], np.float32(at - low)
    step = above - below
    return float(above - step * (1 - part) if part >= 0.5 else below + step * part)


def _most(label: Labels) -> int:
    """The commonest label but 0, of equals the lowest; 0 where there is none."""
    if not label.size:
        return 0
    count = np.bincount(label)
    count[0] = 0
    return int(count.argmax())


def _as_far(depth_m: F32, near_m: float) -> Mask:
    """What is as far away as `near_m`."""
    gap = depth_m - np.float32(near_m)
    mask: Mask = np.abs(gap, out=gap) <= EDGE_M
    return mask


def attached(depth_m: F32, label: Labels, near_m: float) -> Mask:
    """Of a box's patch (h, w): (n,) by label, as far as the patch has any, whether it hangs
    together with something as far away as `near_m`."""
    wanted = np.zeros(int(label.max(initial=0)) + 1, bool)
    wanted[label[_as_far(depth_m, near_m)]] = True
    wanted[0] = False
    return wanted


def _spanning(label: Labels, candidates: Labels) -> Mask | None:
    """The mask (h, w) of the candidate whose extent is the largest, if it spans enough."""
    largest, found = SPAN_SHARE * label.size, None
    for one in candidates[candidates > 0]:
        own = label == one
        rows, cols = np.flatnonzero(own.any(axis=1)), np.flatnonzero(own.any(axis=0))
        extent = float(np.ptp(rows) + 1) * float(np.ptp(cols) + 1)
        if extent >= largest:
            largest, found = extent, own
    return found


def _core(shape: tuple[int, ...]) -> tuple[slice, slice]:
    """The middle of a box."""
    h, w = shape
    dy, dx = int(h * (1 - CORE_SHARE) / 2), int(w * (1 - CORE_SHARE) / 2)
    return slice(dy, h - dy), slice(dx, w - dx)
