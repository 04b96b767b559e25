import heapq
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.distances import planner
from runtime.core.distances.kept_plan import BEYOND_M, KeptPlan
from runtime.core.distances.planner import Field, descend
from runtime.core.distances.terrain import Terrain, survey
from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import NavigationMap
from runtime.core.types import Pose

RADIUS = 0.18
CELL_M = 0.05
SIDE = 40  # cells of the small grids
START = Pose(-6.0, 0.0, 0.0)


def of_speeds(speed: np.ndarray, top: int = 0, left: int = 0) -> Terrain:
    """A window of a grid whose first cell is at the origin of the map frame."""
    frame = GridFrame(0.0, 0.0, CELL_M, *speed.shape, top, left)
    return Terrain(frame, np.ones(speed.shape, np.float32), speed > 0, speed)


def at(row: float, col: float) -> Pose:
    return Pose((col + 0.5) * CELL_M, (row + 0.5) * CELL_M, 0.0)


def goal_at(terrain: Terrain, row: int, col: int) -> np.ndarray:
    return goal_xy(terrain, at(row, col).xy)


def goal_xy(terrain: Terrain, xy: tuple[float, float]) -> np.ndarray:
    return terrain.frame.cells(np.array([xy]))


def march(terrain: Terrain, goal: np.ndarray) -> Field:
    return planner.march_from(terrain, terrain.frame.centres(goal))


def random_speeds(rng: np.random.Generator) -> np.ndarray:
    speed = rng.choice(np.array([0.25, 0.6, 1.0, 1.0], np.float32), (SIDE, SIDE))
    for _ in range(rng.integers(0, 8)):
        r, c = rng.integers(0, SIDE, 2)
        speed[r : r + rng.integers(1, 12), c : c + rng.integers(1, 4)] = 0.0
    return speed


def change(speed: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The same with what has come, gone or become tighter in one place."""
    speed, (r, c) = speed.copy(), rng.integers(0, SIDE, 2)
    part = slice(r, r + rng.integers(1, 8)), slice(c, c + rng.integers(1, 8))
    speed[part] = rng.choice(np.array([0.0, 0.25, 1.0], np.float32))
    return speed


def check(plan: KeptPlan, terrain: Terrain, goal: np.ndarray, pose: Pose) -> None:
    """What it gives is the march, as far as the robot may look."""
    field, whole = plan.toward(terrain, goal, pose), march(terrain, goal)
    here = whole.at(pose.x_m, pose.y_m)
    needed = whole.arrival_m <= here + BEYOND_M if math.isfinite(here) else np.isfinite(here)
    known = np.isfinite(field.arrival_m)
    assert np.allclose(field.arrival_m[known], whole.arrival_m[known], rtol=0, atol=1e-9)
    assert known[needed & np.isfinite(whole.arrival_m)].all()
    assert field.at(pose.x_m, pose.y_m) == pytest.approx(here, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_plan_that_is_kept_is_the_march_made_anew(seed: int):
    rng = np.random.default_rng(seed)
    plan, speed, goal = KeptPlan(), random_speeds(rng), rng.integers(0, SIDE, 2)
    for _ in range(8):
        terrain = of_speeds(speed)
        check(plan, terrain, goal_at(terrain, *goal), at(*rng.uniform(0, SIDE, 2)))
        if rng.random() < 0.7:
            speed = change(speed, rng)
        if rng.random() < 0.2:
            goal = rng.integers(0, SIDE, 2)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_so_is_one_in_a_window_that_moves(seed: int):
    rng = np.random.default_rng(seed)
    plan, speed, goal = KeptPlan(), random_speeds(rng), rng.integers(10, SIDE - 10, 2)
    for _ in range(8):
        top, left = rng.integers(0, 11, 2)
        bottom, right = rng.integers(SIDE - 10, SIDE + 1, 2)
        terrain = of_speeds(speed[top:bottom, left:right], top, left)
        check(plan, terrain, goal_at(terrain, *goal), at(*rng.uniform(0, SIDE, 2)))
        if rng.random() < 0.5:
            speed = change(speed, rng)


def test_a_plan_that_nothing_touches_is_the_same_field():
    speed = np.ones((SIDE, SIDE), np.float32)
    plan, pose, goal = KeptPlan(), at(38, 2), goal_at(of_speeds(speed), 38, 1)
    first = plan.toward(of_speeds(speed), goal, pose)
    speed[0:4, 36:40] = 0.0  # beyond what the robot may look at
    second = plan.toward(of_speeds(speed), goal, pose)
    assert second is first


def test_a_plan_is_told_farther_when_asked_and_others_as_they_are():
    speed = np.ones((SIDE, SIDE), np.float32)
    terrain, plan, pose = of_speeds(speed), KeptPlan(), at(38, 2)
    whole = march(terrain, goal_at(terrain, 38, 1))
    assert plan.farther(whole, terrain, pose, 9.0) is whole
    field = plan.toward(terrain, goal_at(terrain, 38, 1), pose)
    assert np.isinf(field.arrival_m[0, 39])
    far = plan.farther(field, terrain, pose, 9.0)
    assert np.allclose(far.arrival_m, whole.arrival_m, rtol=0, atol=1e-9)
    assert np.isinf(field.arrival_m[0, 39])
    assert plan.toward(terrain, goal_at(terrain, 38, 1), pose) is far


def test_what_others_go_by_is_not_written_to():
    speed = np.ones((SIDE, SIDE), np.float32)
    plan, goal = KeptPlan(), goal_at(of_speeds(speed), 20, 20)
    first = plan.toward(of_speeds(speed), goal, at(20, 15))
    before = first.arrival_m.copy()
    speed[20, 17] = 0.0
    plan.toward(of_speeds(speed), goal, at(0, 0))
    plan.toward(of_speeds(speed), goal, at(39, 39))
    assert np.array_equal(first.arrival_m, before)


def test_a_map_that_grew_is_another_grid():
    speed = np.ones((SIDE, SIDE), np.float32)
    plan, terrain = KeptPlan(), of_speeds(speed)
    plan.toward(terrain, goal_at(terrain, 20, 20), at(5, 5))
    grown = GridFrame(-1.0, 0.0, CELL_M, SIDE, SIDE)
    other = Terrain(grown, terrain.clearance_m, terrain.traversable, speed)
    check(plan, other, goal_xy(other, (0.5, 0.5)), at(5, 5))


def edge(speed: np.ndarray, a: tuple[int, int], b: tuple[int, int]) -> float:
    return math.dist(a, b) * CELL_M * (0.5 / float(speed[a]) + 0.5 / float(speed[b]))


def dijkstra(speed: np.ndarray, goal: tuple[int, int], start: tuple[int, int]) -> float:
    """Eight neighbours; an edge takes its length at the mean of its cells' slownesses."""
    best, heap, (rows, cols) = {goal: 0.0}, [(0.0, goal)], speed.shape
    while heap:
        time, (r, c) = heapq.heappop(heap)
        if (r, c) == start:
            return time
        if time > best[r, c]:
            continue
        for dr, dc in np.ndindex(3, 3):
            y, x = r + dr - 1, c + dc - 1
            if not (0 <= y < rows and 0 <= x < cols) or speed[y, x] == 0:
                continue
            later = time + edge(speed, (r, c), (y, x))
            if later < best.get((y, x), math.inf):
                best[y, x] = later
                heapq.heappush(heap, (later, (y, x)))
    return math.inf


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_repaired_plan_is_hardly_slower_than_dijkstras_and_enters_no_obstacle(seed: int):
    rng = np.random.default_rng(seed)
    grid, plan = NavigationMap.around(Pose(1.0, 1.0, 0.0), RADIUS), KeptPlan()
    middle = grid.frame.rows // 2
    grid.evidence[middle - SIDE : middle + SIDE, middle - SIDE : middle + SIDE] = -5
    goal = (0.0, 0.0)
    for _ in range(5):
        r, c = middle + rng.integers(-SIDE, SIDE, 2)
        grid.evidence[r : r + 12, c : c + 3] = rng.choice([9, -5])
        grid.changed()
        pose = Pose(*rng.uniform(0.0, 2.5, 2).tolist(), 0.0)
        terrain = survey(grid, pose, RADIUS)
        cells = goal_xy(terrain, goal)
        field = plan.toward(terrain, cells, pose)
    path = descend(field, (pose.x_m, pose.y_m))
    assert bool(len(path)) == math.isfinite(march(terrain, cells).at(pose.x_m, pose.y_m))
    steps = [tuple(cell) for cell in terrain.frame.cells(path).tolist()]
    assert all(terrain.traversable[cell] for cell in steps)
    if len(steps) > 1:
        took = sum(edge(terrain.speed, a, b) for a, b in pairwise(steps))
        assert took <= 1.05 * dijkstra(terrain.speed, steps[-1], steps[0]) + CELL_M


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


@pytest.mark.parametrize("gap_m", [2 * RADIUS + 0.1, 0.8])
@pytest.mark.parametrize("aside_m", [0.0, 0.02, 0.04])
def test_a_narrow_passage_is_passed(gap_m: float, aside_m: float):
    side = gap_m / 2 + 0.025  # to the cells' centres
    walls = [[-0.1, -8, 0.1, aside_m - side], [-0.1, aside_m + side, 0.1, 8]]
    terrain = hall(np.array(walls))
    field = KeptPlan().toward(terrain, goal_xy(terrain, (6.0, 3.0)), START)
    assert field.at(START.x_m, START.y_m) < 25.0


def test_no_way_leads_to_a_goal_outside_the_map():
    terrain = hall(np.zeros((0, 4)))
    field = KeptPlan().toward(terrain, goal_xy(terrain, (50.0, 50.0)), START)
    assert not np.isfinite(field.arrival_m).any()
