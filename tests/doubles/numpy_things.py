"""What `kernels.things` and its like compute, by NumPy and OpenCV, a step at a time: what they are
to equal."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from runtime.core.geometry import GridFrame, rays
from runtime.core.objects.depth_segments import (
    BEFORE_M,
    BEFORE_SHARE,
    CEILING_M,
    CLUSTER_M,
    CORE_SHARE,
    EDGE_M,
    EDGE_SHARE,
    FLOOR_M,
    KNOWN_SHARE,
    MIN_POINTS,
    NEAR_QUANTILE,
    RIM,
    SPAN_SHARE,
    STRIDE,
    WITHIN_SHARE,
    SeenThing,
)
from runtime.core.objects.footprints import LEAST_M, STRAY
from runtime.core.types import F32, F64, Mask, Mount, Observation, Pose

MOST_M = 100.0  # of a thing, along x and along y


def base_to_map(points: F64, pose: Pose) -> F64:
    """(N, 3) m in the base frame -> (N, 3) m in the map frame, each coordinate in one piece."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    x, y, z = points.T
    found = np.empty((3, len(points)))
    np.multiply(c, x, out=found[0])
    np.multiply(s, x, out=found[1])
    found[0] -= s * y
    found[1] += c * y
    found[:2] += ((pose.x_m,), (pose.y_m,))
    found[2] = z
    return found.T


def footprint(frame: GridFrame, xy: F64) -> F64:
    """(N, 2) m -> (M, 2) centres of the cells under them, each once, in scan order."""
    scaled = (xy - (frame.x0_m, frame.y0_m)) / frame.resolution_m
    cells = np.unique(np.floor(scaled[:, ::-1]).astype(np.int64), axis=0)[:, ::-1]
    return (cells + 0.5) * frame.resolution_m + (frame.x0_m, frame.y0_m)


def without_strays(cells_xy: F64) -> F64:
    """(N, 2) m -> those not much farther from the middle than most."""
    gap = cells_xy - np.median(cells_xy, axis=0)
    away, half = np.hypot(gap[:, 0], gap[:, 1]), len(cells_xy) // 2
    return cells_xy[away <= max(STRAY * float(np.sort(away)[half]), LEAST_M)]


def thing_of(range_m: float, points: F64, frame: GridFrame) -> SeenThing | None:
    """What points (N, 3) m in the map frame tell of a thing; None where they are too few, or
    farther apart than those of one."""
    if len(points) < MIN_POINTS or np.ptp(points[:, :2], axis=0).max() > MOST_M:
        return None
    x, y, z_m = np.median(points, axis=0).tolist()
    ordered, rim = np.sort(points[:, 2]).tolist(), len(points) // RIM
    cells = without_strays(footprint(frame, points[:, :2]))
    return SeenThing(range_m, (x, y), z_m, ordered[rim], ordered[len(points) - 1 - rim], cells)


@dataclass(frozen=True)
class View:
    """A depth image, every STRIDE-th pixel of it."""

    depth: F32  # (h, w) m, 0 for unknown
    points: F64  # (h, w, 3) m in the map frame
    label: np.ndarray  # (h, w) of surfaces, 0 for none
    size: np.ndarray  # (n,) pixels by label

    @classmethod
    def of(cls, obs: Observation, mount: Mount) -> "View":
        table, half = rays(obs.intrinsics, mount, STRIDE), STRIDE // 2
        depth = obs.depth_m[half::STRIDE, half::STRIDE]
        depth = np.where(np.isfinite(depth), depth, np.float32(0))
        axes = np.stack([table.forward, table.left, table.up], axis=-1).astype(np.float64)
        base = axes * depth[..., None].astype(np.float64) + (mount.x_m, mount.y_m, mount.z_m)
        points = base_to_map(base.reshape(-1, 3), obs.pose).reshape(*depth.shape, 3)
        high = depth * table.up + np.float32(mount.z_m)
        label, size = _surfaces(depth, high)
        return cls(depth, points, label, size)

    def distance_m(self, box: tuple[slice, slice]) -> float:
        """How far the thing in a box is; 0 where too little depth is known."""
        depth, label = self.depth[box], self.label[box]
        if np.count_nonzero(depth > 0) < KNOWN_SHARE * depth.size:
            return 0.0
        h, w = depth.shape
        dy, dx = int(h * (1 - CORE_SHARE) / 2), int(w * (1 - CORE_SHARE) / 2)
        core = slice(dy, h - dy), slice(dx, w - dx)
        known = depth[core][depth[core] > 0]
        if not known.size:
            return 0.0
        nearest_m = quantile(known)
        count = np.bincount(label[_as_far(depth, nearest_m)], minlength=1)
        count[0] = 0
        inside = np.bincount(label.ravel(), minlength=len(self.size)) >= WITHIN_SHARE * self.size
        if not count.any() or inside[count.argmax()]:
            return nearest_m
        largest, own = SPAN_SHARE * label.size, None
        for one in np.unique(label[label > 0]):
            rows, cols = np.nonzero(label == one)
            span = float(np.ptp(rows) + 1) * float(np.ptp(cols) + 1)
            if inside[one] and span >= largest:
                largest, own = span, label == one
        if own is None:
            return nearest_m
        middle = depth[core][own[core]]
        return quantile(middle if middle.size else depth[own])

    def points_in(self, box: tuple[slice, slice], near_m: float, wide: float) -> F64:
        """(N, 3) of the thing in a box that is so far away."""
        before_m = min(CLUSTER_M, max(BEFORE_M, BEFORE_SHARE * wide * near_m))
        depth, label, points = self.depth[box], self.label[box], self.points[box]
        high = points[..., 2]
        keep = (high > FLOOR_M) & (high < CEILING_M) & (depth > 0)
        keep &= (depth > near_m - before_m) & (depth < near_m + CLUSTER_M)
        attached = np.unique(label[_as_far(depth, near_m)])
        keep &= (depth > near_m - EDGE_M) | np.isin(label, attached[attached > 0])
        return points[keep]


def things_in(
    obs: Observation, boxes: F64, mount: Mount, frame: GridFrame
) -> list[SeenThing | None]:
    """As `depth_segments.things_in`."""
    view, found = View.of(obs, mount), []
    for top, left, bottom, right, known, wide in boxes.tolist():
        box = slice(int(top), int(bottom)), slice(int(left), int(right))
        near_m = view.distance_m(box) if math.isnan(known) else known
        points = view.points_in(box, near_m, wide)
        found.append(thing_of(near_m, points, frame))
    return found


def quantile(values: F32) -> float:
    """`np.quantile`, in single precision throughout."""
    at = (len(values) - 1) * NEAR_QUANTILE
    low = int(at)
    ordered = np.sort(values)
    below, above = ordered[low], ordered[min(low + 1, len(values) - 1)]
    part, step = np.float32(at - low), above - below
    return float(above - step * (1 - part) if part >= 0.5 else below + step * part)


def _surfaces(depth: F32, high: F32) -> tuple[np.ndarray, np.ndarray]:
    limit = np.maximum(EDGE_M, EDGE_SHARE * depth)
    inside = (depth > 0) & (high > FLOOR_M)
    inside[:, 1:] &= np.abs(depth[:, 1:] - depth[:, :-1]) <= limit[:, 1:]
    inside[1:] &= np.abs(depth[1:] - depth[:-1]) <= limit[1:]
    _, label = cv2.connectedComponents(inside.view(np.uint8), connectivity=4)
    return label, np.bincount(label.ravel())


def _as_far(depth: F32, near_m: float) -> Mask:
    return np.abs(depth - np.float32(near_m)) <= EDGE_M
