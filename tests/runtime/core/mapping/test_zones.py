"""Polygons over a map: how far each cell is outside of them, and which are none."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.geometry import GridFrame
from runtime.core.mapping.zones import FAR_M, REACH_M, Zone, ZoneLayer, wrong_corners
from runtime.core.types import Pose

FRAME = GridFrame(-3.0, -3.0, 0.05, 120, 120)
SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
WHOLE = slice(0, 120), slice(0, 120)
CELL_M = 0.05 * math.sqrt(0.5)  # from a cell's middle to its corner


def layer(*zones: Zone) -> ZoneLayer:
    made = ZoneLayer()
    made.put(zones, FRAME)
    return made


def star(seed: int) -> tuple[tuple[float, float], ...]:
    """A simple polygon round a point: its corners by angle."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 12))
    at = np.sort(rng.uniform(0, math.tau, n))
    far = rng.uniform(0.3, 2.5, n)
    x, y = rng.uniform(-1.5, 1.5, 2)
    return tuple(
        (float(x + r * math.cos(a)), float(y + r * math.sin(a)))
        for r, a in zip(far, at, strict=True)
    )


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_every_place_of_a_cell_is_as_far_outside_as_is_told(seed: int, area: bool):
    zone = Zone("", star(seed), area)
    if wrong_corners(zone.corners_xy):
        return
    told, _ = layer(zone).clearance(FRAME, WHOLE)
    rng = np.random.default_rng(seed)
    for row, col in rng.integers(0, 120, (200, 2)).tolist():
        x, y = FRAME.centres(np.array([row, col], np.int32)) + rng.uniform(-0.025, 0.025, 2)
        outside_m = zone.outside_m((float(x), float(y))) * (-1 if area else 1)
        edge_m = float(told[row, col])
        assert edge_m <= outside_m + 1e-5 or abs(outside_m) >= REACH_M - CELL_M
        if abs(outside_m) < REACH_M - 0.2:
            assert edge_m >= outside_m - 2 * CELL_M - 1e-5


def test_a_point_is_outside_by_its_distance_to_the_nearest_side():
    zone = Zone("", SQUARE)
    assert zone.outside_m((1.5, 0.5)) == pytest.approx(0.5)
    assert zone.outside_m((0.5, 0.9)) == pytest.approx(-0.1)
    assert zone.outside_m((-3.0, -4.0)) == pytest.approx(5.0)


def test_what_is_kept_out_of_is_the_polygon_and_of_an_area_all_else():
    out, within = layer(Zone("", SQUARE)), layer(Zone("", SQUARE, area=True))
    inside = FRAME.cell(0.5, 0.5)
    far = FRAME.cell(-2.0, -2.0)
    assert (out.barred(FRAME)[inside], out.barred(FRAME)[far]) == (True, False)
    assert (within.barred(FRAME)[inside], within.barred(FRAME)[far]) == (False, True)


def test_the_window_that_is_told_holds_all_that_changes():
    made = ZoneLayer()
    plain, _ = made.clearance(FRAME, WHOLE)
    a, b = Zone("a", SQUARE), Zone("b", tuple((x - 2.5, y - 2.5) for x, y in SQUARE))
    before = plain
    for zones in ((a,), (a, b), (b,), ()):
        window = made.put(zones, FRAME)
        now, _ = made.clearance(FRAME, WHOLE)
        changed = now != before
        assert window is not None
        assert changed.any()
        changed[window] = False
        assert not changed.any()
        before = now
    assert (before == plain).all()
    assert made.put((), FRAME) is None


def test_a_map_that_grows_keeps_its_zones_where_they_are():
    made = layer(Zone("", SQUARE))
    larger = GridFrame(-6.0, -4.0, 0.05, 200, 240)
    grown, _ = made.clearance(larger, (slice(20, 140), slice(60, 180)))
    assert np.allclose(grown, layer(Zone("", SQUARE)).clearance(FRAME, WHOLE)[0], atol=1e-5)


def test_a_zone_that_the_robot_is_in_is_open_as_deep_as_it_stands_and_others_are_not():
    zone, other = Zone("a", SQUARE), Zone("b", ((1.4, 0.0), (2.4, 0.0), (2.4, 1.0), (1.4, 1.0)))
    made, pose = layer(zone, other), Pose(0.3, 0.5, 0.0)
    (opening,) = made.openings(FRAME, pose, 0.2)
    assert opening.zone is zone
    assert opening.lacks_m == pytest.approx(0.2 + 0.3 + CELL_M, abs=0.05)
    true_m, told_m = made.clearance(FRAME, WHOLE, (opening,))
    here, deeper, out = FRAME.cell(0.3, 0.5), FRAME.cell(0.5, 0.5), FRAME.cell(-0.1, 0.5)
    assert true_m[here] < 0
    assert told_m[here] >= 0.2 - 1e-6
    assert told_m[deeper] < 0.2
    assert told_m[out] > 0.2
    assert told_m[FRAME.cell(1.5, 0.5)] == true_m[FRAME.cell(1.5, 0.5)]
    far_side = FRAME.cell(0.98, -1.5)  # of the zone, where the robot is not
    assert told_m[far_side] == true_m[far_side]
    assert made.openings(FRAME, Pose(-0.5, 0.5, 0.0), 0.2) == ()


def test_who_stands_in_the_midst_of_a_large_one_may_leave_by_any_way():
    large = Zone("", ((-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)))
    made = layer(large)
    (opening,) = made.openings(FRAME, Pose(0.0, 0.0, 0.0), 0.2)
    assert math.isinf(opening.within_m)
    assert (made.clearance(FRAME, WHOLE, (opening,))[1] >= 0.2 - 1e-6).all()


@pytest.mark.parametrize(
    ("corners", "says"),
    [
        (SQUARE, ""),
        (SQUARE[::-1], ""),
        (SQUARE[:2], "has 2 corners, must have 3 to 64"),
        (SQUARE * 17, "has 68 corners, must have 3 to 64"),
        ((*SQUARE[:3], (math.nan, 0.0)), "has a corner that is no place"),
        ((*SQUARE[:3], (FAR_M + 1, 0.0)), "has a corner that is no place"),
        ((SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]), "crosses itself: side 1 and side 3"),
        ((SQUARE[0], SQUARE[1], SQUARE[1], SQUARE[2]), "crosses itself: side 1 and side 3"),
        (((0.0, 0.0), (1.0, 0.0), (0.5, 0.001)), "has next to nothing in it"),
    ],
)
def test_what_is_no_polygon_is_told(corners: tuple[tuple[float, float], ...], says: str):
    assert wrong_corners(corners).startswith(says)
    assert bool(wrong_corners(corners)) == bool(says)
