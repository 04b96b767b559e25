"""Where the goal was said to be is looked at first, once."""

import math

import numpy as np
import pytest
from open_floor import POSE, RADIUS_M, floor

from runtime import navigate
from runtime.core.hinted import PLACES, THINGS, look_where_said
from runtime.core.mapping.coverage import NEAR_M
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.types import Action, Hint, Pose
from runtime.core.world import Command, Mode, World

CFG = navigate.NavigateConfig()
FAR = Pose(-2.0, 0.0, 0.0)  # from where the things were seen
ROOMS = ("kitchen", "bedroom")


def world(hint: Hint, *things: Instance) -> World:
    found = World.begin("mug", ("mug", "table"), ROOMS, POSE, RADIUS_M, 0)
    found.map = floor(4.0)
    for thing in things:
        cells = found.map.frame.cells(thing.cells_xy)
        found.map.evidence[tuple(cells.T)] = 20
        found.semantic.instances[thing.id] = thing
    found.map.changed()
    found.explored.looked[:] = True
    found.explored.hint = hint
    navigate.with_frontiers(found, CFG)
    return found


def table(id: int, x_m: float, y_m: float, odds: float = 4.0, range_m: float = 3.0) -> Instance:
    side = np.arange(-0.3, 0.3, 0.05) + 0.025
    cells = np.stack(np.meshgrid(x_m + side, y_m + side), axis=-1).reshape(-1, 2)
    known = Evidence(odds, backing=[FAR], near_m=range_m)
    return Instance(
        id, {"table": known}, (x_m, y_m), 0.6, cells, 0.5, 0.75, range_m=range_m, views=[FAR]
    )


def driven(found: World, most: int = 120) -> list[Command]:
    """Step by step, until nothing more is looked at."""
    said: list[Command] = []
    while (command := look_where_said(found, CFG)) is not None and len(said) < most:
        said.append(command)
        at, turn = found.pose, {Action.TURN_LEFT: 1, Action.TURN_RIGHT: -1}.get(command.action, 0)
        ahead_m = 0.25 if command.action is Action.MOVE_FORWARD else 0.0
        x, y = at.x_m + ahead_m * math.cos(at.yaw_rad), at.y_m + ahead_m * math.sin(at.yaw_rad)
        found.pose = Pose(x, y, math.remainder(at.yaw_rad + turn * math.pi / 6, math.tau))
        found.body.elapsed_s += 0.5
        gap = np.hypot(*(_cells_xy(found) - found.pose.xy).transpose(2, 0, 1))
        found.explored.looked[gap < NEAR_M] = True
        navigate.with_frontiers(found, CFG)
    return said


def _cells_xy(found: World) -> np.ndarray:
    cells = np.stack(np.indices(found.map.frame.shape), axis=-1).astype(np.int32)
    return found.map.frame.centres(cells)


def test_of_two_tables_the_nearer_is_looked_at_first_and_each_once():
    found = world(Hint(near=("table",)), table(1, -3.0, 1.0), table(2, 2.0, 0.5))
    said = driven(found)
    order = list(dict.fromkeys(command.toward_xy for command in said))
    assert order == [(2.0, 0.5), (-3.0, 1.0)]
    assert said[0].reason == "go and look near table 2, as was said"
    assert said[0].mode is Mode.FRONTIER
    assert said[-1].mode is Mode.FACE
    assert found.explored.hint.visited == {1, 2}
    assert look_where_said(found, CFG) is None


def test_what_was_not_said_is_not_gone_to():
    assert look_where_said(world(Hint(), table(1, 2.0, 0.5)), CFG) is None
    assert look_where_said(world(Hint(near=("bed",)), table(1, 2.0, 0.5)), CFG) is None


@pytest.mark.parametrize(
    "thing",
    [
        table(1, 2.0, 0.5, odds=0.1),
        table(1, 2.0, 0.5, range_m=1.0),
        table(1, 8.0, 0.0),
    ],
    ids=["hardly believed", "seen from near", "out of reach"],
)
def test_no_way_is_gone_for_it(thing: Instance):
    assert look_where_said(world(Hint(near=("table",)), thing), CFG) is None


def test_what_an_earlier_search_saw_from_near_is_looked_at_again():
    hint = Hint(near=("table",), before=frozenset({1}))
    assert look_where_said(world(hint, table(1, 2.0, 0.5, range_m=1.0)), CFG) is not None


def test_no_more_than_some_are_visited():
    hint = Hint(near=("table",), visited=set(range(10, 10 + THINGS)))
    assert look_where_said(world(hint, table(1, 2.0, 0.5)), CFG) is None


def test_one_that_cannot_be_stood_before_is_left_alone():
    thing = table(1, 2.0, 0.5)
    thing.views[:] = []  # seen from nowhere
    found = world(Hint(near=("table",)), thing)
    assert look_where_said(found, CFG) is None
    assert found.explored.hint.visited == {1}


def test_one_that_comes_no_nearer_is_left_alone():
    found = world(Hint(near=("table",)), table(1, 2.0, 0.5))
    for _ in range(99):
        if look_where_said(found, CFG) is None:
            break
    assert found.explored.hint.visited == {1}


def in_kitchen(hint: Hint) -> World:
    """A kitchen beyond x = 2, which was seen only from afar."""
    found = world(hint)
    beyond = _cells_xy(found)[..., 0] > 2.0
    found.semantic.rooms[0, beyond] = 1.0
    found.semantic.rooms[1, ~beyond] = 1.0
    found.explored.looked[beyond] = False
    return found


def test_a_room_is_looked_through_and_then_no_more():
    found = in_kitchen(Hint(rooms=("kitchen",)))
    said = driven(found)
    assert said[0].reason == "go and look through the kitchen, as was said"
    assert said[0].toward_xy == pytest.approx((3.0, 0.0), abs=0.1)
    assert found.pose.x_m > 0.5
    assert found.explored.hint.places == 1
    found.explored.looked[:] = True
    found.body.elapsed_s += 9.0
    assert look_where_said(found, CFG) is None


def test_another_place_is_asked_for_now_and_then():
    found = in_kitchen(Hint(rooms=("kitchen",)))
    driven(found)
    found.explored.hint.asked_s = found.body.elapsed_s
    assert look_where_said(found, CFG) is None  # a moment later
    found.body.elapsed_s += 9.0
    assert look_where_said(found, CFG) is not None
    assert found.explored.hint.places == 2


def test_of_a_room_no_more_than_some_places_are_visited():
    assert look_where_said(in_kitchen(Hint(rooms=("kitchen",), places=PLACES)), CFG) is None


@pytest.mark.parametrize("rooms", [("bedroom",), ("cellar",)])
def test_another_room_is_none(rooms: tuple[str, ...]):
    assert look_where_said(in_kitchen(Hint(rooms=rooms)), CFG) is None


def test_within_a_room_that_alone_is_searched_nothing_is_looked_for_elsewhere():
    found = world(Hint(near=("table",)), table(1, 2.0, 0.5))
    found.explored.only_room = "bedroom"
    assert look_where_said(found, CFG) is None


def test_it_comes_after_the_target_and_before_the_next_frontier():
    found = world(Hint(near=("table",)), table(1, 2.0, 0.5))
    assert navigate.act(found, CFG).reason == "go and look near table 1, as was said"
