"""Plans: curved walls, rooms to the walls' middles, rooms that nobody drew."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.scenes.format import Wall, polygon_area
from hil_sim.scenes.sweethome.plan import arc, beside, is_inner, to_middles, undrawn_rooms

SQUARE = [
    Wall((0, 0), (4, 0), 0.2), Wall((4, 0), (4, 3), 0.2), Wall((4, 3), (0, 3), 0.2),
    Wall((0, 3), (0, 0), 0.2),
]  # fmt: skip
coordinate = st.floats(-20, 20)


def test_a_half_circle_bulges_to_the_left() -> None:
    points = arc((0, 0), (2, 0), math.pi)
    assert max(y for _, y in points) == pytest.approx(1.0, abs=0.01)
    assert all(math.dist(p, (1, 0)) == pytest.approx(1.0) for p in points)
    assert min(y for _, y in arc((0, 0), (2, 0), -math.pi)) == pytest.approx(-1.0, abs=0.01)


@given(coordinate, coordinate, coordinate, coordinate, st.floats(-6.0, 6.0))
def test_an_arc_lies_on_a_circle_and_turns_as_told(
    x0: float, y0: float, x1: float, y1: float, turn: float
) -> None:
    start, end = (x0, y0), (x1, y1)
    points = arc(start, end, turn)
    assert (points[0], points[-1]) == (start, end)
    if len(points) < 4 or math.dist(start, end) < 0.01:
        return
    steps = [math.dist(a, b) for a, b in pairwise(points)]
    assert max(steps) == pytest.approx(min(steps), rel=1e-3)
    ways = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(points)]
    bends = [math.remainder(b - a, math.tau) for a, b in pairwise(ways)]
    assert sum(bends) == pytest.approx(-turn * (len(steps) - 1) / len(steps), abs=1e-3)


def test_a_room_drawn_to_the_faces_reaches_the_middles() -> None:
    moved = to_middles(((0.1, 0.1), (3.9, 0.1), (3.9, 2.9), (0.1, 2.9)), SQUARE)
    assert {(round(x, 6) + 0, round(y, 6) + 0) for x, y in moved} == {
        (0, 0),
        (4, 0),
        (4, 3),
        (0, 3),
    }


def test_an_edge_in_the_open_stays() -> None:
    moved = to_middles(((0.1, 0.1), (2.0, 0.1), (2.0, 2.9), (0.1, 2.9)), SQUARE)
    assert max(x for x, _ in moved) == 2.0
    assert polygon_area(moved) == pytest.approx(6.0)


@given(st.lists(st.tuples(coordinate, coordinate), min_size=3, max_size=8))
def test_any_outline_stays_an_outline(points: list[tuple[float, float]]) -> None:
    before = polygon_area(tuple(points))
    moved = to_middles(tuple(points), SQUARE)
    assert len(moved) >= 3
    assert 0.9 * before - 1e-9 <= polygon_area(moved) <= 2 * before + 0.5
    assert all(math.isfinite(v) for p in moved for v in p)


def test_enclosed_space_becomes_rooms_and_drawn_rooms_are_left() -> None:
    walls = [*SQUARE, Wall((2, 0), (2, 3), 0.1)]
    both = undrawn_rooms(walls, [])
    assert sorted(round(polygon_area(p), 1) for p in both) == [6.0, 6.0]
    (right,) = undrawn_rooms(walls, [((0, 0), (2, 0), (2, 3), (0, 3))])
    assert min(x for x, _ in right) == pytest.approx(2.0, abs=0.01)


def test_a_doorless_gap_leaves_nothing_enclosed() -> None:
    assert undrawn_rooms(SQUARE[:3], []) == []
    nearly = [*SQUARE[:3], Wall((0, 3), (0, 0.15), 0.2)]
    assert len(undrawn_rooms(nearly, [])) == 1


def test_a_wall_is_inner_when_both_sides_are_rooms() -> None:
    rooms = [((0, 0), (2, 0), (2, 3), (0, 3)), ((2, 0), (4, 0), (4, 3), (2, 3))]
    assert is_inner(Wall((2, 0), (2, 3), 0.1), rooms)
    assert not is_inner(SQUARE[0], rooms)


def test_beside_is_left_of_the_way_from_start_to_end() -> None:
    assert beside(Wall((0, 0), (2, 0), 0.2), 0.5, 0.1) == pytest.approx((1, 0.2))
    assert beside(Wall((0, 0), (2, 0), 0.2), 0.5, -0.1) == pytest.approx((1, -0.2))
