"""Fast marching over drawn terrain, and the discrete policy that follows it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.distances.planner import (
    AROUND_M,
    Field,
    descend,
    look_around,
    march_from,
)
from runtime.core.distances.terrain import Terrain, survey
from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import NavigationMap
from runtime.core.motion.discrete_policy import FORWARD_M, TURN_RAD, face, follow
from runtime.core.types import Action, Pose

RADIUS = 0.18


@pytest.fixture(autouse=True, scope="module")
def small_map():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.grid.SIDE_M", 8.0)
        yield


def terrain(obstacles: list[tuple[float, float, float, float]], pose: Pose) -> Terrain:
    """A 6 m x 6 m free square around the origin with boxes x0, y0, x1, y1 in it."""
    grid = NavigationMap.around(Pose(0, 0, 0), RADIUS)
    f = grid.frame
    rows, cols = np.indices(f.shape)
    xy = f.centres(np.stack([rows, cols], axis=-1).astype(np.int32))
    x, y = xy[..., 0], xy[..., 1]
    grid.swept[(np.abs(x) < 3) & (np.abs(y) < 3)] = True
    for x0, y0, x1, y1 in obstacles:
        grid.evidence[(x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)] = 9
    grid.changed()
    return survey(grid, pose, RADIUS)


START = Pose(-2.0, 0.0, 0.0)


@settings(max_examples=25, deadline=None)
@given(st.floats(-2.5, 2.5), st.floats(-2.5, 2.5))
def test_distances_in_the_open_are_straight(x: float, y: float):
    field = march_from(terrain([], START), START.xy, unhurried=False)
    assert field.at(x, y) == pytest.approx(math.hypot(x + 2.0, y), abs=0.15, rel=0.05)


def test_a_wall_is_walked_around():
    field = march_from(terrain([(-0.1, -3, 0.1, 1.5)], START), START.xy, unhurried=False)
    around = 2 * math.hypot(2.0, 1.5 + RADIUS)
    assert field.at(2.0, 0.0) == pytest.approx(around, rel=0.06)


def test_a_gap_narrower_than_the_body_is_closed_and_a_wider_one_open():
    narrow = terrain([(-0.1, -3, 0.1, -0.12), (-0.1, 0.12, 0.1, 3)], START)
    assert march_from(narrow, START.xy, unhurried=False).at(2.0, 0.0) == math.inf
    wide = terrain([(-0.1, -3, 0.1, -0.32), (-0.1, 0.32, 0.1, 3)], START)
    assert march_from(wide, START.xy, unhurried=False).at(2.0, 0.0) < 4.5


def test_no_source_no_arrival():
    t = terrain([], START)
    assert not np.isfinite(march_from(t, np.array([[50.0, 50.0]])).arrival_m).any()


def test_the_path_descends_to_the_source():
    t = terrain([(-0.1, -3, 0.1, 1.5)], START)
    path = descend(march_from(t, START.xy), (2.0, 0.0))
    assert np.hypot(*(path[-1] - START.xy)) < 0.06
    assert np.hypot(*np.diff(path, axis=0).T).max() < 0.08
    cells = t.frame.cells(path)
    assert t.traversable[tuple(cells.T)].all()


def test_the_robot_can_leave_a_spot_too_tight_for_it():
    pose = Pose(0.0, 0.0, 0.0)
    t = terrain([(-3, 0.15, 3, 0.4)], pose)  # 15 cm beside the body's centre
    assert np.isfinite(march_from(t, np.array([1.5, -1.5])).at(0.0, 0.0))


def test_where_the_body_has_been_stays_a_way_back():
    grid = NavigationMap.around(Pose(0, 0, 0), RADIUS)
    f = grid.frame
    rows, cols = np.indices(f.shape)
    x, y = np.moveaxis(f.centres(np.stack([rows, cols], axis=-1).astype(np.int32)), -1, 0)
    grid.swept[(np.abs(x) < 3) & (np.abs(y) < 3)] = True
    for n in range(13):
        grid.drive_over(Pose(-1.5 + 0.25 * n, 0.0, 0.0), RADIUS)
    grid.evidence[(np.abs(x) < 0.5) & (np.abs(y) > 0.15)] = 9  # closer than was thought
    grid.changed()
    pose = Pose(1.5, 0.0, math.pi)
    t = survey(grid, pose, RADIUS)
    field = march_from(t, np.array([-1.5, 0.0]))
    assert field.at(1.5, 0.0) < math.inf
    assert follow(t, field, pose, RADIUS) is Action.MOVE_FORWARD
    grid.bump(Pose(0.4, 0.0, math.pi), RADIUS)
    t = survey(grid, pose, RADIUS)
    assert march_from(t, np.array([-1.5, 0.0])).at(1.5, 0.0) == math.inf


def drive(t: Terrain, pose: Pose, goal: tuple[float, float], limit: int = 120) -> list[Pose]:
    """Apply the policy's actions without noise until nothing is left to do."""
    field = march_from(t, np.array(goal))
    poses = [pose]
    for _ in range(limit):
        if field.at(pose.x_m, pose.y_m) < 0.25:
            break
        action = follow(t, field, pose, RADIUS)
        assert action is not None
        if action is Action.MOVE_FORWARD:
            d = FORWARD_M
            pose = Pose(
                pose.x_m + d * math.cos(pose.yaw_rad),
                pose.y_m + d * math.sin(pose.yaw_rad),
                pose.yaw_rad,
            )
        else:
            sign = 1 if action is Action.TURN_LEFT else -1
            pose = Pose(pose.x_m, pose.y_m, pose.yaw_rad + sign * TURN_RAD)
        poses.append(pose)
    return poses


@settings(max_examples=15, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-2.4, 2.4))
def test_the_policy_arrives_and_keeps_its_distance(yaw: float, y: float):
    t = terrain([(-0.2, -3, 0.2, -0.4), (-0.2, 0.4, 0.2, 3)], START)
    poses = drive(t, Pose(-2.0, y, yaw), (2.0, 0.5))
    assert math.hypot(poses[-1].x_m - 2.0, poses[-1].y_m - 0.5) < 0.4
    for pose in poses[1:]:
        row, col = t.frame.cell(pose.x_m, pose.y_m)
        assert t.clearance_m[row, col] >= RADIUS - 0.01
    assert len(poses) < 60


def test_walled_in_there_is_no_action():
    pose = Pose(0.0, 0.0, 0.3)
    box = [(-0.5, 0.22, 0.5, 0.5), (-0.5, -0.5, 0.5, -0.22)]
    t = terrain([*box, (0.22, -0.5, 0.5, 0.5), (-0.5, -0.5, -0.22, 0.5)], pose)
    assert follow(t, march_from(t, np.array([2.0, 0.0])), pose, RADIUS) is None


@given(st.floats(-3.14, 3.14), st.floats(-3.14, 3.14))
def test_facing_ends_within_half_a_turn_step(yaw: float, toward: float):
    for _ in range(7):
        turn = face(Pose(0, 0, yaw), toward)
        if turn is None:
            break
        yaw += TURN_RAD if turn is Action.TURN_LEFT else -TURN_RAD
    assert abs(math.remainder(toward - yaw, math.tau)) <= TURN_RAD / 2 + 1e-5


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.55, 1.0), st.sampled_from([1, 3, 128]))
def test_what_can_be_reached_has_the_distances_of_the_whole_map(seed: int, free: float, first: int):
    rng, grid = np.random.default_rng(seed), NavigationMap.around(Pose(0, 0, 0), RADIUS)
    grid.grow(np.array([9.0, -7.0]), 3.0)
    blocks = rng.choice([-5, 9, 0], (18, 18), p=[free, 0.7 * (1 - free), 0.3 * (1 - free)])
    rows, cols = grid.frame.shape
    grid.evidence[:] = np.kron(blocks, np.ones((rows // 18 + 1, cols // 18 + 1)))[:rows, :cols]
    grid.changed()
    pose = Pose(*rng.uniform(-3, 3, 2).tolist(), 0.0)
    grid.drive_over(pose, RADIUS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.distances.planner.FIRST_CELLS", first)
        patch.setattr("runtime.core.distances.planner.POCKET_M2", 0.0)
        near, reach = look_around(grid, pose, RADIUS)
    whole = survey(grid, pose, RADIUS)
    field = march_from(whole, pose.xy, unhurried=False)
    reached = np.argwhere(np.isfinite(field.arrival_m)).astype(np.int32)
    assert np.isfinite(reach.arrival_m).sum() == len(reached) > 0
    places = whole.frame.centres(reached)
    here = reach.frame.cells(places)
    assert (reach.of(here) == field.of(reached)).all()
    assert (reach.frame.centres(here) == places).all()
    assert (near.clearance_m[tuple(here.T)] == whole.clearance_m[tuple(reached.T)]).all()
    n = math.ceil(AROUND_M / 0.05)
    ends = whole.frame.cells(places) + np.array([[-n], [n]]).repeat(2, axis=1)[:, None]
    ends = np.clip(ends.reshape(-1, 2), 0, np.array(whole.frame.shape) - 1)
    assert near.frame.shape == tuple(np.ptp(ends, axis=0) + 1)


@given(st.tuples(*[st.integers(-9, 14)] * 2), st.tuples(*[st.integers(0, 9)] * 2))
def test_a_part_of_a_field_is_that_of_its_cells(low: tuple[int, int], size: tuple[int, int]):
    field = Field(GridFrame(0, 0, 0.05, 5, 7), np.arange(35.0).reshape(5, 7))
    window = slice(low[0], low[0] + size[0]), slice(low[1], low[1] + size[1])
    cells = np.stack(np.mgrid[window], axis=-1).astype(np.int32)
    assert (field.part(window) == field.of(cells)).all()


def test_where_the_robot_can_reach_nothing_all_that_is_known_is_told():
    grid, pose = NavigationMap.around(Pose(0, 0, 0), RADIUS), Pose(3.0, 3.0, 0.0)
    terrain, reach = look_around(grid, pose, RADIUS)
    assert terrain.frame == survey(grid, pose, RADIUS).frame
    assert not np.isfinite(reach.arrival_m).any()
