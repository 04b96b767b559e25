import math

import numpy as np
import pytest

from runtime.core.mapping.sights import FAR_M, column_of, sight_depth, way_of
from runtime.core.types import Intrinsics, Mount, Pose


def camera(width: int, height: int) -> Intrinsics:
    return Intrinsics(400.0, 400.0, width / 2, height / 2, width, height)


def test_each_part_has_the_mean_of_what_is_known_of_it_and_how_much_that_is():
    depth = np.full((480, 640), 2.0, np.float32)
    depth[:80, :80] = 0.0  # nothing known
    depth[:80, 80:160] = np.nan
    depth[:80, 80:120] = 4.0  # half of it
    depth[400:, 560:] = 30.0
    mean, known = sight_depth(depth, 6, 8)
    assert (mean[0, 0], known[0, 0]) == (0.0, 0.0)
    assert (mean[0, 1], known[0, 1]) == (4.0, 0.5)
    assert mean[5, 7] == FAR_M
    assert (mean[3, 3], known[3, 3]) == (2.0, 1.0)


def test_a_wide_image_has_bars_above_and_below():
    mean, known = sight_depth(np.full((360, 640), 3.0, np.float32), 6, 8)
    assert known[3].min() == 1.0
    assert mean[1:5].min() == 3.0
    assert known[0].max() in (0.0, 1.0)  # no pixel of the image, or only such
    wide, tall = camera(640, 360), camera(480, 640)
    assert column_of(0.0, wide, 6, 8) == 0.0
    assert column_of(480.0, tall, 6, 8) == pytest.approx(0.5 + 0.5 * 480 / 640 * 6 / 8)


def test_columns_are_of_the_letterboxed_image_and_stay_in_it():
    plain = camera(640, 480)
    assert [column_of(u, plain, 6, 8) for u in (-50.0, 160.0, 320.0, 900.0)] == [0, 0.25, 0.5, 1]


def test_a_tall_image_leaves_the_outer_columns_empty():
    _, known = sight_depth(np.full((640, 480), 1.0, np.float32), 6, 8)
    assert known[:, [0, 7]].max() == 0.0
    assert known[:, 3:5].min() == 1.0


def test_where_a_frontier_stands_in_a_keyframe():
    k, mount = camera(640, 480), Mount(0.1, 0.0, 0.88, 0.0, 0.2, 0.0)
    pose = Pose(1.0, 2.0, math.pi / 2)
    ahead = np.array([[0.9, 4.0], [1.1, 4.0]])
    column, range_m = way_of(ahead, pose, mount, k, 6, 8)
    assert (column, range_m) == pytest.approx((0.5, 2.0), abs=2e-3)
    left, _ = way_of(ahead - (0.5, 0.0), pose, mount, k, 6, 8)
    assert left < 0.4
    behind, _ = way_of(ahead - (-0.5, 4.0), pose, mount, k, 6, 8)
    assert behind == 1.0  # at the edge nearest to it
