"""Windows of a grid, and polygons drawn into them."""

import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.mapping.grid import RESOLUTION_M, NavigationMap
from runtime.core.mapping.windows import (
    bounds,
    inside,
    joined,
    padded,
    polygon_mask,
    polygon_patch,
    widened,
)
from runtime.core.types import Pose

RADIUS = 0.18
START = Pose(3.0, 3.6, 0.0)


def test_a_polygon_covers_its_cells():
    grid = NavigationMap.around(Pose(0.0, 0.0, 0.0), RADIUS)
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert abs(polygon_mask(grid.frame, square).sum() * 0.0025 - 1.0) < 0.15


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.floats(-14, 14), st.floats(-14, 14)), min_size=3, max_size=8))
def test_a_patch_is_the_part_of_the_mask_that_holds_the_polygon(corners: list[tuple[float, float]]):
    grid, outline = NavigationMap.around(START, RADIUS), np.array(corners)
    patch, window = polygon_patch(grid.frame, outline)
    whole = np.zeros(grid.frame.shape, np.uint8)
    scaled = ((outline - (grid.frame.x0_m, grid.frame.y0_m)) / RESOLUTION_M - 0.5) * 16
    cv2.fillPoly(whole, [np.round(scaled).astype(np.int32)], 1, shift=4)
    assert (patch == whole[window].astype(bool)).all()
    assert patch.sum() == whole.sum()


@given(st.integers(0, 2**32 - 1))
def test_a_window_holds_what_it_bounds_and_is_part_of_a_wider_one(seed: int):
    rng = np.random.default_rng(seed)
    frame = NavigationMap.around(START, RADIUS).frame
    mask = np.zeros(frame.shape, bool)
    mask[tuple(rng.integers(0, frame.rows, (2, 3)))] = True
    tight = bounds(mask, (slice(0, frame.rows), slice(0, frame.cols)))
    assert mask[tight].sum() == mask.sum()
    assert mask[tight][0].any()
    assert mask[tight][:, -1].any()
    wider = joined(widened(tight, 5, frame), (slice(0, 1), slice(0, 1)))
    assert (mask[wider][inside(tight, wider)] == mask[tight]).all()


def test_what_is_padded_keeps_its_place_among_zeros():
    array = np.arange(1, 13).reshape(2, 2, 3)
    wider = padded(array, (1, 2, 3, 0))
    assert (wider == np.pad(array, ((0, 0), (1, 2), (3, 0)))).all()
    assert wider.dtype == array.dtype
