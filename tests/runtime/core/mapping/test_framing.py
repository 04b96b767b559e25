"""Where a frontier is in an image: told in shares of it, and marked."""

import cv2
import numpy as np
import pytest

from runtime.core.mapping.framing import framed, jpeg, marked
from runtime.core.types import InImage, Intrinsics, Mount, Pose

K = Intrinsics(160.0, 160.0, 160.0, 120.0, 320, 240)
CELLS = np.array([[2.0, 0.4], [2.0, 0.6]])


def test_where_the_floor_is_seen() -> None:
    at = framed(CELLS, Pose(0.0, 0.0, 0.0), Mount(), K)
    assert at is not None
    # 2 m ahead, 0.5 m to the left, on the floor 0.88 m below the camera
    assert (at.column, at.row) == pytest.approx((0.5 - 0.125, 0.5 + 0.44 * 160 / 240))
    assert at.range_m == pytest.approx(np.hypot(2.0, 0.5))
    assert framed(CELLS, Pose(0.0, 0.0, 3.1), Mount(), K) is None
    far_left = framed(CELLS + np.array([0.0, 9.0]), Pose(0.0, 0.0, 0.0), Mount(), K)
    assert far_left is not None
    assert far_left.column == 0.0


def test_a_mark_is_where_the_frontier_is() -> None:
    plain = jpeg(np.full((240, 320, 3), 128, np.uint8))
    drawn = cv2.imdecode(np.frombuffer(marked(plain, InImage(0.25, 1.0, 2.0)), np.uint8), 1)
    red = np.argwhere((drawn[..., 2] > 180) & (drawn[..., 1] < 90))
    assert red.mean(axis=0) == pytest.approx([231, 80], abs=2.0)
    assert marked(plain, None) == plain
    assert marked(b"", InImage(0.5, 0.5, 1.0)) == b""
    assert marked(b"no picture", InImage(0.5, 0.5, 1.0)) == b"no picture"
    assert jpeg(np.zeros((0, 0, 3), np.uint8)) == b""
