"""Ways that were open once: where they are, and from where to look at them."""

import numpy as np
import pytest
from open_floor import POSE, RADIUS_M, axes, floor

from runtime.core.distances.passages import Passages
from runtime.core.distances.planner import look_around
from runtime.core.mapping.grid import NavigationMap


def rooms(grid: NavigationMap, door_open: bool) -> None:
    """A wall at x = 1, with a doorway of 1 m at y = 0."""
    x, y = axes(grid)
    wall = np.abs(x - 1.0) < 0.06
    grid.evidence[wall & (np.abs(y) < 3)] = 20
    if door_open:
        grid.evidence[wall & (np.abs(y) < 0.5)] = -10
    grid.changed()


def seen(grid: NavigationMap, passages: Passages):
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    passages.note(grid.frame, reach)
    return terrain, reach, np.zeros(grid.frame.shape, bool)


def test_a_door_that_was_closed_is_looked_at_from_before_it():
    grid, passages = floor(), Passages()
    rooms(grid, True)
    assert passages.closed(*seen(grid, passages)) == []
    rooms(grid, False)
    terrain, reach, barred = seen(grid, passages)
    (way,) = passages.closed(terrain, reach, barred)
    assert way.xy == pytest.approx((1.0, 0.0), abs=0.35)
    stands = terrain.frame.centres(way.stands)
    gaps = np.hypot(*(stands - (0.8, 0.0)).T)
    assert gaps.min() > 0.5
    assert gaps.max() < 1.6
    assert np.isfinite(reach.arrival_m[tuple(way.stands.T)]).all()
    rooms(grid, True)
    assert passages.closed(*seen(grid, passages)) == []


def test_what_was_never_open_is_none():
    grid, passages = floor(), Passages()
    rooms(grid, False)
    assert passages.closed(*seen(grid, passages)) == []


def test_what_a_tight_gap_led_to_was_never_open():
    grid, passages = floor(), Passages()
    rooms(grid, True)
    _, reach = look_around(grid, POSE, RADIUS_M)
    passages.note(grid.frame, reach, tight=True)
    rooms(grid, False)
    assert passages.closed(*seen(grid, passages)) == []


def test_it_holds_when_the_map_grows():
    grid, passages = floor(), Passages()
    rooms(grid, True)
    seen(grid, passages)
    grid.grow(np.array([-14.0, -13.0]), 2.0)
    rooms(grid, False)
    (way,) = passages.closed(*seen(grid, passages))
    assert way.xy == pytest.approx((1.0, 0.0), abs=0.35)


def test_a_thing_in_the_room_closes_nothing():
    grid, passages = floor(), Passages()
    seen(grid, passages)
    x, y = axes(grid)
    grid.evidence[np.hypot(x - 1.5, y) < 0.3] = 20
    grid.changed()
    assert passages.closed(*seen(grid, passages)) == []


def test_no_way_leads_through_what_is_kept_out_of():
    grid, passages = floor(), Passages()
    rooms(grid, True)
    seen(grid, passages)
    rooms(grid, False)
    terrain, reach, barred = seen(grid, passages)
    barred[np.abs(axes(grid)[0] - 1.0) < 0.2] = True
    assert passages.closed(terrain, reach, barred) == []


def test_of_two_ways_the_nearer_comes_first():
    grid, passages = floor(), Passages()
    x, y = axes(grid)
    grid.evidence[(np.abs(np.abs(x + 0.5) - 1.5) < 0.06) & (np.abs(y) > 0.5)] = 20
    grid.changed()
    seen(grid, passages)
    grid.evidence[np.abs(np.abs(x + 0.5) - 1.5) < 0.06] = 20
    grid.changed()
    first, second = passages.closed(*seen(grid, passages))
    assert first.away_m <= second.away_m
    assert first.xy[0] > 0 > second.xy[0]
