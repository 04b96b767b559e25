"""A wedged robot gets out, what stands on a table can be reached, and what was seen only from afar
is gone to before the search ends."""

import math
from dataclasses import replace

import numpy as np
import pytest

from runtime import navigate
from runtime.core.approach import approach_target
from runtime.core.distances.planner import look_around, march_from, survey
from runtime.core.exploration import with_frontiers
from runtime.core.local_policy import GIVE_UP_AFTER, local_policy
from runtime.core.mapping.coverage import look, overlooked
from runtime.core.mapping.grid import NavigationMap
from runtime.core.motion.discrete_policy import TURN_RAD
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.objects.standpoints import standpoints
from runtime.core.progress import dithers, stalled
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Pose
from runtime.core.world import Aim, AimKind, Command, Mode, Progress, Resort, World

POSE, RADIUS_M = Pose(0.0, 0.0, 0.0), 0.18
VASE_XY = np.array([[1.525, 0.025]])


def floor(half_m: float = 3.0) -> NavigationMap:
    """A square of free floor around the robot."""
    grid = NavigationMap.around(POSE, RADIUS_M)
    x, y = axes(grid)
    grid.evidence[(np.abs(x) < half_m) & (np.abs(y) < half_m)] = -10
    grid.changed()
    return grid


def axes(grid: NavigationMap) -> tuple[np.ndarray, np.ndarray]:
    frame = grid.frame
    rows, cols = np.indices(frame.shape)
    xy = frame.centres(np.stack([rows.ravel(), cols.ravel()], 1).astype(np.int32))
    return xy[:, 0].reshape(frame.shape), xy[:, 1].reshape(frame.shape)


def walled_in(gap_m: float) -> NavigationMap:
    """A ring of obstacles 0.5 m around the robot, with one gap ahead of it."""
    grid = floor()
    x, y = axes(grid)
    ring = (np.hypot(x, y) > 0.5) & (np.hypot(x, y) < 0.62) & ~((x > 0) & (np.abs(y) < gap_m / 2))
    grid.evidence[ring] = 10
    grid.changed()
    return grid


def area_m2(arrival: np.ndarray) -> float:
    return float(np.isfinite(arrival).sum()) * 0.05**2


def test_a_wedged_robot_is_let_through_a_gap_a_cell_too_tight():
    grid = walled_in(0.34)
    plain = march_from(survey(grid, POSE, RADIUS_M), POSE.xy, unhurried=False)
    assert area_m2(plain.arrival_m) < 1.5
    _, reach = look_around(grid, POSE, RADIUS_M)
    assert area_m2(reach.arrival_m) > 10.0


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


def test_as_a_last_resort_gaps_may_be_a_little_too_tight_everywhere():
    """In a wall 2 m ahead of a robot that is not wedged; it is 0.36 m wide."""
    for gap_m, let_through in ((0.39, True), (0.29, False)):
        grid = floor()
        x, y = axes(grid)
        grid.evidence[(np.abs(x - 2.0) < 0.06) & ~(np.abs(y) < gap_m / 2)] = 10
        grid.changed()
        beyond_m2 = []
        for tight in (False, True):
            terrain, reach = look_around(grid, POSE, RADIUS_M, tight)
            xs = terrain.frame.x0_m + (np.arange(terrain.frame.cols) + 0.5) * 0.05
            beyond_m2.append(area_m2(reach.arrival_m[:, xs > 2.1]))
        assert beyond_m2[0] == 0.0
        assert (beyond_m2[1] > 2.0) is let_through


def test_it_is_not_let_through_a_gap_it_cannot_fit():
    _, reach = look_around(walled_in(0.15), POSE, RADIUS_M)
    assert area_m2(reach.arrival_m) < 1.5


def test_free_ground_is_planned_over_as_always():
    grid = floor()
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    plain = survey(grid, POSE, RADIUS_M)
    assert terrain.speed.tolist() == plain.speed.tolist()
    assert area_m2(reach.arrival_m) > 20.0


def test_a_vase_amid_a_table_can_be_stood_before():
    grid = floor()
    x, y = axes(grid)
    grid.evidence[(np.abs(x - 1.5) < 0.5) & (np.abs(y) < 0.8)] = 10  # the table top
    grid.changed()
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    vase = Instance(
        1, {"vase": Evidence(4.0)}, (1.5, 0.0), 0.9, np.array([[1.525, 0.025]]), views=[POSE]
    )
    stands = standpoints(grid, terrain, reach, vase, "vase")
    assert stands.any()
    rows, cols = np.nonzero(stands)
    ahead = terrain.frame.centres(np.stack([rows, cols], 1).astype(np.int32))
    assert (ahead[:, 0] < 1.0).all()  # on the side it was seen from


def test_nothing_is_looked_at_through_a_wall():
    """A toilet against a thin wall, once seen from over there: not from this side."""
    grid = floor()
    x, y = axes(grid)
    grid.evidence[(np.abs(x - 1.0) < 0.05) & (y < 1.0)] = 10
    grid.changed()
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    cells = np.array([[1.075, 0.025], [1.125, -0.025], [1.175, 0.025], [1.275, 0.025]])
    seen_from = Pose(1.2, 1.5, -1.5)
    toilet = Instance(1, {"toilet": Evidence(4.0)}, (1.25, 0.0), 0.4, cells, views=[seen_from])
    stands = standpoints(grid, terrain, reach, toilet, "toilet")
    assert stands.any()
    rows, cols = np.nonzero(stands)
    ahead = terrain.frame.centres(np.stack([rows, cols], 1).astype(np.int32))
    assert (ahead[:, 0] > 1.0).all()


def test_what_is_out_of_near_range_stays_overlooked():
    grid = floor()
    looked = np.zeros(grid.frame.shape, bool)
    outline = np.array([[-2.0, 0.0], [2.9, -1.0], [2.9, 1.0]])  # from the left, nearly 5 m deep
    look(looked, grid.frame, outline)
    left = overlooked(grid, looked, np.zeros(grid.frame.shape, bool))
    near, far = grid.frame.cell(-0.5, 0.0), grid.frame.cell(1.5, 0.0)
    assert looked[near]
    assert not left[near]
    assert left[far]


def test_facing_a_point_that_jumps_with_the_view_comes_to_an_end():
    cfg = NavigateConfig()
    world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
    world.body.last = Command(Action.TURN_LEFT, Mode.FACE, None, "")
    face = Aim(AimKind.FACE, 1)
    assert dithers(world, face, Action.TURN_RIGHT, cfg)
    assert not dithers(world, face, Action.TURN_LEFT, cfg)
    turns = 0
    while not dithers(world, face, Action.TURN_LEFT, cfg):
        turns += 1
    assert 12 <= turns <= 24  # a whole turn is allowed, two are not


class Away:
    """A field whose only answer is how far its source is."""

    def __init__(self, left_m: float) -> None:
        self.left_m = left_m

    def at(self, x_m: float, y_m: float) -> float:
        return self.left_m


def given_up(world: World, aim: Aim, left_m: float) -> bool:
    return stalled(world, aim, Away(left_m), NavigateConfig())


def test_turning_to_and_fro_between_two_aims_comes_to_an_end():
    """Each step of the one leads away from the other, so that neither is ever idle for long."""
    world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
    for step in range(100):
        near, far = 1.0 + step % 3 * 0.25, 2.0 - step % 3 * 0.25
        aim, left = (
            (Aim(AimKind.TARGET, 1), near) if step // 3 % 2 else (Aim(AimKind.FRONTIER, 5), far)
        )
        if given_up(world, aim, left):
            break
    assert 20 < step < 60


def test_an_aim_is_gone_back_to_as_long_as_the_robot_comes_nearer_to_it():
    world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
    for turn in range(30):
        assert not given_up(world, Aim(AimKind.TARGET, 1), 10.0 - 0.3 * turn)
        assert not given_up(world, Aim(AimKind.FRONTIER, 5), 20.0 - 0.3 * turn)
    for step in range(40):  # a long way back to the first, of which no step is idle
        assert not given_up(world, Aim(AimKind.TARGET, 1), 12.0 - 0.25 * step)


def test_what_was_given_up_is_tried_from_the_start():
    world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
    waits = [0, 0]
    for again in (0, 1):
        while not given_up(world, Aim(AimKind.FRONTIER, 5), 3.0):
            waits[again] += 1
    assert waits[0] == waits[1] > GIVE_UP_AFTER


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


def test_at_the_very_last_what_was_faintly_like_it_is_looked_at():
    """It is worth no detour before everything else was tried."""
    cfg = NavigateConfig()
    world = World.begin("vase", ("vase",), (), POSE, RADIUS_M, 0)
    world.map = floor()
    faint = Instance(
        1, {"vase": Evidence(-2.0)}, (1.5, 0.0), 0.9, np.array([[1.525, 0.025]]), views=[POSE]
    )
    world.semantic.instances[1] = faint
    world.explored.given_up[:] = True  # no frontier is left
    with_frontiers(world, cfg)
    said = []
    while not said or said[-1].mode == "look":
        said.append(navigate._finish(world, cfg))
        world.explored.given_up[:] = True
        with_frontiers(world, cfg)
    assert [command.reason for command in said[:-1]] == [
        r.reason for r in Resort if r is not Resort.NONE
    ]
    assert said[-1].reason.startswith("inspect vase 1")
    world.semantic.instances.clear()
    assert navigate._finish(world, cfg).mode == "stop"


def test_a_plan_through_a_tight_place_is_forgotten_with_its_aim():
    cfg = NavigateConfig()
    world = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0)
    world.map, world.seen = floor(), look_around(floor(), POSE, RADIUS_M)
    field = march_from(world.terrain, np.array([2.0, 0.0]))
    here, there = Aim(AimKind.FRONTIER, 1), Aim(AimKind.FRONTIER, 2)
    assert not stalled(world, here, field, cfg)
    world.pursuit.progress[here].plan = (Action.TURN_LEFT, Action.MOVE_FORWARD)
    assert not stalled(world, here, field, cfg)
    assert local_policy(cfg).drive(world, field)[0] is Action.TURN_LEFT
    assert world.pursuit.progress[here].plan == (Action.MOVE_FORWARD,)
    assert not stalled(world, there, field, cfg)
    assert not stalled(world, here, field, cfg)
    assert world.pursuit.progress[here].plan == ()


def test_the_table_before_a_sofa_is_not_stopped_at_for_the_sofa():
    """The robot stands before the table, whose cells were taken for a part of the sofa."""
    cfg, grid = NavigateConfig(), floor()
    x, y = axes(grid)
    table, sofa = ((x > low) & (x < low + 0.4) & (np.abs(y) < 0.4) for low in (0.6, 1.7))
    grid.evidence[table | sofa] = 10
    grid.changed()
    before, behind = (np.stack([x[at], y[at]], 1) for at in (table, sofa))
    world = World.begin("sofa", ("sofa", "coffee table"), (), POSE, RADIUS_M, 0)
    world.map, world.seen = grid, look_around(grid, POSE, RADIUS_M)
    both = np.concatenate([before, behind])
    views = [POSE, Pose(1.9, -2.0, 1.5)]
    believed = {"sofa": Evidence(4.0, backing=views, near_m=1.0)}
    target = Instance(1, believed, (1.9, 0.0), 0.4, both, 0.0, 0.8, views=[POSE])
    world.semantic.instances[1] = target
    alone = approach_target(world, cfg)
    assert alone is not None
    assert alone.mode == "stop"  # it believes to be there
    other = Instance(2, {"coffee table": Evidence(4.0)}, (0.8, 0.0), 0.3, before, 0.0, 0.45)
    world.semantic.instances[2] = other
    command = approach_target(world, cfg)
    assert command is not None
    assert command.mode == "target"
