"""Sensors and maps that cannot be right: the search goes on, and nothing unsafe is made of them."""

from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT, NO_DETECTIONS, TWO_ROOMS, Apartment

from runtime import navigate
from runtime.core.mapping.solid_depth import solid
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.types import Observation, Pose, SearchState
from runtime.core.world import Command, World

CFG = navigate.NavigateConfig()


def begun(x_m: float = 4.0, y_m: float = 3.0) -> tuple[Apartment, World]:
    """A search that has seen one frame."""
    home = Apartment.of(TWO_ROOMS, Pose(x_m, y_m, 0.0))
    world = World.begin("toilet", ("toilet",), (), home.pose, CFG.robot.radius_m, 0)
    shown(world, home.observe())
    return home, world


def shown(world: World, obs: Observation) -> Command:
    """A frame and the step after it."""
    obs = replace(obs, depth_m=solid(obs.depth_m))
    navigate.perceive(world, obs, NO_DETECTIONS, MOUNT, CFG)
    return navigate.steer(world, navigate.act(world, CFG), CFG)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -3.0, 65.535, 1e30, 5.01])
def test_pixels_that_are_no_distance_free_nothing(value: float):
    home, world = begun()
    before = world.map.free.copy()
    obs = home.observe()
    assert shown(world, replace(obs, depth_m=np.full_like(obs.depth_m, value))).action
    assert np.array_equal(world.map.free, before)


@pytest.mark.parametrize("value", [np.nan, np.inf, -3.0, 65.535])
def test_such_pixels_among_others_change_nothing_but_their_own_cells(value: float):
    home, world = begun()
    _, other = begun()
    obs = home.observe()
    holes = np.random.default_rng(1).random(obs.depth_m.shape) < 0.2
    shown(world, replace(obs, depth_m=np.where(holes, np.float32(value), obs.depth_m)))
    shown(other, replace(obs, depth_m=np.where(holes, np.float32(0), obs.depth_m)))
    assert np.array_equal(world.map.evidence, other.map.evidence)
    assert np.array_equal(world.map.free, other.map.free)


@pytest.mark.parametrize("away_m", [5.0, -5.0, 60.0])
def test_after_a_jump_the_robot_knows_itself_free_where_it_now_is(away_m: float):
    home, world = begun()
    far = Pose(home.pose.x_m + away_m, home.pose.y_m, 0.0)
    frame, free = world.map.frame, world.map.free.copy()
    command = shown(world, replace(home.observe(), pose=far))
    assert command.ended is None
    assert world.pose == far
    row, col = world.map.frame.cell(far.x_m, far.y_m)
    assert world.map.free[row, col]
    # What was known lies where it lay.
    rows, cols = np.nonzero(free)
    xy = frame.centres(np.stack([rows, cols], axis=-1).astype(np.int32))
    now = world.map.frame.cells(xy)
    assert world.map.free[now[:, 0], now[:, 1]].mean() > 0.9


def test_time_that_goes_back_takes_none():
    home, world = begun()
    elapsed_s = world.body.elapsed_s
    shown(world, replace(home.observe(), stamp_ns=1))
    assert world.body.dt_s == 0.0
    assert world.body.elapsed_s == elapsed_s
    shown(world, replace(home.observe(), stamp_ns=100_000_001))
    assert world.body.elapsed_s == pytest.approx(elapsed_s + 0.1)


@pytest.mark.parametrize("xy", [(500.0, 500.0), (-1e6, 3.0), (4.0, -13.0)])
def test_a_target_outside_the_map_is_not_gone_to(xy: tuple[float, float]):
    home, world = begun()
    seen_from = [home.pose, Pose(4.5, 3.5, 1.0)]
    believed = {"toilet": Evidence(6.0, backing=seen_from, near_m=1.0)}
    cells = np.array([xy]) + np.array([[0.0, 0.0], [0.05, 0.0]])
    world.semantic.instances[1] = Instance(1, believed, xy, 0.4, cells, 0.0, 0.4, views=seen_from)
    for _ in range(5):
        command = shown(world, home.observe())
        assert command.ended is not SearchState.FOUND
        assert command.ended is SearchState.UNREACHABLE or command.toward_xy != xy
        home.apply(command.action)
