"""Back to where the search began, along what is known."""

import math

import numpy as np
from open_floor import RADIUS_M, floor

from runtime.core.distances.planner import look_around
from runtime.core.homeward import ARRIVED_M, go_back
from runtime.core.local_policy import GIVE_UP_AFTER
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Pose, SearchState
from runtime.core.world import Mode, World

CFG, START = NavigateConfig(), (2.0, 1.0)


def world(pose: Pose) -> World:
    found = World.begin("toilet", ("toilet",), (), pose, RADIUS_M, 0)
    found.map = floor()
    found.seen = look_around(found.map, pose, RADIUS_M)
    return found


def test_a_robot_drives_back_and_ends_there():
    back = go_back(world(Pose(-2.0, -1.0, 0.0)), "battery", START, CFG)
    assert back.mode is Mode.RETURN
    assert back.ended is None
    assert back.toward_xy == START
    assert math.dist(back.path_xy[-1], START) < 0.1
    there = go_back(world(Pose(START[0] - ARRIVED_M / 2, START[1], 0.0)), "battery", START, CFG)
    assert (there.action, there.ended) == (Action.STOP, SearchState.ARRIVED)
    assert there.reason == "battery; it is back where it began"


def test_where_no_way_leads_back_it_ends_where_it_is():
    found = world(Pose(-2.0, -1.0, 0.0))
    _, middle = found.map.frame.cell(0.0, 0.0)
    found.map.evidence[:, middle - 1 : middle + 1] = 20
    found.map.changed()
    found.seen = look_around(found.map, found.pose, RADIUS_M)
    commands = [go_back(found, "battery", START, CFG) for _ in range(2 * GIVE_UP_AFTER)]
    ended = [n for n, command in enumerate(commands) if command.ended is not None]
    assert GIVE_UP_AFTER / 2 < ended[0] <= GIVE_UP_AFTER + 1
    assert commands[ended[0]].reason == "battery; there is no way back to where it began"
    assert commands[ended[0]].ended is SearchState.UNREACHABLE
    assert np.isfinite(commands[0].path_xy).all()
