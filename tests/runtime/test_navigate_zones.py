"""The whole loop over a flat-land apartment with zones that the robot is kept out of: its body is
never in one, it finds what can be faced from outside, and it leaves one that it was put in."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment
from open_floor import POSE, RADIUS_M, SPOT, axes, bed, floor

from runtime import navigate
from runtime.core.distances.planner import look_around
from runtime.core.exploration import with_frontiers
from runtime.core.local_policy import GIVE_UP_AFTER, WholeSteps
from runtime.core.mapping.zones import Zone
from runtime.core.resorts import Resort
from runtime.core.types import Action, Ballot, Brief, Pose, SearchState
from runtime.core.world import Command, Mode, World

NAMES, ROOMS, CFG = ("toilet",), ("kitchen", "bedroom", "hallway"), navigate.NavigateConfig()
MODES = {
    "discrete": CFG,
    "velocity": replace(CFG, control=replace(CFG.control, mode="velocity")),
}
Corners = tuple[tuple[float, float], ...]


def box(x0: float, y0: float, x1: float, y1: float) -> Corners:
    return (x0, y0), (x1, y0), (x1, y1), (x0, y1)


class Silent:
    def ask(self, brief: Brief, by: None) -> Ballot:
        return Ballot()


def search(
    home: Apartment,
    zones: tuple[Zone, ...],
    limit: int = 300,
    cfg=CFG,
    world: World | None = None,
    room: str = "",
) -> tuple[World, list[Command], list[Pose]]:
    """Until it stops; where the body was at each step."""
    commands, poses = [], []
    for _ in range(limit):
        obs = home.observe()
        if world is None:
            world = World.begin("toilet", NAMES, ROOMS[: home.room_count], obs.pose, RADIUS_M)
            world.explored.only_room = room
            navigate.keep_out(world, zones)
        navigate.perceive(world, obs, home.detect(NAMES, obs), MOUNT, cfg)
        why = navigate.due(world, cfg)
        if why:
            snap = navigate.snapshot(world, why, cfg)
            navigate.adopt(world, navigate.decide(snap, Silent(), None, cfg))
        command = navigate.steer(world, navigate.act(world, cfg), cfg)
        commands.append(command)
        poses.append(home.pose)
        if command.action is Action.STOP:
            break
        move(home, command)
        if cfg.control.mode == "discrete" and command.action is Action.MOVE_FORWARD:
            poses.append(midway(poses[-1], home.pose))
    assert world is not None
    return world, commands, poses


def move(home: Apartment, command: Command) -> None:
    if command.course is None or command.twist is None:
        home.apply(command.action)
        return
    for _ in range(10):  # an observation each 0.1 s
        home.apply(Action.MOVE_FORWARD, command.twist.v_mps * 0.01)
        home.apply(Action.TURN_LEFT, turn_rad=command.twist.w_radps * 0.01)


def midway(a: Pose, b: Pose) -> Pose:
    return Pose((a.x_m + b.x_m) / 2, (a.y_m + b.y_m) / 2, a.yaw_rad)


def nearest_m(zone: Zone, poses: list[Pose]) -> float:
    return min(zone.outside_m((pose.x_m, pose.y_m)) for pose in poses)


HALL = Zone("the hall", box(0.2, 0.2, 9.8, 1.45))
DOOR = Zone("the door", box(4.2, 2.5, 5.0, 4.0))


def home(x: float = 1.0, y: float = 3.2, yaw: float = 0.0) -> Apartment:
    return Apartment.of(TWO_ROOMS, Pose(x, y, yaw))


def test_the_body_is_never_in_a_zone_and_the_goal_is_found_beside_it():
    there = home(5.3, 2.3)
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    rug = Zone("a rug", box(5.8, 1.9, 6.4, 2.9))  # across the short way
    _, commands, poses = search(there, (rug,), 300)
    assert commands[-1].reason.startswith("found toilet")
    assert RADIUS_M <= nearest_m(rug, poses) < 0.4
    assert there.collisions == 0


def test_what_lies_behind_a_zone_is_not_gone_to():
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    world, commands, poses = search(there, (DOOR, HALL), 200)
    assert commands[-1].reason.startswith("no toilet found and nothing left to explore")
    assert nearest_m(DOOR, poses) >= RADIUS_M
    assert nearest_m(HALL, poses) >= RADIUS_M
    assert max(pose.x_m for pose in poses) < 4.2
    barred = world.map.zones.barred(world.map.frame)
    assert barred[tuple(world.map.frame.cell(4.6, 3.2))]
    assert not (world.explored.boundary.edge & barred).any()


def test_an_area_is_searched_and_nothing_beyond():
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    area = Zone("the area", box(0.2, 1.6, 4.2, 5.0), area=True)
    world, commands, poses = search(there, (area,), 200)
    assert commands[-1].reason.startswith("no toilet found and nothing left to explore")
    assert all(area.outside_m((pose.x_m, pose.y_m)) <= -RADIUS_M for pose in poses)
    assert max(pose.x_m for pose in poses) > 2.5  # it looked round in it
    assert not (world.explored.boundary.edge & world.map.zones.barred(world.map.frame)).any()


def with_rooms() -> Apartment:
    there = home()
    there.rooms = [((0, 1.6, 4.6, 6), 0), ((4.6, 1.6, 11, 6), 1), ((0, 0, 11, 1.6), 2)]
    there.room_count = len(there.rooms)
    return there


def test_only_a_room_of_that_type_is_searched():
    _, commands, poses = search(with_rooms(), (), 200, room="kitchen")
    assert commands[-1].reason.startswith("no toilet found and nothing left to explore")
    assert max(pose.x_m for pose in poses) < 5.5


def test_a_room_that_was_not_seen_yet_is_looked_for_and_then_searched():
    there = with_rooms()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    _, commands, _ = search(there, (), 200, room="bedroom")
    assert commands[-1].reason.startswith("found toilet")


@pytest.mark.slow
def test_such_a_room_is_searched_to_its_end():
    there = with_rooms()
    _, commands, poses = search(there, (), 300, room="bedroom")
    assert commands[-1].reason.startswith("no toilet found and nothing left to explore")
    assert max(pose.x_m for pose in poses) > 6.0


@pytest.mark.parametrize("mode", ["discrete", pytest.param("velocity", marks=pytest.mark.slow)])
def test_a_robot_that_was_put_into_a_zone_leaves_it_by_the_nearest_way(mode: str):
    there = home(2.0, 3.2)
    zone = Zone("a rug", box(1.4, 2.5, 3.6, 4.0))
    world, commands, _ = search(there, (), 14, MODES[mode])
    there.pose = Pose(2.0, 3.2, 0.0)
    world.explored.looks_left = 0
    navigate.keep_out(world, (zone,))
    assert zone.outside_m((2.0, 3.2)) == pytest.approx(-0.6)
    _, commands, poses = search(there, (), 30 if mode == "discrete" else 120, MODES[mode], world)
    depths = [zone.outside_m((pose.x_m, pose.y_m)) for pose in poses]
    out = next(n for n, depth in enumerate(depths) if depth >= RADIUS_M)
    assert all(b >= a - 0.01 for a, b in pairwise(depths[:out]))
    assert (commands[0].mode, commands[0].reason) == (
        Mode.LEAVE, "out of a rug, which is kept out of",
    )  # fmt: skip
    assert min(depths[out:]) >= RADIUS_M - 0.07


def test_a_goal_within_a_zone_is_faced_from_outside():
    grid, zone = floor(), Zone("a mat", box(1.6, -0.4, 2.4, 0.4))
    world = World.begin("bed", ("bed",), (), POSE, RADIUS_M, 0)
    world.map = grid
    row, col = grid.frame.cell(*SPOT)
    grid.evidence[row - 2 : row + 3, col - 2 : col + 3] = 10
    grid.changed()
    world.semantic.instances[1] = bed(Pose(0.0, 0.0, 0.0), Pose(0.0, 1.0, -0.4))
    navigate.keep_out(world, (zone,))
    world.seen = look_around(grid, POSE, RADIUS_M, False, world.survey)
    command = navigate.approach_target(world, CFG)
    assert command is not None
    assert command.mode is Mode.TARGET
    end = command.path_xy[-1]
    assert zone.outside_m((float(end[0]), float(end[1]))) >= RADIUS_M
    assert math.dist(end, SPOT) < 1.3


def on_the_floor(*zones: Zone) -> World:
    world = World.begin("toilet", NAMES, (), POSE, RADIUS_M, 0)
    world.map = floor()
    navigate.keep_out(world, zones)
    return world


def test_what_is_unknown_in_a_zone_is_told_to_no_expert():
    world = on_the_floor(Zone("", box(2.5, -2.0, 6.0, 2.0)))
    with_frontiers(world, CFG)
    seen = navigate.outlook(world, "", CFG)
    barred = world.map.zones.barred(world.map.frame)[
        seen.map.frame.first_row :, seen.map.frame.first_col :
    ][: seen.map.frame.rows, : seen.map.frame.cols]
    assert barred.any()
    assert not (barred & (seen.map.unknown | seen.map.free)).any()
    assert seen.map.unknown.any()
    assert seen.map.free.any()


def test_what_was_seen_only_from_afar_is_not_looked_at_in_a_zone():
    world = on_the_floor(Zone("", box(-2.0, -2.0, -0.5, 2.0)))
    world.explored.looked[:] = True
    low, high = world.map.frame.cell(-1.5, -1.5), world.map.frame.cell(1.5, 1.5)
    world.explored.looked[low[0] : high[0], low[1] : high[1]] = False
    world.explored.resort = Resort.AFAR
    with_frontiers(world, CFG)
    zone = world.map.zones.zones[0]
    assert any(abs(x) < 1 and abs(y) < 1 for f in world.frontiers for x, y in f.cells_xy)
    assert all(zone.outside_m((x, y)) > 0 for f in world.frontiers for x, y in f.cells_xy)


def test_a_wedged_robot_does_not_squeeze_out_into_a_zone():
    """A ring right around the robot, open behind it, where a zone begins."""
    world = on_the_floor()
    x, y = axes(world.map)
    ring = (np.hypot(x, y) > 0.24) & (np.hypot(x, y) < 0.6)
    world.map.evidence[ring & ~((x < 0) & (np.abs(y) < 0.11))] = 20
    world.map.changed()
    world.pose = Pose(0.0, 0.0, math.pi)
    out = []
    for zones in ((), (Zone("", box(-2.0, -1.0, -0.35, 1.0)),)):
        navigate.keep_out(world, zones)
        with_frontiers(world, CFG)
        out.append(WholeSteps(CFG)._unwedge(world, np.zeros((0, 2)), None))
    assert out[0] is Action.MOVE_FORWARD
    assert out[1] is not Action.MOVE_FORWARD


def test_a_robot_that_does_not_get_out_of_a_zone_stops_and_says_so():
    world = on_the_floor(Zone("a rug", box(-1.0, -1.0, 1.0, 1.0)))
    with_frontiers(world, CFG)
    for _ in range(2 * GIVE_UP_AFTER):  # its wheels slip
        command = navigate.act(world, CFG)
        if command.ended is not None:
            break
        assert command.mode is Mode.LEAVE
    assert command.ended is SearchState.UNREACHABLE
    assert command.reason == "the robot does not get out of a rug, which is kept out of"
