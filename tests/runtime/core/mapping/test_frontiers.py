"""Frontiers of drawn maps, and ids that outlive splits, merges and growth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.geometry import GridFrame
from runtime.core.mapping.frontiers import (
    MIN_CELLS,
    Boundary,
    FrontierMemory,
    boundary,
    components,
    identify,
)
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.zones import Zone
from runtime.core.types import Pose

FRAME = GridFrame(-3.0, -3.0, 0.05, 120, 120)


@pytest.fixture(autouse=True, scope="module")
def small_map():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.grid.SIDE_M", 6.0)
        yield


def drawn(free: np.ndarray, occupied: np.ndarray) -> NavigationMap:
    grid = NavigationMap.around(Pose(0, 0, 0), 0.01)
    grid.swept[:] = free
    grid.evidence[:] = np.where(occupied, 9, 0)
    grid.changed()
    return grid


def patch(rows: slice, cols: slice) -> np.ndarray:
    mask = np.zeros(FRAME.shape, bool)
    mask[rows, cols] = True
    return mask


def line(row: int, start: int, stop: int) -> np.ndarray:
    return FRAME.centres(np.array([[row, c] for c in range(start, stop)], np.int32))


def test_the_open_side_of_a_walled_room_is_its_only_frontier():
    free = patch(slice(40, 80), slice(40, 80))
    walls = patch(slice(38, 82), slice(38, 82)) & ~patch(slice(40, 80), slice(40, 82))
    grid = drawn(free, walls)
    edge = boundary(grid, np.zeros(FRAME.shape, bool))
    parts = components(edge, grid.frame, 3)
    assert len(parts) == 1
    cells = grid.frame.cells(parts[0])
    assert set(cells[:, 1]) == {79}  # the column that touches unknown
    assert cells[:, 0].min() >= 41  # not the cells beside a wall
    assert cells[:, 0].max() <= 78


def test_a_closed_room_has_none():
    free = patch(slice(40, 80), slice(40, 80))
    grid = drawn(free, patch(slice(38, 82), slice(38, 82)) & ~free)
    assert not boundary(grid, np.zeros(FRAME.shape, bool)).any()


def test_what_was_given_up_is_no_frontier():
    free = patch(slice(40, 80), slice(40, 80))
    grid = drawn(free, np.zeros(FRAME.shape, bool))
    assert boundary(grid, np.zeros(FRAME.shape, bool)).any()
    assert not boundary(grid, np.ones(FRAME.shape, bool)).any()


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_every_frontier_cell_is_free_and_touches_unknown(seed: int):
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, 3, (12, 12))
    state = np.kron(coarse, np.ones((10, 10), int))
    grid = drawn(state == 1, state == 2)
    edge = boundary(grid, np.zeros(FRAME.shape, bool))
    unknown = np.pad(grid.unknown, 1)
    beside = np.any(
        [np.roll(unknown, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)], axis=0
    )[1:-1, 1:-1]
    assert (grid.free & beside)[edge].all()
    parts = components(edge, grid.frame, 1)
    assert sum(len(p) for p in parts) == edge.sum()


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_no_cell_of_the_boundary_is_missed(seed: int):
    """Free, beside unknown, not beside an obstacle: looked for cell by cell."""
    rng = np.random.default_rng(seed)
    state = np.kron(rng.integers(0, 3, (24, 24)), np.ones((5, 5), int))
    grid = drawn(state == 1, state == 2)
    edge = boundary(grid, np.zeros(FRAME.shape, bool))
    free, unknown = grid.free, grid.unknown
    for row, col in rng.integers(1, np.array(FRAME.shape) - 1, (200, 2)):
        around = slice(row - 1, row + 2), slice(col - 1, col + 2)
        is_edge = free[row, col] and unknown[around].any() and not grid.occupied[around].any()
        assert edge[row, col] == is_edge


def test_a_zone_has_no_frontier_and_what_is_unknown_in_it_makes_none():
    grid = drawn(patch(slice(40, 80), slice(40, 80)), np.zeros(FRAME.shape, bool))
    nothing = np.zeros(FRAME.shape, bool)
    before = boundary(grid, nothing)
    x, y = FRAME.x0_m, FRAME.y0_m
    corners = (x + 3.2, y + 1.0), (x + 5.0, y + 1.0), (x + 5.0, y + 5.0), (x + 3.2, y + 5.0)
    grid.zones.put((Zone("", corners),), grid.frame)
    edge = boundary(grid, nothing)
    assert (edge[:, :63] == before[:, :63]).all()
    assert not edge[:, 63:].any()
    assert before[:, 63:].any()
    corners = (x + 4.04, y + 1.0), (x + 5.0, y + 1.0), (x + 5.0, y + 5.0), (x + 4.04, y + 5.0)
    grid.zones.put((Zone("", corners),), grid.frame)
    assert not grid.zones.barred(grid.frame)[45:75, 79].any()
    assert not boundary(grid, nothing)[45:75, 70:].any()  # all that is unknown there is in the zone


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12))
def test_a_boundary_made_anew_where_the_map_changed_is_that_of_the_whole_map(seed: int, times: int):
    """Sets of cells grow, merge, split and vanish; ids follow the same."""
    rng = np.random.default_rng(seed)
    grid, given_up = NavigationMap.around(Pose(0, 0, 0), 0.01), np.zeros(FRAME.shape, bool)
    kept, memory, plain = Boundary(), FrontierMemory(), FrontierMemory()
    for _ in range(times):
        (top, bottom), (left, right) = np.sort(rng.integers(0, 121, (2, 2)), axis=1)
        window = slice(int(top), int(bottom)), slice(int(left), int(right))
        grid.evidence[window] = rng.choice([-5, 0, 9], p=[0.6, 0.25, 0.15])
        specks = rng.integers(0, 120, (2, 30))
        grid.evidence[tuple(specks)] = rng.choice([-5, 0, 9], 30)
        grid.changed((slice(0, 120), slice(0, 120)) if rng.random() < 0.7 else None)
        if rng.random() < 0.3:
            given_up[window] = True
            grid.touched(window)
        if rng.random() < 0.3:
            x, y = rng.uniform(-2.5, 1.5, 2).tolist()
            zone = Zone("", ((x, y), (x + 1.2, y), (x + 1.2, y + 0.8)))
            touched = grid.zones.put((zone,) if rng.random() < 0.7 else (), grid.frame)
            if touched is not None:
                grid.touched(touched)
        parts = kept.update(grid, given_up)
        edge = boundary(grid, given_up)
        assert (kept.edge == edge).all()
        whole = components(edge, grid.frame, MIN_CELLS)
        assert len(parts) == len(whole)
        assert all((a == b).all() for a, b in zip(parts, whole, strict=True))
        named, expected = identify(memory, parts, grid.frame), identify(plain, whole, grid.frame)
        assert list(named) == list(expected)
        assert all((named[id] == expected[id]).all() for id in named)


def test_components_follow_eight_neighbours_and_drop_small_ones():
    edge = np.zeros(FRAME.shape, bool)
    edge[10, 10] = edge[11, 11] = edge[12, 12] = True
    edge[50, 50] = True
    assert [len(p) for p in components(edge, FRAME, 1)] == [3, 1]
    assert [len(p) for p in components(edge, FRAME, 2)] == [3]


def test_a_frontier_that_moves_a_little_keeps_its_id():
    memory = FrontierMemory()
    assert list(identify(memory, [line(40, 20, 40)], FRAME)) == [1]
    assert list(identify(memory, [line(42, 20, 40)], FRAME)) == [1]
    assert list(identify(memory, [line(60, 20, 40)], FRAME)) == [2]


def test_in_a_split_the_larger_part_keeps_the_id():
    memory = FrontierMemory()
    identify(memory, [line(40, 20, 60)], FRAME)
    named = identify(memory, [line(40, 20, 30), line(40, 33, 60)], FRAME)
    assert {id: len(cells) for id, cells in named.items()} == {1: 27, 2: 10}


def test_in_a_merge_the_older_id_wins():
    memory = FrontierMemory()
    identify(memory, [line(40, 20, 30)], FRAME)
    identify(memory, [line(40, 20, 30), line(40, 40, 80)], FRAME)
    assert list(identify(memory, [line(40, 20, 80)], FRAME)) == [1]


def test_ids_are_never_used_again():
    memory = FrontierMemory()
    seen: set[int] = set()
    for row in range(10, 100, 8):
        named = identify(memory, [line(row, 20, 40)], FRAME)
        assert not seen & set(named)
        seen |= set(named)


def test_ids_survive_a_larger_grid():
    memory = FrontierMemory()
    cells = line(40, 20, 40)
    identify(memory, [cells], FRAME)
    wider = GridFrame(-9.4, -9.4, 0.05, 376, 376)
    assert list(identify(memory, [cells], wider)) == [1]


def test_a_touch_is_not_enough_to_inherit():
    memory = FrontierMemory()
    identify(memory, [line(40, 20, 60)], FRAME)
    named = identify(memory, [line(40, 60, 100)], FRAME)
    assert list(named) == [2]
