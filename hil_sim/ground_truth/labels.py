"""Detection labels from a rendered segmentation: boxes, visible pixels, what to ignore."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import CATEGORIES, Scene, room_at
from hil_sim.scenes.furniture.boxes import Box

LABELLED = tuple(name for name in CATEGORIES if name not in ("other", "door"))
LEAST_PIXELS = 200
"""Of a 640x480 frame; of a smaller one as many fewer."""
FULL_PX = 640 * 480
"""Pixels are counted as in a frame of this size."""
LEAST_SIDE_PX = 6
LEAST_VISIBLE = 0.3
FILL = 0.6
"""Share of a box's silhouette that the object inside typically covers."""
OWN_ROOM_SHARE = 0.5


@dataclass(frozen=True)
class CameraView:
    """Where a frame was taken: scene frame, metres, radians; pitch up is positive."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    pitch_rad: float
    hfov_rad: float


@dataclass(frozen=True)
class Label:
    """A visible object: box (x, y, width, height) px, visible pixels, whether to ignore it."""

    category: str
    bbox: tuple[int, int, int, int]
    area: int
    ignore: bool


def labels(
    scene: Scene,
    boxes: list[Box],
    view: CameraView,
    depth: NDArray[np.float32],
    segmentation: NDArray[np.int32],
) -> list[Label]:
    """Labels of all objects with a visible pixel.

    depth (H, W) m along the optical axis; segmentation (H, W) index into scene.objects or -1.
    """
    found = []
    height, width = segmentation.shape
    counts = np.bincount(segmentation[segmentation >= 0], minlength=len(scene.objects))
    for index in np.flatnonzero(counts):
        category = scene.objects[index].category
        if category not in LABELLED:
            continue
        mask = segmentation == index
        rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        x0, x1, y0, y1 = int(cols[0]), int(cols[-1]) + 1, int(rows[0]), int(rows[-1]) + 1
        area = int(counts[index])
        cut = x0 == 0 or y0 == 0 or x1 == width or y1 == height
        least = LEAST_PIXELS * segmentation.size / FULL_PX * (4 if cut else 1)
        small = area < least or min(x1 - x0, y1 - y0) < LEAST_SIDE_PX
        share = _visible_share(boxes[index], view, depth, mask)
        found.append(
            Label(category, (x0, y0, x1 - x0, y1 - y0), area, small or share < LEAST_VISIBLE)
        )
    return found


def _visible_share(
    box: Box, view: CameraView, depth: NDArray[np.float32], mask: NDArray[np.bool_]
) -> float:
    """Visible pixels against those that something nearer hides inside its silhouette."""
    height, width = mask.shape
    corners = np.vstack([np.c_[box.corners(), np.full(4, z)] for z in (box.z0, box.z1)])
    points = to_optical(corners, view)
    if points[:, 2].min() < 0.1:
        return 1.0  # so close that nothing fits in between
    focal = width / 2 / math.tan(view.hfov_rad / 2)
    pixels = points[:, :2] / points[:, 2:] * focal + (width / 2, height / 2)
    hull = cv2.convexHull(np.round(pixels).astype(np.int32))
    silhouette = np.zeros(mask.shape, np.uint8)
    cv2.fillConvexPoly(silhouette, hull, 1)
    nearer = (depth > 0) & (depth < points[:, 2].min() + 0.02) & ~mask & (silhouette > 0)
    visible, hidden = int(mask.sum()), int(nearer.sum()) * FILL
    return visible / (visible + hidden)


def to_optical(points: NDArray[np.float64], view: CameraView) -> NDArray[np.float64]:
    """(N, 3) scene points -> (N, 3) in the camera's optical frame (x right, y down, z ahead)."""
    d = points - (view.x_m, view.y_m, view.z_m)
    c, s = math.cos(view.yaw_rad), math.sin(view.yaw_rad)
    ahead, left = d[:, 0] * c + d[:, 1] * s, -d[:, 0] * s + d[:, 1] * c
    cp, sp = math.cos(view.pitch_rad), math.sin(view.pitch_rad)
    forward, up = ahead * cp + d[:, 2] * sp, -ahead * sp + d[:, 2] * cp
    return np.stack([-left, -up, forward], axis=1)


def seen_room(scene: Scene, view: CameraView, depth: NDArray[np.float32]) -> str:
    """The type of the room the camera stands in, or "" when the view is of another one."""
    own = room_at(scene, view.x_m, view.y_m)
    if own is None:
        return ""
    height, width = depth.shape
    focal = width / 2 / math.tan(view.hfov_rad / 2)
    rows, cols = np.mgrid[height // 32 : height : height // 16, width // 40 : width : width // 20]
    z = np.maximum(depth[rows, cols].ravel().astype(float) - 0.15, 0.0)
    right = (cols.ravel() + 0.5 - width / 2) / focal * z
    c, s = math.cos(view.yaw_rad), math.sin(view.yaw_rad)
    x, y = view.x_m + z * c + right * s, view.y_m + z * s - right * c
    inside = [room_at(scene, px, py) is own for px, py in zip(x, y, strict=True)]
    return own.type if float(np.mean(inside)) >= OWN_ROOM_SHARE else ""
