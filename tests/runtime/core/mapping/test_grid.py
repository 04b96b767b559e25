"""The navigation map from depth images of a known room."""

import math

import cv2
import numpy as np
import pytest
from apartment import INTRINSICS, MOUNT, TWO_ROOMS, Apartment
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.mapping.grid import (
    EVIDENCE_MAX,
    HIT,
    OCCUPIED_AT,
    NavigationMap,
    integrate,
)
from runtime.core.types import Observation, Pose

DEPTH_M = 5.0
RADIUS, HEIGHT = 0.18, 1.0
START = Pose(3.0, 3.6, 0.0)


@pytest.fixture(autouse=True, scope="module")
def every_pixel_is_used():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.grid.STRIDE", 1)
        yield


def mapped(pose: Pose = START, turns: int = 12) -> tuple[NavigationMap, Apartment]:
    home = Apartment.of(TWO_ROOMS, pose)
    grid = NavigationMap.around(pose, RADIUS)
    for n in range(turns):
        home.pose = Pose(pose.x_m, pose.y_m, n * math.pi / 6)
        integrate(grid, home.observe(), MOUNT, RADIUS, HEIGHT, DEPTH_M)
    return grid, home


def truth(grid: NavigationMap, home: Apartment) -> np.ndarray:
    """Height under the centre of every cell of the map."""
    rows, cols = np.indices(grid.frame.shape)
    xy = grid.frame.centres(np.stack([rows, cols], axis=-1).astype(np.int32))
    r, c = (xy[..., 1] / 0.02).astype(int), (xy[..., 0] / 0.02).astype(int)
    inside = (r >= 0) & (c >= 0) & (r < home.heights.shape[0]) & (c < home.heights.shape[1])
    return np.where(
        inside,
        home.heights[
            np.clip(r, 0, home.heights.shape[0] - 1), np.clip(c, 0, home.heights.shape[1] - 1)
        ],
        np.nan,
    )


def test_free_cells_are_free_and_walls_are_occupied():
    grid, home = mapped()
    height = truth(grid, home)
    deep = np.zeros(grid.frame.shape, bool)  # cells well inside an obstacle
    deep[2:-2, 2:-2] = np.all(
        [np.roll(height > 0, (i, j), (0, 1)) for i in (-2, 0, 2) for j in (-2, 0, 2)], axis=0
    )[2:-2, 2:-2]
    assert (grid.free & deep).sum() <= 2  # of about a thousand: a sliver at a low box
    assert grid.free.sum() > 3000
    assert (height[grid.free] == 0).mean() > 0.98
    assert grid.occupied.sum() > 200
    near = np.any([np.roll(height > 0, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)], 0)
    assert near[grid.occupied].mean() > 0.97


def test_every_cell_is_exactly_one_of_three():
    grid, _ = mapped(turns=3)
    total = grid.free.astype(int) + grid.occupied + grid.unknown
    assert (total == 1).all()


def test_a_ray_that_passes_over_does_not_clear_an_obstacle():
    grid, _ = mapped(turns=0)
    row, col = grid.frame.cell(4.0, 3.6)
    grid.evidence[row, col] = HIT
    grid.swept[row, col] = True
    grid.changed()
    assert grid.occupied[row, col]
    assert not grid.free[row, col]


def test_seen_floor_clears_what_went_away():
    grid, home = mapped(turns=1)
    row, col = grid.frame.cell(5.0, 3.6)
    grid.evidence[row, col] = OCCUPIED_AT
    grid.changed()
    for _ in range(3):
        integrate(grid, home.observe(), MOUNT, RADIUS, HEIGHT, DEPTH_M)
    assert grid.free[row, col]


def test_a_bump_stays_until_the_body_has_been_there():
    grid, home = mapped(turns=1)
    pose = START
    grid.bump(pose, RADIUS)
    cell = grid.frame.cell(START.x_m + RADIUS + 0.075, START.y_m)
    integrate(grid, home.observe(), MOUNT, RADIUS, HEIGHT, DEPTH_M)
    assert grid.occupied[cell]
    grid.drive_over(Pose(START.x_m + 0.2, START.y_m, 0.0), RADIUS)
    assert grid.free[cell]


@settings(max_examples=20, deadline=None)
@given(st.floats(-40, 40), st.floats(-40, 40))
def test_growing_keeps_every_cell_in_its_place(x: float, y: float):
    grid = NavigationMap.around(Pose(0.0, 0.0, 0.0), RADIUS)
    marks = np.array([[1.02, 2.02], [-3.02, 0.52]])  # inside their cells
    grid.evidence[tuple(grid.frame.cells(marks).T)] = 9
    grid.grow(np.array([x, y]), 6.0)
    assert (grid.evidence[tuple(grid.frame.cells(marks).T)] == 9).all()
    assert grid.frame.contains(*grid.frame.cell(x - 5.9, y - 5.9))
    assert grid.frame.contains(*grid.frame.cell(x + 5.9, y + 5.9))
    assert grid.evidence.shape == grid.swept.shape == grid.bumped.shape == grid.frame.shape
    assert grid.driven.shape == grid.dead_end.shape == grid.frame.shape


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-4, 4), st.floats(-4, 4), st.floats(-3.1, 3.1))
def test_no_depth_image_breaks_the_map(seed: int, x: float, y: float, yaw: float):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(-1, 9, (120, 160)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = rng.choice([np.nan, np.inf, -np.inf, 0.0])
    rgb = np.zeros((120, 160, 3), np.uint8)
    grid = NavigationMap.around(Pose(0.0, 0.0, 0.0), RADIUS)
    obs = Observation(0, rgb, depth, Pose(x, y, yaw), INTRINSICS)
    outline = integrate(grid, obs, MOUNT, RADIUS, HEIGHT, DEPTH_M)
    assert np.isfinite(outline).all()
    assert np.abs(grid.evidence).max() <= EVIDENCE_MAX
    assert grid.free[grid.frame.cell(x, y)]  # the body stands there


def test_nothing_seen_changes_nothing():
    grid = NavigationMap.around(START, RADIUS)
    before = grid.free.copy()
    rgb = np.zeros((120, 160, 3), np.uint8)
    obs = Observation(0, rgb, np.zeros((120, 160), np.float32), START, INTRINSICS)
    integrate(grid, obs, MOUNT, RADIUS, HEIGHT, DEPTH_M)
    assert (grid.free == before).all()


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(st.floats(1, 9), st.floats(1, 4.5), st.floats(-3, 3)), max_size=5))
def test_masks_derived_piece_by_piece_are_those_derived_at_once(poses: list[tuple[float, ...]]):
    there = Apartment.of(TWO_ROOMS, START)
    grid = NavigationMap.around(START, RADIUS)
    for n, pose in enumerate(poses):
        there.pose = Pose(*pose)
        before, (revision, _) = grid.free.copy(), grid.changed_since(0)
        integrate(grid, there.observe(), MOUNT, RADIUS, HEIGHT, DEPTH_M)
        if n % 2:
            grid.bump(there.pose, RADIUS)
        _, window = grid.changed_since(revision)
        told = np.zeros(grid.frame.shape, bool)
        if window is not None:
            told[window] = True
        assert told[grid.free != before].all()  # who asks is told where
    derived = [mask.copy() for mask in (grid.occupied, grid.free, grid.unknown)]
    window = grid.known_window()
    grid.changed()
    for one, other in zip(derived, [grid.occupied, grid.free, grid.unknown], strict=True):
        assert (one == other).all()
    held = np.zeros(grid.frame.shape, bool)
    held[window] = True
    assert held[~grid.unknown].all()


def test_what_is_higher_than_the_robot_does_not_block_it():
    """Walls of a room, to a robot of 1 m and to one that is lower than what the map calls floor."""
    home, blocked = Apartment.of(TWO_ROOMS, START), []
    for height_m in (HEIGHT, 0.01):
        grid = NavigationMap.around(START, RADIUS)
        for _ in range(3):
            integrate(grid, home.observe(), MOUNT, RADIUS, height_m, DEPTH_M)
        blocked.append(int(grid.occupied.sum()))
    assert blocked[0] > 20
    assert blocked[1] == 0


HOLES = (0.0, np.nan, np.inf, -np.inf, -1.0, 65.535)


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(HOLES), st.integers(0, 2**32 - 1))
def test_glass_from_floor_to_ceiling_makes_no_free_space(hole: float, seed: int):
    """Depth is missing, or is what a camera says when it knows nothing: what lies behind stays
    unknown."""
    rng = np.random.default_rng(seed)
    home = Apartment.of(TWO_ROOMS, START)
    home.pose = Pose(START.x_m, START.y_m, float(rng.uniform(-math.pi, math.pi)))
    seen = home.observe()
    depth, (left, right) = seen.depth_m.copy(), np.sort(rng.integers(0, 160, 2))
    depth[:, left : right + 1] = hole
    free = []
    for image in (seen.depth_m, depth):
        grid = NavigationMap.around(START, RADIUS)
        obs = Observation(0, seen.rgb, image, home.pose, INTRINSICS)
        integrate(grid, obs, MOUNT, RADIUS, HEIGHT, DEPTH_M)
        free.append(grid.free)
    assert free[1].sum() > 10
    beside = cv2.dilate(free[0].view(np.uint8), np.ones((5, 5), np.uint8)).view(bool)
    assert not (free[1] & ~beside).any()  # an outline errs by a cell


LOW_BOX = """
########################################
#                                      #
#                                      #
#                                      #
#                                      #
#                b                     #
#                b                     #
#                                      #
#                                      #
########################################
"""


@pytest.mark.parametrize("hole", HOLES)
@pytest.mark.parametrize("x_m", [1.5, 2.5])
def test_what_a_low_thing_hides_is_not_free_where_it_gives_no_depth(hole: float, x_m: float):
    """A box whose every pixel is a hole, with floor and a wall behind it to be seen."""
    pose = Pose(x_m, 1.05, 0.0)
    box = Apartment.of(LOW_BOX, pose)
    bare = Apartment.of(LOW_BOX.replace("b", " "), pose)
    grid = NavigationMap.around(pose, RADIUS)
    seen = []
    for turn in (-0.1, 0.0, 0.1):
        box.pose = bare.pose = Pose(pose.x_m, pose.y_m, turn)
        with_box, without = box.observe(), bare.observe()
        depth = with_box.depth_m.copy()
        depth[with_box.depth_m != without.depth_m] = hole
        obs = Observation(0, with_box.rgb, depth, box.pose, INTRINSICS)
        seen.append(integrate(grid, obs, MOUNT, RADIUS, HEIGHT, DEPTH_M))
    deep = cv2.erode((truth(grid, box) == 0.2).view(np.uint8), np.ones((3, 3), np.uint8)) > 0
    assert deep.sum() > 20
    assert not (grid.free & deep).any()
    assert max(np.hypot(*(outline[1:] - outline[0]).T).max() for outline in seen) > 4.0


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_open_floor_stays_open_where_a_few_pixels_are_missing(seed: int):
    rng = np.random.default_rng(seed)
    home = Apartment.of(TWO_ROOMS, START)
    free = []
    for missing in (0.0, 0.05):
        grid = NavigationMap.around(START, RADIUS)
        for n in range(12):
            home.pose = Pose(START.x_m, START.y_m, n * math.pi / 6)
            seen = home.observe()
            depth = seen.depth_m.copy()
            depth[rng.random(depth.shape) < missing] = 0.0
            obs = Observation(0, seen.rgb, depth, home.pose, INTRINSICS)
            integrate(grid, obs, MOUNT, RADIUS, HEIGHT, DEPTH_M)
        free.append(grid.free)
    assert (free[0] & free[1]).sum() > 0.97 * free[0].sum()


def test_a_jump_of_the_pose_loses_no_cell_and_draws_no_way():
    grid, home = mapped(turns=2)
    known = ~grid.unknown.copy()
    home.pose = Pose(START.x_m + 5.0, START.y_m, 0.0)
    driven = int(grid.driven.sum())
    integrate(grid, home.observe(), MOUNT, RADIUS, HEIGHT, DEPTH_M)
    assert (~grid.unknown)[known].all()
    assert grid.driven.sum() <= driven + 13  # where it stands now, and nothing in between


def test_who_asks_late_is_told_of_the_whole_map():
    grid, _ = mapped(turns=1)
    revision, _ = grid.changed_since(0)
    assert grid.changed_since(revision) == (revision, None)
    for _ in range(70):
        grid.close(START.x_m, START.y_m, 0.1)
    later, window = grid.changed_since(revision)
    assert later == revision + 70
    assert window == (slice(0, grid.frame.rows), slice(0, grid.frame.cols))
    grid.close(START.x_m, START.y_m, 0.1)
    _, window = grid.changed_since(later)
    assert window is not None
    assert window[0].stop - window[0].start < 10
