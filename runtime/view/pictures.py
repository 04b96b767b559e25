"""A camera's images as small JPEGs, and what was seen in one, for pages."""

import struct
from collections.abc import Collection, Sequence
from typing import Any, Final

import cv2
import numpy as np

from runtime.core.types import U8
from runtime.errors import SensorError
from runtime.robot import drawn_messages, wire
from runtime.robot.images.reading import decode_color

LONGER_PX: Final = 640  # side of what is sent
QUALITY: Final = 70
BOXES_MOST: Final = 100
_HEAD: Final = struct.Struct("<BBHHQ")
_KIND, _VERSION = 2, 1


def camera_message(payload: bytes, topic: str, packed: bool) -> tuple[bytes, tuple[int, int]]:
    """An Image, or CompressedImage where it is `packed` -> what pages are sent, and the width and
    height of the robot's own image. SensorError, one line, for what cannot be read."""
    image = decode_color(payload, topic, packed)
    small = smaller(image.value)
    told, jpeg = cv2.imencode(
        ".jpg", cv2.cvtColor(small, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
    )
    if not told:
        raise SensorError(f"{topic}: {small.shape} cannot be a JPEG")
    head = _HEAD.pack(_KIND, _VERSION, small.shape[1], small.shape[0], image.stamp_ns)
    return head + jpeg.tobytes(), (image.value.shape[1], image.value.shape[0])


def smaller(rgb: U8) -> U8:
    """(H, W, 3), its longer side at most LONGER_PX."""
    high, wide = rgb.shape[:2]
    share = LONGER_PX / max(high, wide)
    if share >= 1:
        return rgb
    size = max(1, round(wide * share)), max(1, round(high * share))
    return np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA), np.uint8)


def boxes_message(payload: bytes, size: tuple[int, int], goal: str) -> dict[str, Any]:
    """A Detection2DArray -> what pages are told. `size`: of the image, width and height px."""
    told = wire.decode(payload, drawn_messages.DETECTIONS, "rfnav/detections")
    boxes = [_box(one, goal) for one in told.detections[:BOXES_MOST] if len(one.results)]
    stamp_ns = wire.header_stamp(told, "rfnav/detections")
    return {"stamp_ns": stamp_ns, "width": size[0], "height": size[1], "boxes": boxes}


def named_boxes(
    boxes_px: Any, scores: Any, names: Collection[str], goal: str
) -> list[dict[str, Any]]:
    """(N, 4) x0, y0, x1, y1 px, with their scores and names."""
    rows = zip(np.asarray(boxes_px).tolist(), np.asarray(scores).tolist(), names, strict=True)
    return [_told(box, score, name, goal) for box, score, name in rows][:BOXES_MOST]


def _box(one: Any, goal: str) -> dict[str, Any]:
    middle, guess = one.bbox.center.position, one.results[0].hypothesis
    wide, high = one.bbox.size_x, one.bbox.size_y
    x0, y0 = middle.x - wide / 2, middle.y - high / 2
    corners = x0, y0, x0 + wide, y0 + high
    return _told(corners, guess.score, guess.class_id, goal)


def _told(corners: Sequence[float], score: float, name: str, goal: str) -> dict[str, Any]:
    x0, y0, x1, y1 = corners
    px = {"x": x0, "y": y0, "w": x1 - x0, "h": y1 - y0}
    told = {side: round(float(value), 1) for side, value in px.items()}
    return {**told, "name": name, "score": round(float(score), 3), "goal": name == goal}
