"""Frontiers are as far on foot as the distances over the whole map say."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.distances.planner import look_around, march_from
from runtime.core.distances.terrain import survey
from runtime.core.types import Pose
from runtime.core.world import MOST_SIDE_M, STEP_M, BaseState, World, with_distances

RADIUS_M = 0.18
POSE = Pose(-6.0, 4.0, 0.0)


def rooms(wall_m: float) -> World:
    """A room of 3 m around the robot, and free ground from `wall_m` beyond its wall on."""
    world = World.begin("chair", ("chair",), (), POSE, RADIUS_M)
    frame, evidence = world.map.frame, world.map.evidence
    row, col = frame.cell(POSE.x_m, POSE.y_m)
    beyond = 30 + round(wall_m / frame.resolution_m)
    evidence[row - 60 : row + 150, col + beyond : col + 200] = -5
    evidence[row - 32 : row + 33, col - 32 : col + 33] = 9
    evidence[row - 30 : row + 31, col - 30 : col + 31] = -5
    world.map.changed()
    return world


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 6.0))
def test_frontiers_have_the_distances_of_the_whole_map(seed: int, wall_m: float):
    rng, world = np.random.default_rng(seed), rooms(wall_m)
    known = np.argwhere(~world.map.unknown).astype(np.int32)
    named = {}
    for n in range(12):
        start = known[rng.integers(len(known))]
        cells = known[np.abs(known - start).max(axis=1) <= rng.integers(0, 4)]
        named[n] = world.map.frame.centres(cells)
    world.seen = look_around(world.map, POSE, RADIUS_M)
    with_distances(world, named)
    found = world.frontiers
    whole = survey(world.map, POSE, RADIUS_M)
    assert world.reach.frame.shape < whole.frame.shape
    world.seen = whole, march_from(whole, POSE.xy, unhurried=False)
    with_distances(world, named)
    for near, far in zip(found, world.frontiers, strict=True):
        assert (near.id, near.goal_xy, near.distance_m) == (far.id, far.goal_xy, far.distance_m)
    assert any(math.isinf(f.distance_m) for f in found)


def test_the_way_is_kept_and_standing_adds_nothing_to_it():
    body = BaseState()
    for n in range(1000):
        body.been(Pose(0.3 * STEP_M * (n % 2), 0.0, 0.1 * n))
    assert body.visited_xy == [(0.0, 0.0)]
    for n in range(5):
        body.been(Pose(0.0, n * 2 * STEP_M, 0.0))
    assert body.visited_xy == [(0.0, n * 2 * STEP_M) for n in range(5)]


@given(st.floats(-1e5, 1e5), st.floats(-1e5, 1e5), st.floats(-150, 150), st.floats(-150, 150))
def test_a_map_never_grows_beyond_what_it_may(x: float, y: float, dx: float, dy: float):
    world = World.begin("chair", ("chair",), (), Pose(x, y, 0.0), RADIUS_M)
    at = Pose(x + dx, y + dy, 0.0)
    may = world.may_reach(at, 6.0)
    assert may or max(abs(dx), abs(dy)) > 90
    if may:
        assert max(abs(dx), abs(dy)) <= MOST_SIDE_M
        sides = world.map.frame
        world.map.grow(np.array(at.xy), 6.0)
        frame = world.map.frame
        assert frame.contains(*frame.cell(*at.xy))
        block_m = 128 * frame.resolution_m
        assert max(frame.shape) * frame.resolution_m <= MOST_SIDE_M + block_m
        assert min(frame.shape) >= min(sides.shape)


def test_what_is_no_number_is_nowhere_on_a_map():
    world = rooms(1.0)
    for far in (math.nan, math.inf, -1e300):
        assert not world.may_reach(Pose(far, 0.0, 0.0), 6.0)
        assert not world.may_reach(Pose(0.0, far, 0.0), 6.0)
