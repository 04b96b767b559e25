"""How finely each place was looked at, from which sides, and what that leaves to be missed."""

import math

import numpy as np
import pytest
from open_floor import RADIUS_M

from runtime.core.mapping.fineness import (
    COARSEST,
    FINEST,
    FLOOR,
    RAISED,
    Fineness,
    GoalSize,
    Recall,
    codes,
    missed_at,
    px_m,
)
from runtime.core.mapping.grid import NavigationMap
from runtime.core.types import Intrinsics, Mount, Observation, Pose

LENS = Intrinsics(400.0, 400.0, 320.0, 240.0, 640, 480)
MOUNT = Mount()  # 0.88 m above the floor
EVERYWHERE = slice(0, 240), slice(0, 240)
MUG = GoalSize(0.12, 0.0)


def shown(pose: Pose, plane_m: float, ends_m: float, lens: Intrinsics = LENS) -> Observation:
    """A level plane at that height, seen as far as `ends_m`; beyond it nothing."""
    down = (np.arange(lens.height) + 0.5 - lens.cy) / lens.fy
    with np.errstate(divide="ignore"):
        depth = np.where(down > 0, (MOUNT.z_m - plane_m) / down, 0.0)
    depth[depth > ends_m] = 0.0
    image = np.repeat(depth[:, None], lens.width, axis=1).astype(np.float32)
    return Observation(1, np.zeros((lens.height, lens.width, 3), np.uint8), image, pose, lens)


def wall(pose: Pose, away_m: float) -> Observation:
    depth = np.full((LENS.height, LENS.width), away_m, np.float32)
    return Observation(1, np.zeros((LENS.height, LENS.width, 3), np.uint8), depth, pose, LENS)


def looked(*images: Observation) -> tuple[Fineness, NavigationMap]:
    grid, fine = NavigationMap.around(Pose(0.0, 0.0, 0.0), RADIUS_M), Fineness()
    for image in images:
        fine.look(grid, image, MOUNT, 5.0)
    return fine, grid


def cell(fine: Fineness, x_m: float, y_m: float) -> tuple[int, int]:
    assert fine.frame is not None
    return fine.frame.cell(x_m, y_m)


def test_a_code_tells_pixels_a_metre_to_a_few_per_cent():
    every = np.geomspace(2.0**COARSEST + 1.0, 2.0**FINEST - 10.0, 200).astype(np.float32)
    np.testing.assert_allclose(px_m(codes(every)), every, rtol=0.03)
    assert px_m(np.zeros(1, np.uint8))[0] == 0.0
    assert codes(np.array([1.0, 1e6], np.float32)).tolist() == [1, 255]


def test_what_stands_is_told_from_what_lies_by_the_pixels_that_it_had():
    fine, _ = looked(wall(Pose(0.0, 0.0, 0.0), 2.0))
    at = cell(fine, 2.0, 0.0)
    assert px_m(fine.fine[RAISED])[at] == pytest.approx(200.0, rel=0.03)
    assert fine.fine[RAISED][cell(fine, 1.5, 0.0)] == 0
    fine, _ = looked(shown(Pose(0.0, 0.0, 0.0), 0.0, 4.0))
    assert px_m(fine.fine[FLOOR])[cell(fine, 3.02, 0.0)] == pytest.approx(400 / 3, rel=0.05)
    assert not fine.fine[RAISED].any()
    assert not fine.level.any()


def test_a_table_is_level_and_a_wall_is_not():
    fine, _ = looked(shown(Pose(0.0, 0.0, 0.0), 0.7, 3.0))
    assert fine.level[cell(fine, 1.5, 0.0)]
    assert fine.fine[RAISED][cell(fine, 1.5, 0.0)]
    fine, _ = looked(wall(Pose(0.0, 0.0, 0.0), 2.0))
    assert not fine.level.any()


def test_pixels_are_those_of_an_image_of_one_width():
    twice = Intrinsics(800.0, 800.0, 640.0, 480.0, 1280, 960)
    coarse, _ = looked(shown(Pose(0.0, 0.0, 0.0), 0.0, 4.0))
    fine, _ = looked(shown(Pose(0.0, 0.0, 0.0), 0.0, 4.0, twice))
    at = cell(fine, 3.0, 0.0)
    one, other = (px_m(f.fine[FLOOR])[at] for f in (coarse, fine))
    assert one == pytest.approx(float(other), rel=0.05)


def test_a_nearer_look_counts_and_a_farther_one_from_another_side_does_not():
    ahead, near = wall(Pose(0.0, 0.0, 0.0), 2.0), wall(Pose(1.0, 0.0, 0.0), 1.0)
    fine, grid = looked(ahead)
    at = cell(fine, 2.0, 0.0)
    assert fine.sides[RAISED][at].bit_count() == 1
    fine.look(grid, wall(Pose(2.0, -1.99, math.pi / 2), 2.0), MOUNT, 5.0)  # as near, from the right
    assert fine.sides[RAISED][at].bit_count() == 2
    fine.look(grid, near, MOUNT, 5.0)  # so much finer that those do not count beside it
    assert px_m(fine.fine[RAISED])[at] == pytest.approx(400.0, rel=0.03)
    assert fine.sides[RAISED][at].bit_count() == 1
    fine.look(grid, wall(Pose(2.0, 1.99, -math.pi / 2), 2.0), MOUNT, 5.0)
    assert fine.sides[RAISED][at].bit_count() == 1
    assert px_m(fine.fine[RAISED])[at] == pytest.approx(400.0, rel=0.03)


def test_what_was_never_seen_was_missed_and_every_look_leaves_less():
    fine, grid = looked(wall(Pose(0.0, 0.0, 0.0), 2.0))
    at = cell(fine, 2.0, 0.0)
    once = fine.missed(MUG, EVERYWHERE)[RAISED]
    assert once[cell(fine, -3.0, 0.0)] == 1.0
    assert once[at] == pytest.approx(missed_at(MUG, 200.0), abs=0.02)
    fine.look(grid, wall(Pose(2.0, -1.99, math.pi / 2), 2.0), MOUNT, 5.0)
    twice = fine.missed(MUG, EVERYWHERE)[RAISED]
    assert once[at] ** 2 < twice[at] < once[at]
    assert fine.missed(GoalSize(0.5), EVERYWHERE)[RAISED][at] < twice[at]


def test_the_layers_grow_with_the_map_and_keep_their_places():
    fine, grid = looked(wall(Pose(0.0, 0.0, 0.0), 2.05))
    assert fine.frame is not None
    before = fine.frame
    grid.grow(np.array([-11.0, 0.0]), 6.0)
    frame = fine.fit(grid.frame)
    assert frame.shape > before.shape
    assert px_m(fine.fine[RAISED])[frame.cell(2.05, 0.0)] == pytest.approx(400 / 2.05, rel=0.03)
    assert fine.first == (0, frame.cols - before.cols)


def test_for_another_goal_surfaces_are_known_and_looks_forgotten():
    fine, _ = looked(shown(Pose(0.0, 0.0, 0.0), 0.7, 3.0))
    fresh = fine.afresh()
    assert fresh.level[cell(fresh, 1.5, 0.0)]
    assert not fresh.fine.any()
    assert fine.fine.any()


def test_a_pose_that_is_off_the_map_books_nothing():
    fine, _ = looked(wall(Pose(11.0, 0.0, 0.0), 4.0))
    assert not fine.fine.any()


def test_recall_rises_with_size_up_to_what_is_found_at_most():
    curve = Recall(0.8, 20.0, 2.0)
    assert float(curve.of(20.0)) == pytest.approx(0.4)
    assert float(curve.of(40.0)) == pytest.approx(0.8 / (1 + math.exp(-2)), rel=1e-5)
    assert 0.0 <= float(curve.of(0.0)) < 1e-6
    assert float(curve.of(1e6)) == pytest.approx(0.8)
