"""Where a thing is looked at from: within reach, in view, and from another side."""

import math

import numpy as np
import pytest
from apartment import MOUNT
from hypothesis import given
from hypothesis import strategies as st
from open_floor import POSE, RADIUS_M, SPOT, at, axes, bed, floor, open_floor

from runtime.core.distances.planner import look_around
from runtime.core.geometry import Standoff, standoff
from runtime.core.objects.instances import Evidence, Instance
from runtime.core.objects.standpoints import (
    BACK_M,
    HIGH,
    LOW_M,
    MIDDLE_M,
    OVER_M,
    REACH_M,
    STOP_M,
    TRIED_RAD,
    UNSEEN_M,
    any_side,
    close_to,
    elsewhere,
    look_from,
    other_sides,
    standpoints,
    stands_before,
    stepped_back,
)
from runtime.core.objects.verdict import SECOND_SIDE_RAD
from runtime.core.types import Intrinsics, Pose


def test_a_vase_amid_a_table_can_be_stood_before():
    grid = floor()
    x, y = axes(grid)
    grid.evidence[(np.abs(x - 1.5) < 0.5) & (np.abs(y) < 0.8)] = 10  # the table top
    grid.changed()
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    vase = Instance(
        1, {"vase": Evidence(4.0)}, (1.5, 0.0), 0.9, np.array([[1.525, 0.025]]), views=[POSE]
    )
    stands = standpoints(grid, terrain, reach, vase, "vase")
    assert stands.any()
    rows, cols = np.nonzero(stands)
    ahead = terrain.frame.centres(np.stack([rows, cols], 1).astype(np.int32))
    assert (ahead[:, 0] < 1.0).all()  # on the side it was seen from


def test_nothing_is_looked_at_through_a_wall():
    """A toilet against a thin wall, once seen from over there: not from this side."""
    grid = floor()
    x, y = axes(grid)
    grid.evidence[(np.abs(x - 1.0) < 0.05) & (y < 1.0)] = 10
    grid.changed()
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    cells = np.array([[1.075, 0.025], [1.125, -0.025], [1.175, 0.025], [1.275, 0.025]])
    seen_from = Pose(1.2, 1.5, -1.5)
    toilet = Instance(1, {"toilet": Evidence(4.0)}, (1.25, 0.0), 0.4, cells, views=[seen_from])
    stands = standpoints(grid, terrain, reach, toilet, "toilet")
    assert stands.any()
    rows, cols = np.nonzero(stands)
    ahead = terrain.frame.centres(np.stack([rows, cols], 1).astype(np.int32))
    assert (ahead[:, 0] > 1.0).all()


def test_a_wall_is_not_stood_behind_where_a_place_before_it_is_a_little_farther():
    """A plant on a table in a corner: over the thin wall it is nearer than over the table."""
    grid = floor()
    x, y = axes(grid)
    wall, table = np.abs(y - 0.4) < 0.05, (np.abs(x - 1.5) < 0.4) & (np.abs(y) < 0.3)
    grid.evidence[(wall & (x > 0.0)) | table] = 10
    grid.stood[wall], grid.stood[table & ~wall] = 0xFF, 0x0F  # up to the ceiling, and to 0.6 m
    grid.changed()
    terrain, reach = look_around(grid, Pose(-0.5, 0.0, 0.0), RADIUS_M)
    cells = np.array([[1.5, 0.25], [1.55, 0.25]])
    plant = Instance(
        1, {"plant": Evidence(4.0)}, (1.525, 0.25), 0.9, cells, views=[Pose(0.0, -1.0, 0.5)]
    )
    behind = terrain.frame.centres(np.argwhere(reach.arrival_m < np.inf).astype(np.int32))
    behind = behind[behind[:, 1] > 0.5]
    assert np.hypot(*(behind - plant.xy).T).min() < STOP_M  # the way round is open
    stands = np.argwhere(standpoints(grid, terrain, reach, plant, "plant"))
    assert len(stands)
    assert (terrain.frame.centres(stands.astype(np.int32))[:, 1] < 0.4).all()


def test_what_lies_low_is_stood_before_where_the_camera_still_sees_it():
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    ball = bed(Pose(0.0, 0.0, 0.0))
    lens = Intrinsics(fx=388.0, fy=388.0, cx=320.0, cy=240.0, width=640, height=480)
    for high_m, nearest_m, farthest_m in ((0.2, 0.89, 1.0), (0.5, 0.6, 0.72), (1.2, 0.0, 0.72)):
        far = standoff(lens, MOUNT, 0.0, high_m)
        stands = standpoints(grid, terrain, reach, ball, "bed", far)
        away = terrain.frame.centres(np.argwhere(stands).astype(np.int32)) - ball.cells_xy[0]
        gaps = np.hypot(*away.T)
        assert nearest_m - 0.03 < gaps.min()
        assert 0.65 < gaps.max() < farthest_m + 0.03


def test_what_is_high_up_is_stood_before_where_the_camera_still_sees_it():
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    ball = bed(Pose(0.0, 0.0, 0.0))
    lens = Intrinsics(fx=388.0, fy=388.0, cx=320.0, cy=240.0, width=640, height=480)
    low_m = MOUNT.z_m + 0.43
    far = standoff(lens, MOUNT, low_m, low_m + 0.24)
    assert far.middle_m == pytest.approx(MOUNT.x_m + 0.55 * 388.0 / 240.0)
    stands = standpoints(grid, terrain, reach, ball, "bed", far)
    away = terrain.frame.centres(np.argwhere(stands).astype(np.int32)) - SPOT
    assert np.hypot(*away.T).min() > min(far.middle_m, OVER_M) - 0.04


def test_what_else_was_taken_for_a_small_thing_is_not_stood_before():
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    mug = bed(at(math.pi, 1.5))
    aside = SPOT + np.stack([np.zeros(21), np.linspace(-0.5, 0.5, 21)], 1)  # a table's edge
    mug.cells_xy = aside
    for find in (
        lambda reaches_m: standpoints(grid, terrain, reach, mug, "bed", reaches_m=reaches_m),
        lambda reaches_m: any_side(grid, terrain, reach, mug, (), reaches_m=reaches_m),
    ):
        for reaches_m, farthest_m in ((math.inf, 1.3), (0.18, STOP_M + 0.18 + 0.08)):
            stands = terrain.frame.centres(np.argwhere(find(reaches_m)).astype(np.int32))
            away = np.hypot(*(stands - SPOT).T).max()
            assert farthest_m - 0.25 < away < farthest_m
    mug.xy = (SPOT[0] + 5.0, SPOT[1])  # of none of its cells
    assert standpoints(grid, terrain, reach, mug, "bed", reaches_m=0.18).any()


def test_what_stands_under_a_thing_is_not_what_is_stood_before():
    """A television on a dresser, whose front was taken for its own."""
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    television = bed(at(math.pi, 1.5))
    x, y = np.meshgrid(np.linspace(-0.5, 0.0, 11), np.linspace(-0.5, 0.5, 21))
    television.cells_xy = SPOT + np.stack([x.ravel(), y.ravel()], 1)
    for reaches_m, farthest_m in ((1.0, MIDDLE_M), (1.25, 1.25)):
        stands = standpoints(grid, terrain, reach, television, "bed", reaches_m=reaches_m)
        away = np.hypot(*(terrain.frame.centres(np.argwhere(stands).astype(np.int32)) - SPOT).T)
        assert farthest_m - 0.06 < away.max() < farthest_m + 0.06


def test_what_hangs_over_a_thing_is_stood_before_by_its_own_middle():
    """A television on a dresser that is too high to be seen whole from right before it."""
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    television = bed(at(math.pi, 1.5))
    television.cells_xy = SPOT + np.stack([np.linspace(-0.5, 0.0, 11), np.zeros(11)], 1)
    stands = standpoints(grid, terrain, reach, television, "bed", Standoff(middle_m=0.8), 1.0)
    away = np.hypot(*(terrain.frame.centres(np.argwhere(stands).astype(np.int32)) - SPOT).T)
    assert 0.8 - 0.06 < away.min() < away.max() < MIDDLE_M + 0.06
    back = stepped_back(Standoff(middle_m=0.8))
    assert (back, stepped_back(Standoff())) == (Standoff(middle_m=OVER_M), Standoff(LOW_M))


def test_where_it_was_hidden_it_is_not_stood_again_if_there_is_another_place():
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    stands = standpoints(grid, terrain, reach, bed(at(math.pi, 1.5)), "bed")
    unseen = [at(math.pi, 0.6), at(math.pi + 0.5, 0.6)]
    others = elsewhere(terrain, stands, unseen)
    assert others.any()
    assert not (others & ~stands).any()
    xy = terrain.frame.centres(np.argwhere(others).astype(np.int32))
    assert min(np.hypot(*(xy - was.xy).T).min() for was in unseen) > UNSEEN_M - 0.05
    assert (elsewhere(terrain, others, [Pose(x, y, 0.0) for x, y in xy.tolist()]) == others).all()


def test_where_the_body_has_no_room_it_does_not_stand_though_it_could_leave():
    """A vase at the end of a gap that is too narrow, and the robot right before the gap."""
    grid = floor()
    x, y = axes(grid)
    grid.evidence[(np.abs(y) > 0.15) & (np.abs(x - 1.4) < 0.6)] = 10
    grid.changed()
    cells = np.array([[1.625, 0.025]])
    vase = Instance(1, {"vase": Evidence(4.0)}, (1.6, 0.0), 0.4, cells, views=[POSE])
    before = Pose(0.65, 0.0, 0.0)
    terrain, reach = look_around(grid, before, RADIUS_M)
    at_gap = terrain.frame.cell(0.9, 0.0)
    assert np.isfinite(reach.arrival_m[at_gap])  # so that it could get out
    stands = standpoints(grid, terrain, reach, vase, "vase")
    assert stands.any()
    assert terrain.clearance_m[stands].min() > RADIUS_M
    grid.evidence[(np.abs(x - 0.85) < 0.05) | (np.abs(x - 2.1) < 0.1)] = 10  # it has been shut in
    grid.changed()
    there, way = look_around(grid, Pose(1.2, 0.0, 0.0), RADIUS_M)
    assert there.clearance_m[standpoints(grid, there, way, vase, "vase")].min() < RADIUS_M


def test_who_is_near_and_sees_it_stands_before_it():
    grid = floor()
    terrain, reach = look_around(grid, POSE, RADIUS_M)
    thing = bed(at(math.pi, 1.5))
    for away_m, reaches_m, is_before in ((0.8, 1.0, True), (1.1, 1.0, False), (0.1, 1.0, True)):
        here = at(math.pi, away_m)
        assert stands_before(grid, terrain, reach, thing, here, reaches_m) is is_before
    x, y = axes(grid)
    grid.evidence[(np.abs(x - SPOT[0] + 0.5) < 0.05) & (np.abs(y) < 0.5)] = 10
    grid.changed()
    assert stands_before(grid, terrain, reach, thing, at(math.pi, 0.8))  # the camera looks over it
    grid.stood[grid.occupied] = HIGH
    assert not stands_before(grid, terrain, reach, thing, at(math.pi, 0.8))


def test_where_it_has_stood_it_can_stand_again():
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    cells = np.argwhere(close_to(terrain, reach, np.array([0.5, 0.5])))
    assert len(cells)
    away = terrain.frame.centres(cells.astype(np.int32)) - np.array([0.5, 0.5])
    assert np.hypot(*away.T).max() < BACK_M + 0.08
    assert not close_to(terrain, reach, np.array(SPOT)).any()  # a bed stands there by now


@given(st.floats(math.pi - 1.2, math.pi + 1.2))
def test_other_sides_differ_from_every_view_and_can_be_stood_on(bearing: float):
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    thing = bed(at(bearing, 1.2))
    thing.cells_xy = grid.frame.centres(np.argwhere(grid.occupied).astype(np.int32))
    thing.looks.append(at(bearing + 0.2, 1.0))
    cells = np.argwhere(other_sides(grid, terrain, reach, thing, "bed"))
    assert len(cells)
    xy = terrain.frame.centres(cells.astype(np.int32)) - SPOT
    angles = np.arctan2(xy[:, 1], xy[:, 0])
    for seen in (bearing, bearing + 0.2):
        off = np.abs(np.angle(np.exp(1j * (angles - seen))))
        assert off.min() >= SECOND_SIDE_RAD - 1e-3
    assert np.isfinite(reach.arrival_m[tuple(cells.T)]).all()
    assert np.hypot(*xy.T).max() < REACH_M + 0.3


def test_any_side_is_one_that_nothing_hides_it_from_and_none_that_was_tried():
    grid, pose = open_floor()
    thing = bed(at(math.pi, 1.2))
    thing.cells_xy = grid.frame.centres(np.argwhere(grid.occupied).astype(np.int32))
    x, y = axes(grid)
    grid.evidence[(x > SPOT[0] - 0.6) & (x < SPOT[0] - 0.5) & (y < 2.0)] = 10  # a wall before it
    grid.changed()
    terrain, reach = look_around(grid, pose, 0.18)
    place = grid, terrain, reach, thing
    for tried, least_rad in (((), 0.0), ((at(math.pi / 2, 1.0),), TRIED_RAD)):
        cells = np.argwhere(any_side(*place, tried))
        assert len(cells)
        xy = terrain.frame.centres(cells.astype(np.int32)) - SPOT
        assert (xy[:, 0] > -0.5).all()
        off = np.abs(np.angle(np.exp(1j * (np.arctan2(xy[:, 1], xy[:, 0]) - math.pi / 2))))
        assert off.min() >= least_rad - 1e-3
        assert (off.min() < 0.2) is not bool(tried)
        assert np.isfinite(reach.arrival_m[tuple(cells.T)]).all()
        assert np.hypot(*xy.T).max() < STOP_M + 0.3
    every = [at(bearing, 1.0) for bearing in np.arange(0, math.tau, 0.5)]
    assert not any_side(*place, every).any()


def test_where_to_look_from_is_the_nearest_standpoint_on_foot():
    grid, pose = open_floor()
    terrain, reach = look_around(grid, pose, 0.18)
    thing = bed(at(math.pi, 2.0))
    thing.cells_xy = grid.frame.centres(np.argwhere(grid.occupied).astype(np.int32))
    spot = look_from(grid, terrain, reach, thing)
    assert spot is not None
    stands = standpoints(grid, terrain, reach, thing, "bed")
    assert stands[terrain.frame.cell(*spot)]
    assert reach.at(*spot) == pytest.approx(reach.arrival_m[stands].min())
    thing.cells_xy = thing.cells_xy + 40.0  # beyond what is known
    assert look_from(grid, terrain, reach, thing) is None
