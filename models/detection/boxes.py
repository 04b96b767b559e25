"""Images into a network's frame, boxes back out of it, and the choice among overlapping boxes."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
GREY = 114


class Scaling(NamedTuple):
    """What is made of a frame's 0..255: channels turned round, then (value - mean) / deviation."""

    bgr: bool
    mean: tuple[float, float, float]
    deviation: tuple[float, float, float]


class Letterbox(NamedTuple):
    """How an image was fitted: network px = image px * scale + (left, top)."""

    scale: float
    left: int
    top: int

    def undo(self, boxes: Floats, height: int, width: int) -> Floats:
        """(N, 4) network px -> image px, clipped to the image."""
        shift = np.array([self.left, self.top] * 2, np.float32)
        limit = np.array([width, height] * 2, np.float32)
        inside = np.clip((boxes - shift) / np.float32(self.scale), 0, limit)
        return np.asarray(inside, np.float32)


class Stretch(NamedTuple):
    """How an image was fitted without its aspect: network px = image px * (x, y)."""

    x: float
    y: float

    def undo(self, boxes: Floats, height: int, width: int) -> Floats:
        """(N, 4) network px -> image px, clipped to the image."""
        limit = np.array([width, height] * 2, np.float32)
        scale = np.array([self.x, self.y] * 2, np.float32)
        return np.asarray(np.clip(boxes / scale, 0, limit), np.float32)


def stretch(rgb: NDArray[np.uint8], height: int, width: int) -> tuple[NDArray[np.uint8], Stretch]:
    """(h, w, 3) -> (height, width, 3), nothing added."""
    rows, columns = rgb.shape[:2]
    how = cv2.INTER_AREA if min(height / rows, width / columns) < 0.5 else cv2.INTER_LINEAR
    fitted = cv2.resize(rgb, (width, height), interpolation=how)
    return np.asarray(fitted, np.uint8), Stretch(width / columns, height / rows)


def letterbox(
    rgb: NDArray[np.uint8], height: int, width: int, centred: bool = True
) -> tuple[NDArray[np.uint8], Letterbox]:
    """(h, w, 3) -> (height, width, 3), aspect kept, the rest grey."""
    rows, columns = rgb.shape[:2]
    scale = min(height / rows, width / columns)
    size = (max(1, min(width, round(columns * scale))), max(1, min(height, round(rows * scale))))
    # Sampled as training frames are; an average over areas takes ten times as long, and gains only
    # where much is thrown away.
    how = cv2.INTER_AREA if scale < 0.5 else cv2.INTER_LINEAR
    small = cv2.resize(rgb, size, interpolation=how)
    left = (width - size[0]) // 2 if centred else 0
    top = (height - size[1]) // 2 if centred else 0
    canvas = np.full((height, width, 3), GREY, np.uint8)
    canvas[top : top + size[1], left : left + size[0]] = small
    return canvas, Letterbox(scale, left, top)


def scaled(rgb: NDArray[np.uint8], scaling: Scaling) -> Floats:
    """(H, W, 3) -> (3, H, W) as a network takes it."""
    planes = rgb.transpose(2, 0, 1).astype(np.float32)
    mean, deviation = (
        np.array(each, np.float32).reshape(3, 1, 1) for each in (scaling.mean, scaling.deviation)
    )
    planes = ((planes[::-1] if scaling.bgr else planes) - mean) / deviation
    return np.ascontiguousarray(planes, np.float32)


def suppress(
    boxes: Floats, scores: Floats, labels: NDArray[np.int32], overlap: float, across: float
) -> NDArray[np.int64]:
    """Indices kept, best first: greedy suppression of boxes that overlap a better one.

    `overlap` is the IoU allowed within a class, `across` between classes. Ties go to the lower
    index.
    """
    order = np.argsort(-scores, kind="stable")
    ranked = boxes[order]
    same = labels[order][:, None] == labels[order][None]
    better, worse = np.nonzero(np.triu(same | (across < 1), 1))
    limit = np.where(same[better, worse], overlap, across)
    clash = iou(ranked[better], ranked[worse]) > limit
    alive = np.ones(len(order), np.bool_)
    # By rank of the better one, so that whether it is alive is settled when its turn comes.
    for i, j in zip(better[clash].tolist(), worse[clash].tolist(), strict=True):
        if alive[i]:
            alive[j] = False
    return order[alive]


def pairwise_iou(a: Floats, b: Floats) -> Floats:
    """(N, 4), (M, 4) corners -> (N, M)."""
    return iou(a[:, None], b[None])


def iou(a: Floats, b: Floats) -> Floats:
    """(..., 4), (..., 4) corners -> (...), shapes broadcast."""
    low = np.maximum(a[..., :2], b[..., :2])
    high = np.minimum(a[..., 2:], b[..., 2:])
    shared = np.clip(high - low, 0, None).prod(-1)
    area_a = (a[..., 2:] - a[..., :2]).prod(-1)
    area_b = (b[..., 2:] - b[..., :2]).prod(-1)
    shares: Floats = shared / np.maximum(area_a + area_b - shared, 1e-9)
    return shares
