"""The order of frontiers against all orders there are, and how they lie to one another on a map."""

from itertools import pairwise, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.belief import Ahead
from runtime.core.distances.terrain import Terrain
from runtime.core.geometry import GridFrame
from runtime.core.types import Ballot, Decision, Frontier
from runtime.core.voting.search_order import (
    MARCHED,
    MOST,
    STEADY,
    ahead_of,
    ordered,
    soonest,
    with_ways,
)

PLACE = st.tuples(st.floats(0.1, 9.0), st.floats(0.1, 9.0))
PLACES = st.lists(st.tuples(st.floats(0.01, 5.0), PLACE), min_size=1, max_size=5)


def ways(places: np.ndarray, here: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    return np.hypot(*(places - here).T), np.hypot(*np.moveaxis(places[:, None] - places, -1, 0))


def mean_way(order: tuple[int, ...], mass, first_m, between_m) -> float:
    """Of what is found in this order, weighed by where it is."""
    along = [first_m[order[0]], *(between_m[a, b] for a, b in pairwise(order))]
    return float(np.array([mass[i] for i in order]) @ np.cumsum(along))


@given(PLACES)
def test_no_other_order_finds_it_sooner(places):
    mass = np.array([m for m, _ in places])
    first_m, between_m = ways(np.array([xy for _, xy in places]), (5.0, 5.0))
    order = soonest(mass, first_m, between_m)
    every = permutations(range(len(places)))
    best = min(mean_way(o, mass, first_m, between_m) for o in every)
    assert sorted(order) == list(range(len(places)))
    assert mean_way(order, mass, first_m, between_m) == pytest.approx(best)


def test_what_lies_on_the_way_is_looked_behind_first():
    """One step alone would go by it: 1.0 m2 at 2 m, 6 m2 at 3 m the other way round the corner."""
    first_m, between_m = ways(np.array([(2.0, 0.0), (3.0, 0.0), (-2.5, 0.0)]), (0.0, 0.0))
    assert soonest(np.array([0.5, 6.0, 5.0]), first_m, between_m) == (0, 1, 2)
    assert soonest(np.array([0.5, 1.0, 9.0]), first_m, between_m)[0] == 2


def test_nothing_to_choose_from_is_an_empty_order():
    assert soonest(np.zeros(0), np.zeros(0), np.zeros((0, 0))) == ()


@pytest.mark.parametrize(("gain", "first"), [(0.5 * STEADY, 0), (2.0 * STEADY, 1)])
def test_where_one_was_going_is_kept_unless_another_saves_a_good_part(gain: float, first: int):
    """Two places to either side of the same worth: the second is nearer, which saves that part."""
    near_m = 3.0
    first_m = np.array([near_m * (1 + 4 * gain), near_m])
    between_m = first_m.sum() * (1 - np.eye(2))
    assert soonest(np.ones(2), first_m, between_m) == (1, 0)
    assert soonest(np.ones(2), first_m, between_m, keep=0)[0] == first


def line(n: int, standing: int | None = None) -> Ahead:
    """So many frontiers of one worth, a metre apart in a line that begins at the robot."""
    x = np.arange(1.0, n + 1)
    at = tuple((float(each), 0.0) for each in x)
    ids = tuple(range(1, n + 1))
    return Ahead(ids, at, (1.0,) * n, np.ones(n), x, np.abs(x[:, None] - x), standing)


def test_evidence_turns_the_order_round():
    far_m = np.array([1.0, 2.0])  # one to the left, one to the right
    sides = Ahead(
        (1, 2), ((-1.0, 0.0), (2.0, 0.0)), (1.0, 1.0), np.ones(2), far_m, 3.0 - 3.0 * np.eye(2)
    )
    assert ordered(sides, {}) == (1, 2)
    assert ordered(sides, {2: 2.0}) == (2, 1)
    assert ordered(sides, {2: 2.0, 1: 2.0}) == (1, 2)


def test_of_many_the_best_are_ordered_and_the_others_come_last():
    order = ordered(line(MARCHED), {1: -8.0})
    assert sorted(order) == list(range(1, MARCHED + 1))
    assert order[MOST - 1 :] == (9, 10, 11, 12, 1)


def test_what_is_driven_to_is_among_those_that_are_ordered():
    order = ordered(line(MARCHED, standing=MARCHED), {})
    assert order.index(MARCHED) < MOST


def corridor(length_m: float) -> Terrain:
    """Passable cells of 0.1 m, 0.5 m wide, with a wall across the middle."""
    frame = GridFrame(0.0, 0.0, 0.1, 5, round(length_m / 0.1))
    passable = np.ones(frame.shape, bool)
    passable[:, frame.cols // 2] = False
    return Terrain(frame, passable.astype(np.float32), passable, passable.astype(np.float32))


def test_ways_are_measured_on_foot_and_lead_by_the_robot_where_none_is_known():
    at = {1: (0.55, 0.25), 2: (2.55, 0.25), 3: (4.55, 0.25)}
    frontiers = [Frontier(i, np.zeros((1, 2)), xy, 3.0 * i) for i, xy in at.items()]
    stood = Decision(2, "ahead", (), 2, Ballot(), 0, "", said={"r2f": {2: 1.0}})
    area = dict.fromkeys(at, 1.0)
    ahead = with_ways(ahead_of(frontiers, area, area, stood), corridor(6.0))
    assert ahead.ids == (1, 2, 3)
    assert ahead.between_m[0, 1] == pytest.approx(2.0, abs=0.05)
    assert ahead.between_m[1, 2] == 15.0  # back to the robot, and on: the wall is between them
    assert np.array_equal(ahead.between_m, ahead.between_m.T)
    assert (ahead.standing, ahead.before) == (2, stood.said)


def test_one_that_is_off_the_terrain_is_reached_by_where_the_robot_is():
    away = Frontier(7, np.zeros((1, 2)), (-50.0, 0.0), 20.0)
    near = Frontier(8, np.zeros((1, 2)), (0.55, 0.25), 1.0)
    area = {7: 1.0, 8: 1.0}
    ahead = with_ways(ahead_of([near, away], area, area, None), corridor(3.0))
    assert ahead.ids == (8, 7)
    assert ahead.between_m.tolist() == [[0.0, 21.0], [21.0, 0.0]]


def test_ways_are_measured_from_the_best_alone():
    xs = np.linspace(0.35, 5.65, MARCHED + 3)
    many = [Frontier(n, np.zeros((1, 2)), (float(x), 0.25), 1.0) for n, x in enumerate(xs)]
    area = {f.id: 1.0 for f in many}
    ahead = with_ways(ahead_of(many, area, area, None), corridor(6.0))
    assert ahead.ids == tuple(range(MARCHED))
    assert ahead.between_m.shape == (MARCHED, MARCHED)
    assert len(ahead.mass) == len(ahead.first_m) == len(ahead.at_xy) == MARCHED
