"""What a laser tells: obstacles at its height, and never floor."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.distances.terrain import survey
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.laser_layer import HELD_AT, HIT, MISS
from runtime.core.mapping.scanning import add_scan
from runtime.core.types import Pose, Scan

HERE, RADIUS_M, FAR_M = Pose(0.0, 0.0, 0.0), 0.18, 5.0
N = 360


def scan(ranges_m: np.ndarray | float, at: Pose = HERE) -> Scan:
    """All round, of one range or of each."""
    headings = at.yaw_rad - math.pi + np.arange(N) * math.tau / N
    told = np.broadcast_to(np.asarray(ranges_m, np.float32), (N,)).copy()
    return Scan((at.x_m, at.y_m), headings, told)


def grid() -> NavigationMap:
    return NavigationMap.around(HERE, RADIUS_M)


def state(found: NavigationMap, x_m: float, y_m: float) -> str:
    cell = found.frame.cell(x_m, y_m)
    return next(n for n in ("occupied", "free", "unknown") if getattr(found, n)[cell])


def with_floor(found: NavigationMap) -> NavigationMap:
    """The camera has seen floor everywhere."""
    found.evidence[:] = -4
    found.changed()
    return found


def test_what_it_meets_is_an_obstacle_and_what_it_passes_stays_unknown():
    found = grid()
    add_scan(found, scan(2.0), HERE, RADIUS_M, FAR_M)
    assert state(found, 2.0, 0.0) == "occupied"
    assert state(found, 0.0, -2.0) == "occupied"
    assert state(found, 1.0, 0.0) == "unknown"
    assert state(found, 3.0, 0.0) == "unknown"
    assert state(found, 0.0, 0.0) == "free"  # it stands there


def test_glass_that_the_camera_sees_floor_behind_bars_the_way():
    found = with_floor(grid())
    assert state(found, 2.0, 0.0) == "free"
    add_scan(found, scan(2.0), HERE, RADIUS_M, FAR_M)
    assert state(found, 2.0, 0.0) == "occupied"
    terrain = survey(found, HERE, RADIUS_M)
    assert not terrain.traversable[terrain.frame.cell(1.9, 0.0)]
    assert terrain.traversable[terrain.frame.cell(1.0, 0.0)]


def test_what_has_gone_is_unlearned_and_nothing_that_the_camera_saw():
    found = with_floor(grid())
    found.evidence[found.frame.cell(1.0, 0.0)] = 8
    found.changed()
    add_scan(found, scan(2.0), HERE, RADIUS_M, FAR_M)
    for _ in range(1 + (HIT - HELD_AT) // MISS):
        assert state(found, 2.0, 0.0) == "occupied"
        add_scan(found, scan(4.0), HERE, RADIUS_M, FAR_M)
    assert state(found, 2.0, 0.0) == "free"
    assert state(found, 1.0, 0.0) == "occupied"


@pytest.mark.parametrize("ranges_m", [0.0, 5.5])
def test_no_return_and_what_is_too_far_take_nothing_back_there(ranges_m: float):
    found = grid()
    add_scan(found, scan(3.0), HERE, RADIUS_M, FAR_M)
    for _ in range(10):
        add_scan(found, scan(ranges_m if ranges_m == 0 else 0.0), HERE, RADIUS_M, FAR_M)
    assert state(found, 3.0, 0.0) == "occupied"
    add_scan(found, scan(ranges_m), HERE, RADIUS_M, FAR_M)
    assert state(found, 5.4, 0.0) == "unknown"


def test_the_robot_itself_is_no_obstacle():
    found = grid()
    add_scan(found, scan(0.15), HERE, RADIUS_M, FAR_M)
    assert not found.occupied.any()


def test_what_the_robot_drives_over_is_none():
    found = grid()
    add_scan(found, scan(1.0), HERE, RADIUS_M, FAR_M)
    found.drive_over(Pose(1.0, 0.0, 0.0), RADIUS_M)
    assert state(found, 1.0, 0.0) == "free"


def test_it_grows_with_the_map():
    found = grid()
    add_scan(found, scan(2.0), HERE, RADIUS_M, FAR_M)
    assert found.grow(np.array([15.0, 0.0]), 6.0) is not None
    assert state(found, 2.0, 0.0) == "occupied"
    there = Pose(15.0, 0.0, 0.0)
    add_scan(found, scan(2.0, there), there, RADIUS_M, FAR_M)
    assert state(found, 17.0, 0.0) == "occupied"


def test_a_scan_from_beyond_the_map_does_no_harm():
    found, there = grid(), Pose(100.0, 0.0, 0.0)
    add_scan(found, scan(2.0, there), there, RADIUS_M, FAR_M)
    assert not found.occupied.any()


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_masks_made_anew_where_it_changed_are_those_of_the_whole_map(seed: int):
    rng = np.random.default_rng(seed)
    found, pose = grid(), HERE
    for _ in range(4):
        pose = Pose(*rng.uniform(-2, 2, 2), rng.uniform(-3, 3))
        ranges = rng.uniform(0, 6, N) * (rng.random(N) < 0.9)
        add_scan(found, scan(ranges, pose), pose, RADIUS_M, FAR_M)
        if rng.random() < 0.5:
            found.bump(pose, RADIUS_M)
        found.drive_over(pose, RADIUS_M)
        now = {name: getattr(found, name).copy() for name in ("occupied", "free", "unknown")}
        found.changed()
        for name, mask in now.items():
            assert np.array_equal(mask, getattr(found, name)), name
