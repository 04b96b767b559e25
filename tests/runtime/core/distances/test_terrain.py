"""The terrain that follows the map is that of the whole map."""

import math

import numpy as np
import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.distances.terrain import NO_SQUEEZE, Squeeze, Terrain, TerrainSurvey, survey
from runtime.core.mapping.grid import NavigationMap, integrate
from runtime.core.mapping.zones import Zone
from runtime.core.types import Pose

RADIUS = 0.18
SQUEEZES = (NO_SQUEEZE, NO_SQUEEZE, Squeeze(0.7, 0.07), Squeeze(math.inf, 0.04))


@pytest.fixture(autouse=True, scope="module")
def small_map():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.grid.SIDE_M", 6.0)
        yield


def alike(one: Terrain, other: Terrain) -> bool:
    arrays = ("clearance_m", "traversable", "speed")
    return one.frame == other.frame and all(
        (getattr(one, name) == getattr(other, name)).all() for name in arrays
    )


def put_zones(grid: NavigationMap, rng: np.random.Generator) -> None:
    low = rng.uniform(-2.5, 1.5, (int(rng.integers(0, 3)), 2))
    corners = [((x, y), (x + 0.8, y), (x + 0.8, y + 1.2)) for x, y in low.tolist()]
    window = grid.zones.put(tuple(Zone("", each) for each in corners), grid.frame)
    if window is not None:
        grid.touched(window)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 10))
def test_made_anew_where_something_changed_it_is_that_of_the_whole_map(seed: int, times: int):
    rng = np.random.default_rng(seed)
    grid, kept = NavigationMap.around(Pose(0, 0, 0), RADIUS), TerrainSurvey()
    for _ in range(times):
        pose = Pose(*rng.uniform(-2.5, 2.5, 2).tolist(), 0.0)
        (top, bottom), (left, right) = np.sort(rng.integers(0, 120, (2, 2)), axis=1).tolist()
        window = slice(top, bottom + 1), slice(left, right + 1)
        grid.evidence[window] = rng.choice([-5, 0, 9], p=[0.6, 0.2, 0.2])
        grid.changed(window)
        if rng.random() < 0.5:
            put_zones(grid, rng)
        match rng.integers(0, 5):
            case 0:
                grid.close(pose.x_m, pose.y_m, 0.1)
            case 1:
                grid.bump(pose, RADIUS)
            case 2:
                grid.drive_over(pose, RADIUS)
            case 3:
                grid.reopen()
        squeeze = SQUEEZES[rng.integers(0, len(SQUEEZES))]
        made = kept.update(grid, pose, RADIUS, squeeze)
        assert alike(made, survey(grid, pose, RADIUS, squeeze))


@settings(max_examples=6, deadline=None)
@given(st.lists(st.tuples(st.floats(1, 9), st.floats(1, 4.5), st.floats(-3, 3)), min_size=1,
                max_size=6))  # fmt: skip
def test_of_a_drive_frame_by_frame_it_is_that_of_all_frames(poses: list[tuple[float, ...]]):
    home = Apartment.of(TWO_ROOMS, Pose(*poses[0]))
    grid, kept = NavigationMap.around(home.pose, RADIUS), TerrainSurvey()
    for pose in poses:
        home.pose = Pose(*pose)
        grid.grow(home.pose.xy, 6.0)
        integrate(grid, home.observe(), MOUNT, RADIUS, 1.0, 5.0)
        made = kept.update(grid, home.pose, RADIUS)
        assert alike(made, survey(grid, home.pose, RADIUS))


def test_clearance_is_the_distance_to_the_nearest_obstacle_as_far_as_anybody_asks():
    grid = NavigationMap.around(Pose(0, 0, 0), RADIUS)
    grid.evidence[:] = -5
    grid.evidence[90, 90] = 9
    grid.changed()
    terrain = survey(grid, Pose(-2, -2, 0), RADIUS)
    rows, cols = np.indices(terrain.frame.shape)
    offset = round((terrain.frame.x0_m - grid.frame.x0_m) / 0.05)
    away = np.hypot(rows - (90 - offset), cols - (90 - offset)) * 0.05 - 0.025
    near = away < 0.6
    assert np.abs(terrain.clearance_m - away)[near].max() < 0.02  # chamfer
    assert terrain.clearance_m[~near].min() > 0.58
    assert terrain.clearance_m.max() == pytest.approx(0.7)


def test_a_copy_of_what_is_near_does_not_change_with_the_map():
    grid, kept, pose = (
        NavigationMap.around(Pose(0, 0, 0), RADIUS),
        TerrainSurvey(),
        Pose(0.01, 0.01, 0),
    )
    grid.evidence[20:100, 20:100] = -5
    grid.changed()
    terrain = kept.update(grid, pose, RADIUS)
    near = terrain.around(pose, 1.0)
    assert near.frame.rows == 41
    here = terrain.frame.cell(0.5, 0.5)
    assert near.traversable[near.frame.cell(0.5, 0.5)] == terrain.traversable[here]
    grid.evidence[70, 70] = 9
    grid.changed((slice(70, 71), slice(70, 71)))
    kept.update(grid, pose, RADIUS)
    assert not terrain.traversable[here]  # a view of the survey's own
    assert near.traversable[near.frame.cell(0.5, 0.5)]


def test_a_zone_is_a_wall_that_no_squeeze_and_no_driven_way_goes_through():
    grid, out, within = NavigationMap.around(Pose(0, 0, 0), RADIUS), (-1.0, -1.0), (1.2, 1.2)
    grid.evidence[:] = -5
    grid.driven[:] = 1
    grid.changed()
    grid.zones.put((Zone("", ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0))),), grid.frame)
    for squeeze in SQUEEZES:
        terrain = survey(grid, Pose(0, 0, 0), RADIUS, squeeze)
        clearance_m = terrain.clearance_m[terrain.frame.cell(*within)]
        assert clearance_m == pytest.approx(-0.2, abs=0.07)
        for x in (0.85, 0.95, 1.2, 2.05):
            assert not terrain.traversable[terrain.frame.cell(x, 1.5)]
            assert terrain.speed[terrain.frame.cell(x, 1.5)] == 0
        assert terrain.speed[terrain.frame.cell(*out)] == 1
        near = terrain.frame.cell(0.72, 1.5)
        assert terrain.traversable[near]
        assert 0 < terrain.speed[near] < 0.6


def test_a_robot_within_one_can_get_out_and_no_deeper():
    grid, pose = NavigationMap.around(Pose(0, 0, 0), RADIUS), Pose(0.3, 0.0, 0.0)
    grid.evidence[:] = -5
    grid.changed()
    grid.zones.put((Zone("", ((0.0, -2.0), (2.0, -2.0), (2.0, 2.0), (0.0, 2.0))),), grid.frame)
    kept = TerrainSurvey()
    terrain = kept.update(grid, pose, RADIUS)
    fits = [bool(terrain.traversable[terrain.frame.cell(x, 0.0)]) for x in (-0.4, 0.0, 0.3, 0.45)]
    assert fits == [True, True, True, False]
    terrain = kept.update(grid, Pose(-0.4, 0.0, 0.0), RADIUS)
    fits = [bool(terrain.traversable[terrain.frame.cell(x, 0.0)]) for x in (-0.4, 0.0, 0.3, 0.45)]
    assert fits == [True, False, False, False]
