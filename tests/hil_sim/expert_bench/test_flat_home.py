"""A home as a plan: what stops the body, what hides, what is seen from where."""

import math

import numpy as np
from plan_of_rooms import thing, three_rooms

from hil_sim.expert_bench.flat_home import CELL_M, EDGE_M, FARTHEST_M, flat_home
from hil_sim.scenes.format import ROOM_TYPES

HOME = flat_home(three_rooms(thing("tall", "wardrobe", 10.0, 2.0, (0.2, 1.2, 2.0))))
TOILET = HOME.wanted("toilet")


def cell(x: float, y: float) -> tuple[int, int]:
    return int((y + EDGE_M) / CELL_M), int((x + EDGE_M) / CELL_M)


def test_doors_are_open_and_walls_are_not():
    assert HOME.free[cell(4.0, 2.95)]
    assert HOME.free[cell(8.0, 1.05)]
    assert HOME.solid[cell(4.0, 1.0)]
    assert not HOME.free[cell(4.1, 1.0)]  # too near to the wall for the body
    assert not HOME.free[cell(1.0, 1.2)]  # under the bed


def test_what_is_low_hides_nothing_and_what_is_high_does():
    assert HOME.solid[cell(1.0, 1.2)]
    assert not HOME.hiding[cell(1.0, 1.2)]
    assert HOME.hiding[cell(10.0, 2.0)]


def test_each_cell_has_its_rooms_type():
    for kind, x in (("bedroom", 2.0), ("hallway", 6.0), ("bathroom", 9.0)):
        assert ROOM_TYPES[HOME.rooms[cell(x, 3.5)]] == kind


def test_a_thing_is_seen_where_nothing_hides_it_and_it_lies_ahead():
    beside, behind = HOME.middle(cell(9.0, 3.5)), HOME.middle(cell(9.0, 1.4))
    wanted = np.array(TOILET)
    assert HOME.in_view(beside, 0.0, wanted).all()
    assert not HOME.in_view(beside, math.pi, wanted).any()
    assert not HOME.in_view(behind, 0.4, wanted).any()  # the wardrobe is between
    assert not HOME.in_view(HOME.middle(cell(6.0, 3.0)), 0.0, wanted).any()  # a wall is


def test_small_things_are_seen_from_near_alone():
    home = flat_home(three_rooms(thing("cup", "mug", 6.0, 2.0, (0.1, 0.1, 0.1))))
    seen_m = {t.name: t.seen * CELL_M for t in home.things}
    assert 1.0 < seen_m["mug"] < 3.0
    assert seen_m["bed"] == FARTHEST_M


def test_the_way_leads_through_the_doors():
    way = HOME.way_m("toilet")
    from_bed, from_hall = way[cell(2.5, 3.5)], way[cell(7.5, 1.05)]
    assert from_hall < 4.0
    assert 3.5 < from_bed - from_hall < 7.0
    assert way is HOME.way_m("toilet")


def test_what_no_home_has_is_no_way_to():
    assert not np.isfinite(HOME.way_m("piano")).any()


def test_rays_end_at_what_hides_and_reach_as_far_as_the_camera_else():
    here = HOME.middle(cell(5.0, 2.0))
    outline, ends = HOME.rays(here, 0.0, math.radians(60), 5.0, 41)
    assert len(outline) == 42
    reach_m = np.hypot(*(outline[1:] - outline[0]).T) * CELL_M
    assert 2.7 < reach_m[20] < 3.1  # the wall at x = 8
    assert HOME.hiding[tuple(ends.T)].all()
    _, none = HOME.rays(here, 0.0, 0.01, 1.0, 3)
    assert len(none) == 0
