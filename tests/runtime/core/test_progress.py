"""An aim that the robot comes no nearer to is given up, and only then."""

import math
from dataclasses import replace

import numpy as np
import pytest
from apartment import INTRINSICS
from open_floor import POSE, RADIUS_M, floor

from runtime.core.distances.planner import look_around, march_from
from runtime.core.local_policy import GIVE_UP_AFTER, GIVE_UP_AFTER_S, local_policy
from runtime.core.motion.contact import Met, Touch
from runtime.core.progress import advance, dithers, led, meet, stalled
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Observation, Pose
from runtime.core.world import NO_AIM, Aim, AimKind, Command, Mode, World


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


def seen(at_s: float, pose: Pose) -> Observation:
    depth = np.full((120, 160), 2.0, np.float32)
    rgb = np.zeros((120, 160, 3), np.uint8)
    return Observation(round(at_s * 1e9), rgb, depth, pose, INTRINSICS)


def test_while_somebody_else_drives_no_time_passes_and_nothing_is_a_collision():
    world, cfg = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0), NavigateConfig()
    cfg = replace(cfg, control=replace(cfg.control, mode="velocity"))
    advance(world, seen(1.0, POSE), cfg)
    advance(world, seen(1.2, POSE), cfg)
    aim, field = Aim(AimKind.FRONTIER, 5), Away(1.0)
    assert not stalled(world, aim, field, cfg)
    there = Pose(3.0, 2.0, 1.0)
    for step in range(40):
        world.body.asked_mps = 0.3
        led(world, seen(1.4 + 0.2 * step, there if step else POSE))
    assert world.body.elapsed_s == pytest.approx(0.2)
    assert world.body.collisions == 0
    assert world.pose == there
    assert world.pursuit.aim == NO_AIM
    assert not stalled(world, aim, Away(9.0), cfg)  # farther than ever: that counts from here
    advance(world, seen(9.4, there), cfg)
    assert world.body.elapsed_s == pytest.approx(0.4)


def test_while_the_base_is_held_nothing_is_an_effort_and_no_look_around_is_over():
    cfg = NavigateConfig()
    cfg = replace(cfg, control=replace(cfg.control, mode="velocity"))
    world, policy = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M), local_policy(cfg)
    advance(world, seen(1.0, POSE), cfg)
    aim, field = Aim(AimKind.FRONTIER, 5), Away(1.0)
    assert not stalled(world, aim, field, cfg)
    world.body.held = True
    for second in range(2, 90):
        advance(world, seen(second, POSE), cfg)
        assert not stalled(world, aim, field, cfg)
    assert policy.looks_on(world)
    world.body.held, waits = False, 0
    while not stalled(world, aim, field, cfg):
        advance(world, seen(90 + waits, POSE), cfg)
        waits += 1
    assert waits == pytest.approx(GIVE_UP_AFTER_S, abs=1)
    while policy.looks_on(world):
        advance(world, seen(90 + waits, POSE), cfg)
        waits += 1
    assert world.body.elapsed_s - world.body.free_s == 88.0


@pytest.mark.parametrize(("touch", "collisions"), [(Touch.BUMPER, 1), (Touch.CLIFF, 0)])
def test_what_was_met_is_an_obstacle_that_no_look_clears(touch: Touch, collisions: int):
    world, cfg = World.begin("toilet", ("toilet",), (), POSE, RADIUS_M, 0), NavigateConfig()
    world.map = floor()
    meet(world, Met(touch, Pose(0.0, 0.0, math.pi / 2), -math.pi / 2), cfg)
    ahead = world.map.frame.cell(RADIUS_M + 0.075, 0.0)
    assert world.map.occupied[ahead]
    assert world.body.collisions == collisions
    world.map.evidence[:] = -20  # floor, however often it is seen
    world.map.changed()
    assert world.map.occupied[ahead]
    beside = world.map.frame.cell(RADIUS_M + 0.075, 0.15)
    assert bool(world.map.occupied[beside]) is (touch is Touch.CLIFF)
    assert not world.map.occupied[world.map.frame.cell(0.0, RADIUS_M + 0.075)]
