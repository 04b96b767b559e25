"""Letterboxing and suppression."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.detection.boxes import Scaling, letterbox, scaled, suppress

sides = st.integers(1, 700)


def test_channels_are_turned_round_before_each_is_scaled() -> None:
    image = np.full((2, 3, 3), (10, 20, 30), np.uint8)
    planes = scaled(image, Scaling(True, (1.0, 2.0, 3.0), (1.0, 2.0, 4.0)))
    assert (planes.shape, planes.dtype) == ((3, 2, 3), np.float32)
    assert planes[:, 0, 0] == pytest.approx([29.0, 9.0, 1.75])


@given(sides, sides)
def test_a_box_survives_the_letterbox(height: int, width: int) -> None:
    image, fit = letterbox(np.zeros((height, width, 3), np.uint8), 320, 416)
    assert image.shape == (320, 416, 3)
    inside = np.array([[0, 0, width, height]], np.float32)
    moved = inside * fit.scale + np.array([fit.left, fit.top] * 2, np.float32)
    back = fit.undo(moved.astype(np.float32), height, width)
    np.testing.assert_allclose(back, inside, atol=0.01)


def test_a_covered_box_of_the_same_class_is_dropped() -> None:
    boxes = np.array([[0, 0, 100, 100], [5, 5, 100, 100], [200, 0, 300, 100]], np.float32)
    scores = np.array([0.6, 0.9, 0.3], np.float32)
    same = np.zeros(3, np.int32)
    assert suppress(boxes, scores, same, 0.5, 0.95).tolist() == [1, 2]
    other = np.array([0, 1, 0], np.int32)
    assert suppress(boxes, scores, other, 0.5, 0.95).tolist() == [1, 0, 2]
    assert suppress(boxes, scores, other, 0.5, 0.8).tolist() == [1, 2]


@pytest.mark.parametrize("count", [0, 1])
def test_nothing_to_suppress(count: int) -> None:
    boxes = np.zeros((count, 4), np.float32)
    kept = suppress(boxes, np.ones(count, np.float32), np.zeros(count, np.int32), 0.5, 0.5)
    assert len(kept) == count
