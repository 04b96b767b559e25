"""Searches on a plan of three rooms: they begin fairly, explore, and end where the goal is seen."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from plan_of_rooms import three_rooms

from hil_sim.expert_bench.flat_home import CELL_M, EDGE_M, flat_home
from hil_sim.expert_bench.flat_search import (
    LEAST_WAY_M,
    FlatResult,
    FlatTask,
    behind_m2,
    drive,
    task_in,
)
from runtime.core.types import Ballot, Decision

HOME = flat_home(three_rooms())
BEDROOM = (int((3.4 + EDGE_M) / CELL_M), int((2.6 + EDGE_M) / CELL_M))
TASK = FlatTask("toilet", BEDROOM, 0.0, float(HOME.way_m("toilet")[BEDROOM]))


def nearest(search, frontiers, unknown_m2):
    best = min(frontiers, key=lambda f: f.distance_m)
    return Decision(best.id, "closest", (), best.id, Ballot(), 0, "")


def test_a_start_is_some_way_off_and_does_not_see_the_goal():
    task = task_in(HOME, "toilet", 3)
    assert task is not None
    assert task.shortest_m >= LEAST_WAY_M
    there = np.array(HOME.wanted("toilet"))
    assert not HOME.in_view(HOME.middle(task.start), task.heading_rad, there).any()
    assert task_in(HOME, "toilet", 3) == task
    assert task_in(HOME, "piano", 3) is None


def test_the_goal_is_found_three_rooms_on_and_the_same_way_each_time():
    first, again = drive(HOME, TASK, nearest), drive(HOME, TASK, nearest)
    assert first == again
    assert first.found
    assert first.path_m >= 0.9 * first.shortest_m
    assert 0.3 < first.spl <= 1.0
    assert first.decisions > 5


def test_what_may_be_gone_to_can_be_reached_and_has_something_behind_it():
    asked = []

    def watched(search, frontiers, unknown_m2):
        asked.append((search, frontiers, unknown_m2))
        for f in frontiers:
            assert math.isfinite(f.distance_m)
            assert unknown_m2[f.id] > 0
            row, col = search.frame.cell(*f.goal_xy)
            assert search.terrain.traversable[row, col]
        return nearest(search, frontiers, unknown_m2)

    drive(HOME, TASK, watched)
    ids = [{f.id for f in frontiers} for _, frontiers, _ in asked]
    assert any(a & b for a, b in pairwise(ids))  # ids last
    search = asked[-1][0]
    assert search.known[HOME.free].mean() > 0.5


def test_what_was_said_of_frontiers_is_remembered_while_they_are_there():
    before = []

    def said_once(search, frontiers, unknown_m2):
        standing, ids = search.decision, set(search.memory.cells_xy)
        if standing is not None:
            before.append((set(standing.said["o2f"]), ids))
        said = {} if standing else {"o2f": dict.fromkeys(ids, 1.0)}
        return replace(nearest(search, frontiers, unknown_m2), said=said)

    drive(HOME, TASK, said_once)
    assert before[1][0]
    assert all(now == old & there for (old, there), (now, _) in pairwise(before))
    assert len(before[-1][0]) < len(before[0][0])  # some are gone


def test_a_home_without_the_goal_is_looked_through_and_given_up():
    task = FlatTask("piano", BEDROOM, 0.0, 5.0)
    result = drive(HOME, task, nearest)
    assert not result.found
    assert result.spl == 0.0


def test_unknown_floor_is_counted_as_far_as_one_can_walk():
    unknown = np.zeros((60, 60), bool)
    unknown[:, 31:] = True
    cells = np.array([[row, 30] for row in range(25, 35)], np.int32)
    assert 1.5 < behind_m2(unknown, cells) < 9.0
    unknown[:, 33] = False
    assert behind_m2(unknown, cells) < 0.02 * 60


def test_spl_is_the_shortest_way_over_the_driven():
    assert FlatResult(True, 10.0, 5.0, 1).spl == 0.5
    assert FlatResult(True, 4.0, 5.0, 1).spl == 1.0
    assert FlatResult(False, 4.0, 5.0, 1).spl == pytest.approx(0.0)
