"""Where the floor ends: what is seen of it is neither free nor passed, and nothing else is lost."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pit import DEPTH_M, HEIGHT_M, LEVEL, RADIUS_M, TILTED, Pit

from runtime.core.distances import planner
from runtime.core.mapping import drops
from runtime.core.mapping.frontiers import Boundary
from runtime.core.mapping.grid import NavigationMap, integrate
from runtime.core.types import Mount, Pose

HERE = Pose(0.0, 0.0, 0.0)
HOLE = (1.2, 2.2, -0.6, 0.6, 1.0)
STAIRWELL = (1.2, 3.0, -0.6, 0.6, 2.8)
STEP = (1.6, 2.3, -3.0, 3.0, 0.15)


@pytest.fixture(autouse=True, scope="module")
def every_pixel_is_used():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.grid.STRIDE", 1)
        yield


def looked_around(pit: Pit, pose: Pose = HERE, **more) -> NavigationMap:
    grid = NavigationMap.around(pose, RADIUS_M)
    pit.look(grid, pose, **more)
    return grid


@pytest.mark.parametrize("mount", [LEVEL, TILTED])
@pytest.mark.parametrize("hole", [HOLE, STAIRWELL])
def test_no_cell_of_a_hole_is_free_and_no_way_leads_across(hole, mount):
    """The level camera sees nothing of the hole's near side: it begins where it is blind."""
    pit = Pit(hole, mount=mount)
    grid = looked_around(pit)
    inside = pit.inside(grid)
    assert inside.sum() > 300
    assert not (grid.free & inside).any()
    terrain, _ = planner.look_around(grid, HERE, RADIUS_M)
    path = planner.descend(planner.march_from(terrain, np.array([[2.6, 0.0]])), (0.0, 0.0))
    over = (path[:, 0] > hole[0]) & (path[:, 0] < hole[1]) & (np.abs(path[:, 1]) < hole[3])
    assert not over.any()


@pytest.mark.parametrize("mount", [LEVEL, TILTED])
def test_a_step_of_15_cm_down_is_an_obstacle(mount):
    pit = Pit(STEP, mount=mount)
    grid = looked_around(pit)
    first = pit.inside(grid, 0.0) & ~pit.inside(grid, 0.1)
    rows, cols = np.nonzero(first & (np.abs(cells_xy(grid)[..., 1]) < 0.5))
    near = cells_xy(grid)[rows, cols][:, 0] < 1.75
    assert grid.occupied[rows[near], cols[near]].mean() > 0.5
    assert not grid.free[rows[near], cols[near]].any()


def cells_xy(grid: NavigationMap) -> np.ndarray:
    rows, cols = np.indices(grid.frame.shape)
    return grid.frame.centres(np.stack([rows, cols], axis=-1).astype(np.int32))


def test_no_look_through_the_air_clears_an_edge():
    """A camera that looks up sees no floor, and the wall behind the hole."""
    grid = looked_around(Pit(HOLE))
    edge = grid.occupied & Pit(HOLE).inside(grid)
    assert edge.sum() > 100
    air = Pit(HOLE, mount=Mount(pitch_rad=-0.5))
    for _ in range(5):
        air.look(grid, HERE, turns=1)
    ahead = edge & (np.abs(cells_xy(grid)[..., 1]) < 0.3)
    assert grid.swept[ahead].all()
    assert grid.occupied[edge].all()


def test_floor_that_is_seen_again_and_again_undoes_a_drop():
    grid = looked_around(Pit(HOLE))
    dropped = grid.drops >= drops.DROP_AT
    assert dropped.any()
    bare = Pit(None)
    bare.look(grid, Pose(0.0, 0.0, 0.0), turns=1)
    assert (grid.drops >= drops.DROP_AT).sum() > dropped.sum() / 2  # not by a glance
    for _ in range(4):
        bare.look(grid, HERE)
    assert not (grid.drops >= drops.DROP_AT).any()


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-0.025, 0.025))
def test_on_whole_floor_neither_noise_nor_a_tilt_that_is_off_makes_a_drop(seed, off_rad):
    bare, rng = Pit(None), np.random.default_rng(seed)
    taken = replace(LEVEL, pitch_rad=off_rad)
    grid = looked_around(bare, rng=rng, mount=taken)
    assert not grid.drops.any()
    assert not grid.doubtful.any()


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_what_a_shining_floor_mirrors_walls_nobody_in(seed):
    """Patches of it show what is above, as far below, now here, now there: the light goes with the
    robot. What is whole of it is found whole from nearer by."""
    bare, rng = Pit(None, low=(-4.0, -4.0), high=(4.0, 4.0)), np.random.default_rng(seed)
    grid = NavigationMap.around(HERE, RADIUS_M)
    for n in range(24):
        obs = bare.observe(Pose(0.0, 0.0, n // 2 * math.tau / 12), rng)
        top, left = rng.integers(70, 105), rng.integers(0, 140)
        depth = obs.depth_m.copy()
        depth[top : top + 15, left : left + 20] *= 1.6
        obs = replace(obs, depth_m=depth)
        integrate(grid, obs, LEVEL, RADIUS_M, HEIGHT_M, DEPTH_M)
    whole = looked_around(bare)
    assert (grid.free & whole.free).sum() > 0.8 * whole.free.sum()
    terrain, reach = planner.look_around(grid, HERE, RADIUS_M)
    cells = terrain.frame.cells(np.array([[2.5, 0.0], [-2.5, 0.0], [0.0, 2.5], [0.0, -2.5]]))
    assert np.isfinite(reach.of(cells)).sum() >= 3
    before = (grid.drops >= drops.DROP_AT).sum()
    for place in (HERE, Pose(1.0, 0.6, 0.1), Pose(-1.0, -0.8, 0.2), Pose(0.7, -1.1, 0.3)):
        bare.look(grid, place, rng=rng)
    assert (grid.drops >= drops.DROP_AT).sum() <= 0.1 * before


def test_an_opening_far_away_is_looked_at_from_nearer_first():
    """What seems to drop beyond DROP_WITHIN_M ends what is swept, and a frontier leads there."""
    pit = Pit((3.3, 5.4, -0.8, 0.8, 0.3), high=(5.5, 3.0))
    grid = looked_around(pit)
    assert not grid.free[pit.inside(grid, 0.12)].any()
    assert not grid.drops[pit.inside(grid)].any()
    parts = Boundary().update(grid, np.zeros(grid.frame.shape, bool))
    ahead = [part for part in parts if (np.abs(part - (3.2, 0.0)) < 0.3).all(axis=1).any()]
    assert ahead
    pit.look(grid, Pose(1.5, 0.0, 0.0))
    assert (grid.occupied & pit.inside(grid)).sum() > 100


def test_the_way_back_is_none_any_more_where_the_floor_opens():
    grid = NavigationMap.around(HERE, RADIUS_M)
    bare = Pit(None)
    for x in np.arange(0.0, 2.8, 0.2):
        bare.look(grid, Pose(float(x), 0.0, 0.0), turns=1)
    for x in np.arange(2.6, -0.8, -0.2):
        bare.look(grid, Pose(float(x), 0.0, 0.0), turns=1)
    pit = Pit((1.0, 1.6, -0.6, 0.05, 1.0))
    assert grid.driven[grid.frame.cell(1.3, 0.0)]
    pit.look(grid, Pose(-0.6, 0.0, 0.0), turns=1)
    assert not grid.driven[grid.frame.cell(1.2, 0.05)]
    terrain, _ = planner.look_around(grid, Pose(-0.6, 0.0, 0.0), RADIUS_M)
    beside = np.stack([np.arange(1.05, 1.3, 0.05), np.full(5, 0.08)], axis=1)
    cells = terrain.frame.cells(beside)
    assert not terrain.traversable[cells[:, 0], cells[:, 1]].any()


@settings(max_examples=10, deadline=None)
@given(
    st.tuples(st.floats(0.4, 2.0), st.floats(-1.5, 0.5)),
    st.tuples(st.floats(0.3, 1.2), st.floats(0.3, 1.2)),
    st.lists(st.tuples(st.floats(-2, 0.0), st.floats(-2, 2), st.floats(-3, 3)), max_size=4),
)
def test_masks_with_drops_derived_piece_by_piece_are_those_derived_at_once(corner, size, poses):
    (x, y), (wide, high) = corner, size
    pit = Pit((x, x + wide, y, y + high, 0.6))
    grid = NavigationMap.around(HERE, RADIUS_M)
    for place in poses:
        integrate(grid, pit.observe(Pose(*place)), LEVEL, RADIUS_M, HEIGHT_M, DEPTH_M)
        pit.look(grid, Pose(*place), turns=1)
        assert not (grid.free & grid.occupied).any()
    derived = [mask.copy() for mask in (grid.occupied, grid.free, grid.unknown)]
    grid.changed()
    for one, other in zip(derived, [grid.occupied, grid.free, grid.unknown], strict=True):
        assert (one == other).all()
    assert grid.occupied[grid.drops >= drops.DROP_AT].all()


def test_where_edges_are_felt_doubt_bars_nothing():
    """Of a hole that begins within what the camera is blind for only the far part is seen."""
    grid = looked_around(Pit((0.5, 2.2, -0.6, 0.6, 1.0)))
    assert grid.doubtful.any()
    doubtful = grid.doubtful & grid.swept & (grid.evidence >= 0) & ~grid.occupied
    assert doubtful.sum() > 20
    assert not grid.free[doubtful].any()
    grid.openings.edges_felt = True
    grid.changed()
    assert grid.free[doubtful].mean() > 0.9  # but for gaps between what is occupied
    assert not grid.free[grid.drops >= drops.DROP_AT].any()
