"""How far the object in a box is, where something hides a part of it or shows through it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from runtime.core.objects.depth_segments import (
    NEAR_QUANTILE,
    attached,
    distance_m,
    quantile,
    segment,
)

WALL_M, SHAPE = 4.0, (60, 80)
BOX = slice(10, 40), slice(20, 60)  # rows, columns


def picture(*things: tuple[slice, slice, float]) -> np.ndarray:
    """A wall, and in front of it rectangles at a depth, m, the later before the earlier."""
    depth = np.full(SHAPE, WALL_M, np.float32)
    for rows, cols, depth_m in things:
        depth[rows, cols] = depth_m
    return depth


def found_m(depth: np.ndarray, high_m: float = 1.0) -> float:
    label, size, span = segment(depth, np.full(SHAPE, high_m, np.float32))
    return distance_m(depth[BOX], label[BOX], size, span)


def test_what_hides_a_part_and_goes_on_beyond_the_box_is_not_the_object():
    television = slice(10, 40), slice(20, 60), 3.0
    back_of_a_sofa = slice(28, 60), slice(0, 80), 1.2
    depth = picture(television, back_of_a_sofa)
    assert np.quantile(depth[16:34, 28:52], NEAR_QUANTILE) == pytest.approx(1.2)
    assert found_m(depth) == pytest.approx(3.0)


def test_what_shows_through_the_object_and_goes_on_beyond_is_not_it_either():
    post = slice(10, 40), slice(20, 26), 2.0
    seat = slice(33, 40), slice(20, 60), 2.0
    assert found_m(picture(post, seat)) == pytest.approx(2.0)


def test_a_thing_that_lies_within_the_box_is_the_object_though_another_is_behind_it():
    sofa = slice(10, 40), slice(20, 60), 3.0
    table = slice(20, 38), slice(24, 56), 2.0
    assert found_m(picture(sofa, table)) == pytest.approx(2.0)


def test_where_all_surfaces_go_on_beyond_the_nearest_substantial_one_counts():
    assert found_m(picture()) == pytest.approx(WALL_M)
    beam = slice(20, 32), slice(0, 80), 2.0
    assert found_m(picture(beam)) == pytest.approx(2.0)


def test_a_speck_within_the_box_is_no_object():
    beam, speck = (slice(18, 34), slice(0, 80), 2.0), (slice(12, 14), slice(40, 42), 3.0)
    assert found_m(picture(beam, speck)) == pytest.approx(2.0)


def test_what_hangs_together_with_the_object_is_of_it_and_what_stands_before_it_is_not():
    """A backrest 3 m away with a seat that comes nearer by and by, and a table before both."""
    depth = picture((slice(10, 30), slice(20, 60), 3.0))
    depth[30:40, 20:60] = np.linspace(2.98, 2.6, 10)[:, None]
    depth[26:38, 30:50] = 2.2
    label = segment(depth, np.full(SHAPE, 1.0, np.float32)).label[BOX]
    own = attached(depth[BOX], label, 3.0)[label]
    seat, table, edge = (25, 5), (22, 20), (16, 20)
    assert own[seat]
    assert not own[table]
    assert not own[edge]  # where two meet is of neither


def test_the_floor_joins_nothing_that_stands_on_it():
    depth = picture((slice(10, 40), slice(20, 60), 2.0))
    high = np.full(SHAPE, 1.0, np.float32)
    high[35:] = 0.0
    depth[35:] = 2.0  # as deep there as what stands on it
    label, size, span = segment(depth, high)
    assert (label[35:] == 0).all()
    own = label[20, 40]
    assert size[own] == np.count_nonzero(label == own) < 25 * 40
    assert distance_m(depth[BOX], label[BOX], size, span) == pytest.approx(2.0)


def test_without_known_depth_there_is_no_distance():
    assert found_m(np.zeros(SHAPE, np.float32)) == 0.0


@given(
    arrays.arrays(np.float32, (12, 16), elements=st.sampled_from([0.0, 1.0, 1.05, 2.0, 3.0, 9.0])),
    st.integers(0, 9), st.integers(0, 13), st.integers(2, 9), st.integers(2, 9),
)  # fmt: skip
def test_any_box_of_any_picture_has_a_depth_that_occurs_in_it(depth, top, left, height, width):
    label, size, span = segment(depth, np.ones((12, 16), np.float32))
    box = slice(top, top + height), slice(left, left + width)
    patch = depth[box]
    distance = distance_m(patch, label[box], size, span)
    known = patch[patch > 0]
    if distance:
        assert known.min() <= distance <= known.max()


@given(arrays.arrays(np.float32, st.integers(1, 60), elements=st.floats(0, 8, width=32)))
def test_a_quantile_is_numpys(values: np.ndarray):
    assert quantile(values, NEAR_QUANTILE) == pytest.approx(
        float(np.quantile(values, NEAR_QUANTILE)), abs=1e-6
    )
