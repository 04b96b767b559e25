"""Images and boxes as pages get them."""

import struct

import cv2
import numpy as np
import pytest

from runtime.core.types import Detections
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.drawn_messages import Stamp, encode_detections
from runtime.view.pictures import LONGER_PX, boxes_message, camera_message, named_boxes, smaller

SEEN = Detections(
    np.array([[10.0, 20.0, 30.0, 60.0], [0.0, 0.0, 5.0, 5.0]], np.float32),
    np.array([0.9, 0.25], np.float32),
    np.array([1, 0], np.int32),
    np.zeros((2, 0), np.float32),
    np.zeros(0, np.float32),
)


def test_an_image_keeps_its_colours_and_says_when_it_was():
    rgb = np.zeros((480, 640, 3), np.uint8)
    rgb[:, :320] = 200, 30, 40
    message, size = camera_message(wire.encode_color(rgb, 77), "color", False)
    assert size == (640, 480)
    assert struct.unpack_from("<BBHHQ", message) == (2, 1, 640, 480, 77)
    bgr = cv2.imdecode(np.frombuffer(message[14:], np.uint8), cv2.IMREAD_COLOR)
    assert bgr is not None
    assert np.abs(bgr[240, 100].astype(int) - (40, 30, 200)).max() < 6


@pytest.mark.parametrize("shape", [(1080, 1920, 3), (1920, 1080, 3), (8, 4000, 3)])
def test_a_large_one_is_made_smaller_whole(shape: tuple[int, int, int]):
    small = smaller(np.zeros(shape, np.uint8))
    assert max(small.shape) == LONGER_PX
    assert min(small.shape[:2]) >= 1


def test_what_is_no_image_is_told_in_a_line():
    with pytest.raises(SensorError, match="color"):
        camera_message(b"\x00\x01\x00\x00", "color", False)


def test_boxes_are_told_with_what_is_looked_for():
    payload = encode_detections(SEEN, ("chair", "mug"), Stamp(5, "camera"))
    told = boxes_message(payload, (640, 480), "mug")
    assert (told["stamp_ns"], told["width"], told["height"]) == (5, 640, 480)
    mug = {"x": 10.0, "y": 20.0, "w": 20.0, "h": 40.0, "name": "mug", "score": 0.9, "goal": True}
    assert told["boxes"][0] == mug
    assert named_boxes(SEEN.boxes_px, SEEN.scores, ["mug", "chair"], "mug") == told["boxes"]
