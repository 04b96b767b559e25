"""To a place: along what is known, else by exploring; and where no way leads, that is told."""

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from apartment import MOUNT, NO_DETECTIONS, TWO_ROOMS, Apartment
from open_floor import POSE, axes, floor

from runtime import navigate
from runtime.core import destination
from runtime.core.destination import NEAR_M, Destination, into, is_within, left_area
from runtime.core.distances.planner import look_around
from runtime.core.exploration import with_frontiers
from runtime.core.local_policy import GIVE_UP_AFTER
from runtime.core.mapping.zones import Zone
from runtime.core.types import Action, Frontier, Pose, SearchState
from runtime.core.world import Aim, AimKind, Command, Mode, World

CFG, RADIUS_M = navigate.NavigateConfig(), 0.18


def driven(
    home: Apartment,
    to: Destination,
    limit: int = 250,
    world: World | None = None,
    befalls: Callable[[int], None] = lambda step: None,
    **zones: Zone,
) -> tuple[World, list[Command], list[Pose]]:
    commands, poses = [], []
    for step in range(limit):
        befalls(step)
        obs = home.observe()
        if world is None:
            world = World.begin("chair", ("chair",), (), obs.pose, RADIUS_M)
            navigate.keep_out(world, tuple(zones.values()))
        navigate.perceive(world, obs, NO_DETECTIONS, MOUNT, CFG)
        commands.append(navigate.steer(world, navigate.go_to(world, to, CFG), CFG))
        poses.append(home.pose)
        if commands[-1].action is Action.STOP:
            break
        home.apply(commands[-1].action)
    assert world is not None
    return world, commands, poses


def home(x: float = 1.0, y: float = 3.2, yaw: float = 0.0) -> Apartment:
    return Apartment.of(TWO_ROOMS, Pose(x, y, yaw))


def test_a_place_in_view_is_driven_to_at_once_and_looked_as_asked():
    there = home()
    _, commands, poses = driven(there, Destination("the door", (3.5, 3.3), math.pi / 2))
    assert commands[0].mode is Mode.PLACE  # no look around before
    assert (commands[-1].ended, commands[-1].reason) == (
        SearchState.ARRIVED, "arrived at the door",
    )  # fmt: skip
    assert math.dist((poses[-1].x_m, poses[-1].y_m), (3.5, 3.3)) <= NEAR_M
    assert abs(poses[-1].yaw_rad - math.pi / 2) <= math.radians(15) + 1e-6
    assert there.path_m < 3.5


def test_a_place_that_was_never_seen_is_explored_toward():
    there = home(yaw=2.0)
    to = Destination("the sofa", (8.9, 2.2))
    world, commands, _ = driven(there, to)
    assert commands[-1].ended is SearchState.ARRIVED
    assert {c.mode for c in commands} == {Mode.LOOK, Mode.FRONTIER, Mode.PLACE, Mode.STOP}
    assert there.path_m < 14.0  # the way is 8.5 m
    back, again = Destination("the start", (1.0, 3.2)), there.path_m
    world = World.begin_from(world, "chair", ("chair",))
    _, commands, _ = driven(there, back, world=world)
    assert commands[-1].ended is SearchState.ARRIVED
    assert {c.mode for c in commands} <= {Mode.PLACE, Mode.STOP}
    assert there.path_m - again < 10.0


@pytest.mark.parametrize("at", [(8.9, 2.2), (30.0, 3.0)])
def test_where_no_way_leads_that_is_told_when_nothing_is_left_to_explore(at: tuple[float, float]):
    there, wall = home(2.5, 3.2), slice(int(4.4 / 0.02), int(4.6 / 0.02))
    there.heights[:, wall] = 2.5
    _, commands, _ = driven(there, Destination("the sofa", at))
    assert commands[-1].ended is SearchState.UNREACHABLE
    assert commands[-1].reason == (
        "the sofa cannot be reached: no way leads there, and nothing is left to explore"
    )
    assert [c.reason for c in commands if c.mode is Mode.LOOK][-2:] == [
        "retry what was given up before", "go through gaps that look a little too tight",
    ]  # fmt: skip


def test_a_door_that_was_open_before_is_looked_at_again():
    there = home(2.5, 3.2)
    door = slice(int(2.6 / 0.02), int(3.9 / 0.02)), slice(int(4.4 / 0.02), int(4.6 / 0.02))

    def befalls(step: int) -> None:
        if step in (8, 100):
            there.heights[door] = 2.5 if step == 8 else 0.0

    to = Destination("the sofa", (8.9, 2.2))
    _, commands, _ = driven(there, to, 400, None, befalls)
    assert commands[-1].ended is SearchState.ARRIVED
    assert any("open again" in command.reason for command in commands)


def test_a_place_in_a_zone_is_none_to_go_to():
    rug = Zone("rug", ((3.0, 2.4), (4.2, 2.4), (4.2, 4.2), (3.0, 4.2)))
    _, commands, poses = driven(home(), Destination("the rug", (3.6, 3.3)), rug=rug)
    assert "or it is kept out of" in commands[-1].reason
    assert min(rug.outside_m((p.x_m, p.y_m)) for p in poses) >= RADIUS_M


def test_a_place_in_a_zone_far_off_the_map_is_not_explored_toward():
    far = Zone("far", ((20.0, 20.0), (22.0, 20.0), (22.0, 22.0), (20.0, 22.0)))
    for at, kept_out in (((21.0, 21.0), True), ((20.1, 21.0), False)):
        _, commands, _ = driven(home(), Destination("it", at), 20, None, far=far)
        assert any("or it is kept out of" in c.reason for c in commands) == kept_out


def test_a_place_outside_of_the_area_that_is_kept_to_is_kept_out_of():
    area = Zone("", ((0.3, 2.2), (4.2, 2.2), (4.2, 4.4), (0.3, 4.4)), area=True)
    _, commands, _ = driven(home(), Destination("it", (30.0, 3.0)), 20, None, area=area)
    assert "or it is kept out of" in commands[-1].reason


def test_an_area_that_no_robot_fits_into_is_told_without_exploring_all_else():
    slit = Zone("", ((3.0, 3.0), (3.2, 3.0), (3.2, 4.0), (3.0, 4.0)), area=True)
    _, commands, _ = driven(home(), into(slit))
    assert commands[-1].ended is SearchState.UNREACHABLE
    assert commands[-1].reason.endswith("cannot be reached: the robot fits nowhere in it")
    assert not any(command.mode is Mode.FRONTIER for command in commands)


def test_into_an_area_any_place_of_it_will_do_the_nearest():
    area = Zone("", ((3.0, 2.2), (4.2, 2.2), (4.2, 4.4), (3.0, 4.4)), area=True)
    there = home()
    world, commands, _ = driven(there, into(area))
    assert commands[-1].ended is SearchState.ARRIVED
    assert is_within(world, area, CFG)
    assert there.path_m < 2.8
    assert left_area(world, area) is None
    world.pose = Pose(2.75, 3.2, 0.0)
    assert left_area(world, area) is None
    world.pose = Pose(2.6, 3.2, 0.0)
    gone = left_area(world, area)
    assert gone is not None
    assert (gone.action, gone.ended) == (Action.STOP, SearchState.AREA_LEFT)
    assert gone.reason == "the robot is 0.4 m outside of the area of the search"


def test_nothing_is_explored_from_where_no_way_can_lead_to_the_place():
    """It lies in the midst of a ring that is known, on a floor that ends in the unknown."""
    world = World.begin("chair", ("chair",), (), POSE, RADIUS_M, 0)
    world.map = floor()
    x, y = axes(world.map)
    away = np.hypot(x - 1.5, y)
    world.map.evidence[away < 0.8] = 0
    world.map.evidence[(away > 0.6) & (away < 0.8)] = 20
    world.map.changed()
    with_frontiers(world, CFG)
    assert any(math.isfinite(f.distance_m) for f in world.frontiers)
    commands = [navigate.go_to(world, Destination("the pit", (1.5, 0.0)), CFG) for _ in range(3)]
    assert [command.mode for command in commands] == [Mode.LOOK, Mode.LOOK, Mode.STOP]
    assert commands[-1].ended is SearchState.UNREACHABLE


def test_the_robot_does_not_turn_round_for_a_frontier_that_is_hardly_nearer_to_the_place():
    world = World.begin("chair", ("chair",), (), POSE, RADIUS_M, 0)
    world.map = floor()
    left, right = (
        Frontier(id, np.array([[0.0, y]]), (0.0, y), 1.0 + id / 10)
        for id, y in ((1, 2.0), (2, -2.0))
    )
    world.frontiers, to = (left, right), Destination("far", (9.0, 0.0))
    hope: Any = SimpleNamespace(of=lambda cells_xy: True)
    assert destination._nearest(world, to, hope) is left
    world.pursuit.aim = Aim(AimKind.FRONTIER, 2)
    assert destination._nearest(world, to, hope) is right
    world.frontiers = replace(left, distance_m=0.1), right
    assert destination._nearest(world, to, hope) is world.frontiers[0]


def test_an_aim_that_comes_no_nearer_is_given_up():
    world = World.begin("chair", ("chair",), (), POSE, RADIUS_M, 0)
    world.map = floor()
    world.seen = look_around(world.map, POSE, RADIUS_M)
    to = Destination("the door", (2.0, 1.0))
    commands = [navigate.go_to(world, to, CFG) for _ in range(2 * GIVE_UP_AFTER)]
    n = next(n for n, command in enumerate(commands) if command.ended is not None)
    assert GIVE_UP_AFTER / 3 < n <= GIVE_UP_AFTER + 1
    assert {command.mode for command in commands[:n]} == {Mode.PLACE}
    assert commands[n].reason == "the door cannot be reached: the robot comes no nearer"
    assert commands[n].ended is SearchState.UNREACHABLE
