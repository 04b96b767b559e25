"""What a search has come by, as it is told."""

import math

import numpy as np
import pytest
from open_floor import POSE, RADIUS_M, axes, floor

from runtime.core.distances.passages import TriedWay
from runtime.core.inventory import UNREACHED, in_doubt, searched, unreached
from runtime.core.types import Frontier
from runtime.core.world import World


def a_world(*rooms: str) -> World:
    """A floor of 6 x 6 m."""
    world = World.begin("vase", ("vase",), rooms, POSE, RADIUS_M, 0)
    world.map = floor()
    return world


def test_what_was_searched_is_told_in_square_metres_and_by_room():
    world = a_world("kitchen", "bedroom", "bathroom")
    x, _ = axes(world.map)
    world.explored.looked[x < 0.0] = True
    world.semantic.rooms[0][x < 1.0] = 2.0
    world.semantic.rooms[1][x < -1.0] = 3.0  # more evidence than for the kitchen
    told = searched(world)
    assert told["floor_m2"] == pytest.approx(36.0, abs=1.0)
    assert told["near_m2"] == pytest.approx(18.0, abs=0.5)
    assert told["rooms_m2"] == {
        "kitchen": pytest.approx(12.0, abs=0.5), "bedroom": pytest.approx(12.0, abs=0.5)
    }  # fmt: skip


def test_without_words_for_rooms_none_is_told():
    assert searched(a_world())["rooms_m2"] == {}


def test_what_no_way_led_to_is_told_the_widest_first_and_not_without_end():
    world = a_world()
    line = np.stack([np.arange(40) / 10, np.zeros(40)], axis=1)
    shut = [Frontier(id, line[: 7 + id], (0.0, 0.0), math.inf) for id in range(12)]
    world.frontiers = (*shut, Frontier(20, line, (0.0, 0.0), 3.0))
    told = unreached(world)
    assert [place["frontier"] for place in told] == list(range(11, 11 - UNREACHED, -1))
    assert told[0] == {"frontier": 11, "xy": [0.85, 0.0], "cells": 18}


def test_a_way_that_stayed_closed_is_told_before_them():
    world = a_world()
    line = np.zeros((9, 2))
    world.frontiers = (Frontier(4, line, (0.0, 0.0), math.inf),)
    world.explored.passages.tried = [TriedWay(1, (0.0, 0.0)), TriedWay(2, (1.234, 2.0), looks=3)]
    told = unreached(world)
    assert told[0] == {"way": 2, "xy": [1.23, 2.0], "looks": 3}
    assert [place.get("frontier") for place in told] == [None, 4]


def test_where_the_goal_may_still_be_is_told_with_how_it_was_seen():
    world = a_world()
    x, y = axes(world.map)
    table = (np.abs(x - 2.0) < 0.4) & (np.abs(y) < 0.4)
    world.map.evidence[table] = 10
    world.map.changed()
    assert in_doubt(world) == []  # nobody keeps how finely anything was seen
    world.explored.closer.fineness.fit(world.map.frame)
    told = in_doubt(world)
    places = [place["xy"] for place in told]
    assert all(place["seen_m"] is None for place in told)
    assert min(math.hypot(at[0] - 2.0, at[1]) for at in places) < 0.6
    chances = [place["chance"] for place in told]
    assert chances == sorted(chances, reverse=True)
