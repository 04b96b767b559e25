"""Far ways through large halls: along a corridor, and no detour."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.distances import planner
from runtime.core.distances.planner import approach, cells_at, descend, march, march_from
from runtime.core.distances.terrain import Terrain, coarser, pooled, survey
from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import NavigationMap
from runtime.core.types import Pose

RADIUS = 0.18
START = Pose(-6.0, 0.0, 0.0)


@pytest.fixture(autouse=True, scope="module")
def large_halls():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.grid.SIDE_M", 16.0)
        patch.setattr("runtime.core.distances.planner.LARGE_CELLS", 1000)
        yield


def hall(boxes: np.ndarray) -> Terrain:
    """15 m x 15 m of free ground around the origin, with (N, 4) boxes x0, y0, x1, y1 in it."""
    grid = NavigationMap.around(START, RADIUS)
    grid.grow(np.array([6.0, 0.0]), 4.0)
    x, y = np.moveaxis(grid.frame.centres(np.moveaxis(np.indices(grid.frame.shape), 0, -1)), -1, 0)
    grid.evidence[(np.abs(x) < 7.5) & (np.abs(y) < 7.5)] = -5
    for x0, y0, x1, y1 in boxes:
        grid.evidence[(x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)] = 9
    grid.changed()
    return survey(grid, START, RADIUS)


def planned(terrain: Terrain, goal_xy: tuple[float, float]) -> tuple[planner.Field, planner.Field]:
    """The approach, and what all of the terrain says."""
    reach = march_from(terrain, START.xy, unhurried=False)
    goal = cells_at(terrain, goal_xy)
    return approach(terrain, goal, reach, START), march(terrain, goal)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.floats(5.0, 7.0), st.floats(-7.0, 7.0))
def test_a_far_way_is_no_detour_and_touches_nothing(seed: int, count: int, x: float, y: float):
    rng = np.random.default_rng(seed)
    low = rng.uniform(-7.5, 7.0, (count, 2))
    terrain = hall(np.concatenate([low, low + rng.exponential(0.6, (count, 2))], axis=1))
    near, whole = planned(terrain, (x, y))
    left_m, least_m = near.at(START.x_m, START.y_m), whole.at(START.x_m, START.y_m)
    if math.isinf(least_m):
        assert math.isinf(left_m)
        return
    assert left_m <= 1.05 * least_m
    path = descend(near, (START.x_m, START.y_m))
    assert terrain.traversable[tuple(terrain.frame.cells(path).T)].all()
    assert math.dist(path[-1], (x, y)) < 0.1


def test_it_is_marched_along_a_corridor():
    near, whole = planned(hall(np.array([[-1.0, -4.0, 0.0, 5.0]])), (6.0, 1.0))
    marched = np.isfinite(near.arrival_m)
    assert 0 < 3 * marched.sum() < np.isfinite(whole.arrival_m).sum()
    assert near.at(START.x_m, START.y_m) == pytest.approx(whole.at(START.x_m, START.y_m), rel=0.02)
    steps = near.frame.cells(START.xy + 0.7 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]]))
    assert np.isfinite(near.of(steps)).all()  # where a step may end


@pytest.mark.parametrize("gap_m", [2 * RADIUS + 0.1, 0.8])
@pytest.mark.parametrize("aside_m", [0.0, 0.02, 0.04])
def test_a_narrow_passage_is_passed(gap_m: float, aside_m: float):
    side = gap_m / 2 + 0.025  # to the cells' centres
    walls = [[-0.1, -8, 0.1, aside_m - side], [-0.1, aside_m + side, 0.1, 8]]
    near, whole = planned(hall(np.array(walls)), (6.0, 3.0))
    assert near.at(START.x_m, START.y_m) == pytest.approx(whole.at(START.x_m, START.y_m), rel=0.05)
    assert near.at(START.x_m, START.y_m) < 25.0


def test_what_only_larger_cells_let_pass_is_walked_around():
    walls = np.array([[-0.1, -8, 0.1, -0.15], [-0.1, 0.15, 0.1, 6.5]])
    near, whole = planned(hall(walls), (6.0, 0.0))
    assert near.at(START.x_m, START.y_m) <= 1.05 * whole.at(START.x_m, START.y_m) < 40.0


def test_no_way_leads_to_a_goal_outside_the_map():
    near, _ = planned(hall(np.zeros((0, 4))), (50.0, 50.0))
    assert not np.isfinite(near.arrival_m).any()


@given(st.integers(1, 40), st.integers(1, 40), st.integers(1, 6))
def test_a_larger_cell_holds_the_most_of_its_own(rows: int, cols: int, times: int):
    frame = GridFrame(-1.0, 2.0, 0.05, rows, cols, 3, 5)
    values = np.random.default_rng(rows * cols).uniform(0, 1, (rows, cols)).astype(np.float32)
    wide, most = coarser(frame, times), pooled(values, times)
    assert wide.shape == most.shape
    expected = np.zeros(wide.shape, np.float32)
    for cell in np.ndindex(values.shape):
        xy = frame.centres(np.array(cell, np.int32))
        at = wide.cell(*xy.tolist())
        expected[at] = max(expected[at], values[cell])
    assert (most == expected).all()
