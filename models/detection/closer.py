"""A closer look: a part of an image at full resolution, and what is found there put back."""

import numpy as np
from numpy.typing import NDArray

from models.detection.detections import Floats, RawDetections, select, unembedded
from models.detection.detector import DetectorView

EDGE_PX = 2.0
"""What ends so near to the part's edge goes on beyond it."""
LARGEST = 0.5
"""Of the part's longer side: what is larger is seen well enough in the whole image."""

Window = tuple[int, int, int, int]
"""x0, y0, x1, y1 in image px."""


def part(rgb: NDArray[np.uint8], window: Window) -> NDArray[np.uint8]:
    """(H, W, 3) -> the window's pixels, as far as the image has them."""
    x0, y0, x1, y1 = window
    return np.ascontiguousarray(rgb[y0:y1, x0:x1])


def whole(boxes: Floats, window: Window) -> NDArray[np.bool_]:
    """(N, 4) px of the part -> (N,) which are small and not cut off by its edges."""
    size = np.array([window[2] - window[0], window[3] - window[1]], np.float32)
    inside = (boxes[:, :2] > EDGE_PX).all(axis=1) & (boxes[:, 2:] < size - EDGE_PX).all(axis=1)
    small = (boxes[:, 2:] - boxes[:, :2]).max(axis=1, initial=0) < LARGEST * size.max()
    return np.asarray(inside & small, np.bool_)


def joined_views(view: DetectorView, near: DetectorView, window: Window) -> DetectorView:
    """A view of the image with what a view of its part adds."""
    kept = whole(near.boxes_px, window)
    return DetectorView(
        np.concatenate((view.boxes_px, near.boxes_px[kept] + _shift(window))),
        np.concatenate((view.objectness, near.objectness[kept])),
        np.concatenate((view.regions, near.regions[kept])),
        view.scene,
        view.features,
    )


def joined(found: RawDetections, near: RawDetections, window: Window) -> RawDetections:
    """Detections of the image with what those of its part add; boxes alone."""
    kept = whole(near.boxes_px, window)
    boxes = np.concatenate((found.boxes_px, near.boxes_px[kept] + _shift(window)))
    scores = np.concatenate((found.scores, near.scores[kept]))
    labels = np.concatenate((found.labels, near.labels[kept]))
    best = select(boxes, scores, labels, across=1.0)
    both = unembedded(boxes[best], scores[best], labels[best])
    return both._replace(rooms=found.rooms, scene=found.scene, features=found.features)


def _shift(window: Window) -> Floats:
    return np.array([*window[:2], *window[:2]], np.float32)
