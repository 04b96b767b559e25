"""A wedged robot turns to where it is widest; a way that no step leads along is planned no more."""

import math
from dataclasses import replace

import numpy as np
import pytest
from open_floor import POSE, RADIUS_M, axes, floor

from runtime import navigate
from runtime.core.distances.planner import look_around, march_from
from runtime.core.local_policy import GIVE_UP_AFTER, local_policy
from runtime.core.motion.discrete_policy import TURN_RAD
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Pose
from runtime.core.world import Aim, AimKind, Progress, World


def test_a_whole_turn_in_vain_ends_in_a_step_where_it_is_widest():
    """The map leaves no heading: a ring right around the robot, a little wider behind it."""
    grid, cfg = floor(), NavigateConfig()
    x, y = axes(grid)
    ring = (np.hypot(x, y) > 0.24) & (np.hypot(x, y) < 0.6)
    grid.evidence[ring & ~((x < 0) & (np.abs(y) < 0.11))] = 10
    grid.changed()
    world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
    world.map, world.seen = grid, look_around(grid, POSE, RADIUS_M)
    field = march_from(world.terrain, np.array([2.0, 0.0]))
    world.pursuit.aim = Aim(AimKind.FRONTIER, 1)
    actions = []
    for step in range(20):
        world.pursuit.progress[world.pursuit.aim] = Progress(idle=float(step))
        action, _ = local_policy(cfg).drive(world, field)
        actions.append(action)
        if action is Action.MOVE_FORWARD:
            break
        yaw = world.pose.yaw_rad + (1 if action is Action.TURN_LEFT else -1) * TURN_RAD
        world.pose = replace(world.pose, yaw_rad=yaw)
    assert actions[:13] == [Action.TURN_LEFT] * 13
    assert actions[-1] is Action.MOVE_FORWARD
    assert len(actions) <= GIVE_UP_AFTER - 4  # before the aim is given up
    assert np.cos(world.pose.yaw_rad) == pytest.approx(-1.0, abs=0.01)


def test_a_way_that_no_step_leads_along_is_planned_no_more_until_all_is_tried_again():
    """A gap 0.25 m wide that counts as driven: the way back, too tight for any whole step. Another
    way of the same length as wide as a door is left."""
    grid, cfg = floor(), NavigateConfig()
    x, y = axes(grid)
    wall = (x > 0.2) & (x < 0.6) & ~(np.abs(y) < 0.125) & ~(np.abs(y - 2.0) < 0.45)
    grid.evidence[wall] = 10
    grid.driven[(x > 0.0) & (x < 1.0) & (np.abs(y) < 0.08)] = 1
    grid.changed()
    world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
    world.map = grid

    def left_m(pose: Pose) -> float:
        world.pose, world.seen = pose, look_around(grid, pose, RADIUS_M)
        field = march_from(world.terrain, np.array([1.2, 0.0]), unhurried=False)
        return field.at(pose.x_m, pose.y_m)

    before, inside = Pose(-0.3, 0.0, 0.0), Pose(0.3, 0.0, 0.0)
    straight_m = left_m(before)
    left_m(inside)
    aim = world.pursuit.aim = Aim(AimKind.FRONTIER, 1)
    world.pursuit.progress[aim] = Progress(idle=13.0)
    nowhere = march_from(world.terrain, np.array([0.35, 2.5]))
    local_policy(cfg).drive(world, nowhere)  # no heading leads there
    assert not grid.dead_end[grid.frame.cell(-0.3, 0.0)]
    assert math.isfinite(left_m(inside))  # it can leave, whatever the side
    around_m = left_m(before)
    assert math.isfinite(around_m)
    assert around_m > straight_m + 2.0
    world.frontiers, world.explored.resort = (), Resort.NONE
    navigate._finish(world, cfg)
    assert world.explored.resort is Resort.RETRY
    assert left_m(before) == straight_m


def test_half_a_step_beside_a_place_is_there_unless_a_step_leads_nearer():
    cfg = NavigateConfig()
    smooth = replace(cfg, control=replace(cfg.control, mode="velocity"))
    terrain, reach = look_around(floor(), POSE, RADIUS_M)
    for away_m, yaw_rad, there in ((0.1, 3.0, True), (0.2, 0.0, False), (0.3, 3.0, False)):
        world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
        world.pose, world.seen = Pose(0.0, 0.0, yaw_rad), (terrain, reach)
        field = march_from(terrain, np.array([[away_m, 0.0]]))
        assert local_policy(cfg).arrived(world, field) is there
        assert not local_policy(smooth).arrived(world, field)
    assert local_policy(smooth).arrived(world, march_from(terrain, POSE.xy))


def test_exactly_at_a_place_the_robot_gets_by_a_few_whole_steps():
    """A ring 0.1 m wide round a ball; the robot is too near."""
    cfg = NavigateConfig()
    grid = floor()
    x, y = axes(grid)
    grid.evidence[np.hypot(x - 1.0, y) < 0.12] = 10
    grid.changed()
    world = World.begin("ball", ("ball",), (), POSE, RADIUS_M, 0)
    world.map, world.pose = grid, Pose(0.2, 0.0, 0.0)
    world.seen = look_around(grid, world.pose, RADIUS_M)
    rows, cols = np.indices(world.terrain.frame.shape)
    cells = np.stack([rows.ravel(), cols.ravel()], 1).astype(np.int32)
    xy = world.terrain.frame.centres(cells)
    away_m = np.hypot(xy[:, 0] - 1.0, xy[:, 1])
    field = march_from(world.terrain, xy[(away_m >= 0.9) & (away_m <= 0.98)])
    policy, steps = local_policy(cfg), 0
    assert policy.arrived(world, field)
    world.pursuit.aim = Aim(AimKind.TARGET, 1)
    world.pursuit.progress[world.pursuit.aim] = Progress()
    while not policy.arrived(world, field, exactly=True):
        action, _ = policy.drive(world, field, exactly=True)
        world.pose, steps = moved(world.pose, action), steps + 1
        assert steps < 30
    assert steps > 0
    assert 0.87 <= math.hypot(world.pose.x_m - 1.0, world.pose.y_m) <= 1.01


def test_a_place_that_no_whole_steps_end_at_is_reached_beside_it():
    """The robot stands in a narrow pocket; a step ahead is too near the wall."""
    grid = floor()
    x, y = axes(grid)
    grid.evidence[~((np.abs(y) < 0.3) & (x > -0.3) & (x < 0.42))] = 10
    grid.changed()
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
    world.map, world.seen, world.pose = grid, (terrain, reach), Pose(0.0, 0.0, 3.1)
    field = march_from(terrain, np.array([[0.1, 0.0]]))
    assert 0 < field.at(0.0, 0.0) <= 0.125
    assert local_policy(NavigateConfig()).arrived(world, field, exactly=True)


def moved(pose: Pose, action: Action) -> Pose:
    if action is Action.MOVE_FORWARD:
        x_m, y_m = (
            pose.x_m + 0.25 * math.cos(pose.yaw_rad),
            pose.y_m + 0.25 * math.sin(pose.yaw_rad),
        )
        return replace(pose, x_m=x_m, y_m=y_m)
    turn = TURN_RAD if action is Action.TURN_LEFT else -TURN_RAD
    return replace(pose, yaw_rad=pose.yaw_rad + turn)
