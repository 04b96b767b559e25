"""How far the object in a box is, where something hides a part of it or shows through it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from runtime.core.geometry import GridFrame
from runtime.core.objects.depth_segments import NEAR_QUANTILE, STRIDE, SeenThing, things_in
from runtime.core.types import Intrinsics, Mount, Observation, Pose

WALL_M, SHAPE = 4.0, (60, 80)
BOX = slice(10, 40), slice(20, 60)  # rows, columns
FRAME = GridFrame(-10.0, -10.0, 0.05, 400, 400)


def picture(*things: tuple[slice, slice, float]) -> np.ndarray:
    """A wall, and in front of it rectangles at a depth, m, the later before the earlier."""
    depth = np.full(SHAPE, WALL_M, np.float32)
    for rows, cols, depth_m in things:
        depth[rows, cols] = depth_m
    return depth


def thing(
    depth: np.ndarray,
    box: tuple[slice, slice] = BOX,
    focal_px: float = 4000.0,
    high_m: float = 1.0,
    known_m: float = math.nan,
) -> SeenThing | None:
    """What is in the box of an image of which this is every STRIDE-th pixel, by a camera that is so
    high; with a long focal length all is about as high."""
    rows, cols = STRIDE * depth.shape[0], STRIDE * depth.shape[1]
    image = np.repeat(np.repeat(depth, STRIDE, 0), STRIDE, 1)
    lens = Intrinsics(focal_px, focal_px, cols / 2, rows / 2, cols, rows)
    obs = Observation(0, np.zeros((rows, cols, 3), np.uint8), image, Pose(0, 0, 0), lens)
    (top, bottom), (left, right) = ((part.start, part.stop) for part in box)
    wide = STRIDE * (right - left) / focal_px
    row = np.array([[top, left, bottom, right, known_m, wide]], np.float64)
    (found,) = things_in(obs, row, Mount(z_m=high_m), FRAME)
    return found


def found_m(depth: np.ndarray) -> float:
    found = thing(depth)
    assert found is not None
    return found.range_m


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
    depth[30:40, 20:60] = np.linspace(2.98, 2.86, 10)[:, None]
    depth[26:38, 30:50] = 2.7
    found = thing(depth, focal_px=300.0, known_m=3.0)
    assert found is not None
    assert 2.8 < found.cells_xy[:, 0].min() < 2.9


def test_the_floor_joins_nothing_that_stands_on_it():
    """A cupboard whose floor goes on beyond the box, and a niche in it that does not."""
    depth = picture((slice(10, 40), slice(20, 60), 2.0), (slice(14, 20), slice(24, 50), 2.8))
    depth[35:] = 2.0  # floor, as deep there as what stands on it
    found = thing(depth, focal_px=170.0, high_m=0.3)
    assert found is not None
    assert found.range_m == pytest.approx(2.0)
    assert found.low_m > 0.05


def test_without_known_depth_there_is_nothing():
    assert thing(np.zeros(SHAPE, np.float32)) is None


def test_what_stands_before_a_thing_too_far_away_for_depth_is_not_it():
    """A lamp at 3 m before a bed at 7 m, of a camera that sees 5 m."""
    lamp = slice(12, 60), slice(35, 45), 3.0
    depth = picture(lamp)
    depth[depth == WALL_M] = 0.0
    assert thing(depth) is None
    depth[:, 30:50] = 3.0  # half of the box: it may be the thing
    assert found_m(depth) == pytest.approx(3.0)


def test_a_screen_that_throws_no_depth_back_is_where_its_frame_is():
    television = slice(10, 40), slice(20, 60), 3.0
    depth = picture(television)
    depth[18:32, 30:50] = 0.0
    assert found_m(depth) == pytest.approx(3.0)


@given(
    arrays.arrays(np.float32, (12, 16), elements=st.sampled_from([0.0, 1.0, 1.05, 2.0, 3.0, 9.0])),
    st.integers(0, 9), st.integers(0, 13), st.integers(2, 9), st.integers(2, 9),
)  # fmt: skip
def test_any_thing_in_any_picture_has_a_depth_that_occurs_in_its_box(
    depth, top, left, height, width
):
    box = slice(top, top + height), slice(left, left + width)
    found = thing(depth, box)
    known = depth[box][depth[box] > 0]
    if found is not None:
        assert known.min() <= found.range_m <= known.max()
