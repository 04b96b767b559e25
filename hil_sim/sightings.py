"""The truth's labels of a frame, for methods that ask for them by name (`oracle-perception`)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hil_sim.labels import FULL_PX, LABELLED
from hil_sim.scene import Scene, room_at
from runtime.core.types import Pose

LEAST_PIXELS = 100
"""Of a 640x480 frame; of a smaller one as many fewer."""


def true_labels(
    scene: Scene, pose: Pose, segmentation: NDArray[np.int32], depth_m: NDArray[np.float32]
) -> dict[str, Any]:
    """(H, W) index into the scene's objects or -1, and the depth -> what a perfect detector would
    say: {"boxes": [[x0, y0, x1, y1], ...] px, "names", "scores", "depths_m": of the object's own
    pixels, "room": type or None}.

    The room is the one that the camera stands in.
    """
    flat = segmentation[segmentation >= 0]
    counts = np.bincount(flat, minlength=len(scene.objects))
    boxes, names, depths = [], [], []
    for index in np.flatnonzero(counts * (FULL_PX / segmentation.size) >= LEAST_PIXELS):
        category = scene.objects[index].category
        if category in LABELLED:
            mask = segmentation == index
            rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
            boxes.append([int(cols[0]), int(rows[0]), int(cols[-1]) + 1, int(rows[-1]) + 1])
            names.append(category)
            depths.append(round(float(np.median(depth_m[mask])), 3))
    room = room_at(scene, pose.x_m, pose.y_m)
    return {
        "boxes": boxes,
        "names": names,
        "scores": [1.0] * len(boxes),
        "depths_m": depths,
        "room": room.type if room is not None else None,
    }
