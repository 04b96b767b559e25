"""By how much the base turned between two images: corners that are followed from one into the
other, and where they lie about the base by their depth."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import optical_to_base, wrap_angle
from runtime.core.types import F64, U8, Intrinsics, Mount
from runtime.doctor.hearing import Glimpse

CORNERS: Final = 200
LEAST: Final = 12  # corners that are found again, and agree
SAME_PX: Final = 1.0  # that a corner comes back to, followed there and back
SAME_M: Final = 0.1  # that a point is off, seen twice: depth is noisy
SAME_RAD: Final = 0.05  # the same, of its direction alone
MOST_S: Final = 1.0  # between two images that are compared
_WINDOW: Final = (21, 21)


@dataclass(frozen=True)
class SeenTurn:
    """From one image's stamp to the next, counter-clockwise, rad."""

    from_ns: int
    to_ns: int
    turn_rad: float


def seen_turns(glimpses: Sequence[Glimpse], intrinsics: Intrinsics, mount: Mount) -> list[SeenTurn]:
    """Between each image and the next, where enough is seen in both."""
    found = []
    for a, b in itertools.pairwise(glimpses):
        if 0 < b.stamp_ns - a.stamp_ns <= MOST_S * 1e9 and a.grey.shape == b.grey.shape:
            turn = seen_turn(a, b, intrinsics, mount)
            if turn is not None:
                found.append(SeenTurn(a.stamp_ns, b.stamp_ns, turn))
    return found


def seen_turn(a: Glimpse, b: Glimpse, intrinsics: Intrinsics, mount: Mount) -> float | None:
    """How far the base turned counter-clockwise from one image to the other, rad; None where too
    little is seen in both."""
    before, after = _followed(a.grey, b.grey)
    if len(before) < LEAST:
        return None
    rays = [_rays(pixels, a.grey.shape, intrinsics, mount) for pixels in (before, after)]
    if a.depth_m is not None and b.depth_m is not None:
        depths = [
            _at(g.depth_m, px) for g, px in ((a, before), (b, after)) if g.depth_m is not None
        ]
        known = (depths[0] > 0) & (depths[1] > 0)
        if known.sum() >= LEAST:
            offset = np.array([mount.x_m, mount.y_m])
            places = [
                offset + ray[known, :2] * depth[known, None]
                for ray, depth in zip(rays, depths, strict=True)
            ]
            turn = _by_places(places[0], places[1])
            if turn is not None:
                return turn
    return _by_directions(rays[0], rays[1])


def _followed(a: U8, b: U8) -> tuple[F64, F64]:
    """(N, 2) px each: corners of `a`, and where they are in `b`."""
    nothing: F64 = np.zeros((0, 2))
    corners = cv2.goodFeaturesToTrack(a, CORNERS, 0.01, 5)
    if corners is None:
        return nothing, nothing
    # A whole image that has moved far is out of reach of what follows single corners.
    window = cv2.createHanningWindow((a.shape[1], a.shape[0]), cv2.CV_32F)
    moved, _ = cv2.phaseCorrelate(a.astype(np.float32), b.astype(np.float32), window)
    guess = corners + np.array(moved, np.float32)
    flags = cv2.OPTFLOW_USE_INITIAL_FLOW
    there, found, _ = cv2.calcOpticalFlowPyrLK(
        a, b, corners, guess.copy(), winSize=_WINDOW, maxLevel=3, flags=flags
    )
    back, again, _ = cv2.calcOpticalFlowPyrLK(
        b, a, there, corners.copy(), winSize=_WINDOW, maxLevel=3, flags=flags
    )
    off = np.linalg.norm((back - corners).reshape(-1, 2), axis=1)
    height, width = b.shape
    at = there.reshape(-1, 2)
    inside = (at >= 0).all(axis=1) & (at[:, 0] <= width - 1) & (at[:, 1] <= height - 1)
    sure = (found.ravel() == 1) & (again.ravel() == 1) & (off < SAME_PX) & inside
    return corners.reshape(-1, 2)[sure].astype(np.float64), at[sure].astype(np.float64)


def _rays(pixels: F64, shape: tuple[int, ...], intrinsics: Intrinsics, mount: Mount) -> F64:
    """(N, 2) px of a small image -> (N, 3) per metre of depth, in the base's frame."""
    i, scale = intrinsics, intrinsics.width / shape[1]
    x = ((pixels[:, 0] + 0.5) * scale - i.cx) / i.fx
    y = ((pixels[:, 1] + 0.5) * scale - i.cy) / i.fy
    return np.asarray(
        np.stack([x, y, np.ones_like(x)], axis=1) @ optical_to_base(mount).T, np.float64
    )


def _at(depth_m: NDArray[np.float32], pixels: F64) -> F64:
    """(N,) m, 0 where unknown."""
    columns, rows = np.round(pixels).astype(int).T
    return np.asarray(depth_m[rows, columns], np.float64)


def _by_places(before: F64, after: F64) -> float | None:
    """(N, 2) m about the base, of the same things."""
    model, agree = cv2.estimateAffinePartial2D(
        before, after, method=cv2.RANSAC, ransacReprojThreshold=SAME_M
    )
    if model is None or agree.sum() < LEAST:
        return None
    scale = math.hypot(model[0, 0], model[1, 0])
    return -math.atan2(model[1, 0], model[0, 0]) if 0.8 < scale < 1.25 else None


def _by_directions(before: F64, after: F64) -> float | None:
    """(N, 3) rays; right for what is far away, and for a camera over the middle of the base."""
    headings = [np.arctan2(ray[:, 1], ray[:, 0]) for ray in (before, after)]
    turns = np.remainder(headings[0] - headings[1] + math.pi, math.tau) - math.pi
    middle = float(np.median(turns))
    agree = np.abs(turns - middle) < SAME_RAD
    return wrap_angle(float(turns[agree].mean())) if agree.sum() >= LEAST else None
