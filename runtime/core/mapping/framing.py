"""Where a frontier is in a keyframe's image: told, and marked."""

import cv2
import numpy as np

from runtime.core.geometry import map_to_optical, project
from runtime.core.types import F64, U8, InImage, Intrinsics, Mount, Pose

NEAREST_M = 0.1  # before the camera; what is nearer, or behind it, is not in its image
QUALITY = 85  # of a JPEG
EDGE_PX = 8  # a mark is so far inside the image


def framed(cells_xy: F64, pose: Pose, mount: Mount, k: Intrinsics) -> InImage | None:
    """Where the middle of a frontier's cells, (N, 2) m on the map's floor, is in an image; None
    when it is behind the camera."""
    points = np.column_stack((cells_xy, np.zeros(len(cells_xy))))
    optical = map_to_optical(points, pose, mount)
    optical = optical[optical[:, 2] > NEAREST_M]
    if not len(optical):
        return None
    u, v = np.median(project(optical, k), axis=0) + 0.5  # a pixel's middle has whole coordinates
    x, y = cells_xy.mean(axis=0)
    column, row = (float(np.clip(at, 0.0, 1.0)) for at in (u / k.width, v / k.height))
    return InImage(column, row, float(np.hypot(x - pose.x_m, y - pose.y_m)))


def jpeg(rgb: U8) -> bytes:
    """(H, W, 3) as a JPEG file, or b"" of none."""
    if not rgb.size:
        return b""
    ok, data = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return data.tobytes() if ok else b""


def marked(image: bytes, at: InImage | None) -> bytes:
    """A JPEG file with a red dot with a white rim where a frontier is, or as it is where that is
    not in it."""
    bgr = cv2.imdecode(np.frombuffer(image, np.uint8), cv2.IMREAD_COLOR) if image and at else None
    if bgr is None or at is None:
        return image
    height, width = bgr.shape[:2]
    x = round(float(np.clip(at.column * width - 0.5, EDGE_PX, width - 1 - EDGE_PX)))
    y = round(float(np.clip(at.row * height - 0.5, EDGE_PX, height - 1 - EDGE_PX)))
    for radius, colour in ((7, (255, 255, 255)), (5, (0, 0, 255))):
        cv2.circle(bgr, (x, y), radius, colour, -1, cv2.LINE_AA)
    return jpeg(np.asarray(bgr[..., ::-1], np.uint8))
