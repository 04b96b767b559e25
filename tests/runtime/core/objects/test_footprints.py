"""The cells under a thing, and those that only seem to be."""

import math

import cv2
import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy_things import footprint

from runtime.core.geometry import GridFrame
from runtime.core.objects.footprints import joined, length_bounds, middle

FRAME = GridFrame(-6.0, -6.0, 0.05, 240, 240)


def without_strays(cells: np.ndarray) -> np.ndarray:
    """Joined with no others."""
    both = joined(FRAME, cells, cells, settled=False)
    assert both is not None
    return both.cells_xy


def reach(some_xy: np.ndarray, all_xy: np.ndarray) -> float:
    return float(np.hypot(*(some_xy - np.median(all_xy, axis=0)).T).max())


@given(st.floats(0.1, 2.0), st.floats(0.1, 1.0), st.floats(-math.pi, math.pi))
@example(0.5, 0.109375, 0.125)
def test_all_of_a_rectangle_is_kept_and_a_spill_is_not(length: float, width: float, turn: float):
    """What spills out is a strip as long as the thing, two cells wide."""
    x, y = np.meshgrid(np.arange(0, length, 0.03), np.arange(0, width, 0.03))
    cos, sin = math.cos(turn), math.sin(turn)
    box = np.stack([x.ravel() * cos - y.ravel() * sin, x.ravel() * sin + y.ravel() * cos], axis=1)
    cells = footprint(FRAME, box)
    kept = without_strays(cells)
    assert len(kept) >= 0.9 * len(cells)  # a corner may be just grazed
    assert reach(kept, cells) > reach(cells, cells) - 0.0708  # a cell's diagonal
    long = max(length, width)
    along = np.arange(long, 2.5 * long + 0.5, 0.03)
    strip = np.stack([along * cos - 0.02 * sin, along * sin + 0.02 * cos], axis=1)
    spilt = footprint(FRAME, np.concatenate([box, strip]))
    if len(spilt) < 1.5 * len(cells):
        kept = without_strays(spilt)
        assert np.hypot(*kept.T).max() < np.hypot(*spilt.T).max() - 0.2


@given(arrays.arrays(np.float64, st.tuples(st.integers(1, 40), st.just(2)),
                     elements=st.floats(-9, 9)))  # fmt: skip
def test_the_middle_is_the_median(points: np.ndarray):
    assert middle(points) == tuple(np.median(points, axis=0))


def test_settled_cells_are_joined_with_what_is_new_alone():
    cells = footprint(FRAME, np.random.default_rng(0).uniform(-0.3, 0.3, (99, 2)))
    assert joined(FRAME, cells, cells[::2], settled=True) is None
    both = joined(FRAME, cells, cells + np.array([0.3, 0.0]), settled=True)
    assert both is not None
    assert both.whole
    assert both.xy == middle(both.cells_xy)
    assert {*map(tuple, cells)} < {*map(tuple, both.cells_xy)}


@given(arrays.arrays(np.float64, st.tuples(st.integers(1, 40), st.just(2)),
                     elements=st.floats(-9, 9)))  # fmt: skip
def test_the_longer_side_is_between_its_bounds(points: np.ndarray):
    low_m, high_m = length_bounds(points)
    _, sides, _ = cv2.minAreaRect(points.astype(np.float32))
    assert low_m <= max(sides) <= high_m
