"""The truth's labels of a frame, for methods that ask for them by name (`oracle-perception`,
`labels`)."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.ground_truth.labels import FULL_PX, LABELLED
from hil_sim.scenes.format import Scene, room_at
from runtime.core.types import Pose

LEAST_PIXELS = 100
"""Of a 640x480 frame; of a smaller one as many fewer."""


def pixels(segmentation: NDArray[np.int32], objects: int) -> NDArray[np.int64]:
    """(H, W) index into the scene's objects or -1 -> (objects,) how many pixels each has."""
    return np.bincount(segmentation[segmentation >= 0], minlength=objects)


def true_labels(
    scene: Scene, pose: Pose, segmentation: NDArray[np.int32], depth_m: NDArray[np.float32]
) -> dict[str, Any]:
    """(H, W) index into the scene's objects or -1, and the depth -> what a perfect detector would
    say: {"boxes": [[x0, y0, x1, y1], ...] px, "names", "scores", "depths_m": of the object's own
    pixels, "room": type or None}.

    The room is the one that the camera stands in.
    """
    per_px = FULL_PX / segmentation.size
    boxes, names, depths = [], [], []
    for index in np.flatnonzero(pixels(segmentation, len(scene.objects)) * per_px >= LEAST_PIXELS):
        category = scene.objects[index].category
        if category in LABELLED:
            x, y, w, h = cv2.boundingRect((segmentation == index).view(np.uint8))
            inside = segmentation[y : y + h, x : x + w] == index
            boxes.append([x, y, x + w, y + h])
            names.append(category)
            depths.append(round(float(np.median(depth_m[y : y + h, x : x + w][inside])), 3))
    room = room_at(scene, pose.x_m, pose.y_m)
    return {
        "boxes": boxes,
        "names": names,
        "scores": [1.0] * len(boxes),
        "depths_m": depths,
        "room": room.type if room is not None else None,
    }


def boxes_alone(labels: dict[str, Any]) -> dict[str, Any]:
    """Of `true_labels` the boxes and names, and nothing else that is true."""
    return {key: labels[key] for key in ("boxes", "names", "scores")} | {"room": None}
