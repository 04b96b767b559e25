import heapq
import math
import sys

import numpy as np
import pytest
import skfmm
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.distances.terrain import survey
from runtime.core.kernels import marching
from runtime.core.mapping.grid import NavigationMap
from runtime.core.types import Pose

CELL_M = 0.05
HUGE = np.lib.stride_tricks.as_strided(np.full(50000, np.inf), (50000, 50000), (0, 8))
HUGE_MASK = np.broadcast_to(np.zeros(50000, bool), HUGE.shape)
"""All rows are one: what has so many cells without the memory for them."""


def plain(arrival, crossing):
    """The upwind scheme by a heap, a cell at a time: what `march` is to equal."""
    rows, cols = arrival.shape
    times, done = arrival.copy(), np.isfinite(arrival)
    heap = []

    def at(r, c):
        return times[r, c] if 0 <= r < rows and 0 <= c < cols and done[r, c] else math.inf

    def look(r, c):
        for dr, dc in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            y, x = r + dr, c + dc
            if not (0 <= y < rows and 0 <= x < cols) or done[y, x] or crossing[y, x] == 0:
                continue
            a, b, f = (
                min(at(y, x - 1), at(y, x + 1)),
                min(at(y - 1, x), at(y + 1, x)),
                crossing[y, x],
            )
            gap = a - b if math.isfinite(a) and math.isfinite(b) else math.inf
            wide = abs(gap) >= f
            time = min(a, b) + f if wide else 0.5 * (a + b + math.sqrt(2 * f * f - gap * gap))
            if time < times[y, x]:
                times[y, x] = time
                heapq.heappush(heap, (time, y, x))

    for r, c in np.argwhere(done):
        look(r, c)
    while heap:
        time, r, c = heapq.heappop(heap)
        if not done[r, c] and time == times[r, c]:
            done[r, c] = True
            look(r, c)
    return times


@st.composite
def worlds(draw):
    """Random speeds, some 0, with one to three places to start from."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    shape = draw(st.integers(1, 24)), draw(st.integers(1, 24))
    speed = rng.uniform(0.25, 1.0, shape).astype(np.float32)
    speed[rng.random(shape) < draw(st.sampled_from([0.0, 0.2, 0.4]))] = 0.0
    arrival = np.full(shape, np.inf)
    for _ in range(draw(st.integers(1, 3))):
        arrival[rng.integers(shape[0]), rng.integers(shape[1])] = 0.0
    return arrival, speed


@st.composite
def terrains(draw):
    """The speeds of a map with some obstacles: 1 but near to them; and a place to start from."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.mapping.grid.SIDE_M", 6.0)
        grid = NavigationMap.around(Pose(0, 0, 0), 0.18)
    top, left = rng.integers(0, 30, 2)
    window = slice(top, top + rng.integers(20, 80)), slice(left, left + rng.integers(20, 80))
    things = rng.random(grid.evidence[window].shape) < draw(st.sampled_from([5e-4, 2e-3, 5e-3]))
    grid.evidence[window] = np.where(things, 9, -5)
    grid.changed(window)
    speed = survey(grid, Pose(0, 0, 0), 0.18).speed
    arrival = np.full(speed.shape, np.inf)
    arrival[tuple(rng.permutation(np.argwhere(speed > 0))[:1].T)] = 0.0
    return arrival, speed


def alike(found, expected, limit=math.inf):
    """Within rounding; what is reached about the limit may or may not be."""
    reached, both = np.isfinite(found), np.isfinite(found) & np.isfinite(expected)
    doubtful = np.where(reached, found, expected)[reached != np.isfinite(expected)]
    gap = np.abs(found[both] - expected[both]).max(initial=0.0)
    return gap <= 1e-9 and np.abs(doubtful - limit).max(initial=0.0) <= 1e-9


@given(worlds())
def test_march_is_the_upwind_schemes_one_solution(world):
    arrival, speed = world
    crossing = np.where(speed > 0, CELL_M / np.maximum(speed.astype(float), 1e-9), 0.0)
    expected = plain(arrival, crossing)
    marching.march(arrival, speed, CELL_M)
    assert np.allclose(arrival, expected, rtol=0, atol=1e-12)


@given(st.one_of(worlds(), terrains()), st.floats(0.05, 1.5))
def test_march_ends_at_the_limit(world, limit):
    arrival, speed = world
    whole = arrival.copy()
    marching.march(whole, speed, CELL_M)
    marching.march(arrival, speed, CELL_M, limit)
    assert alike(arrival, np.where(whole <= limit, whole, np.inf), limit)


@given(st.one_of(worlds(), terrains()), st.floats(0.05, 3.0))
def test_a_front_that_goes_on_ends_as_one_from_the_start(world, known_m):
    arrival, speed = world
    whole = arrival.copy()
    marching.march(whole, speed, CELL_M)
    again = np.where(whole <= known_m, whole, np.inf)
    marching.march(again, speed, CELL_M)
    assert alike(again, whole)


@given(worlds(), st.integers(-1, 24), st.integers(-1, 24), st.sampled_from([0.0, 0.2, 0.7]))
def test_march_ends_so_much_beyond_a_cell(world, row, col, beyond):
    arrival, speed = world
    whole = arrival.copy()
    marching.march(whole, speed, CELL_M)
    inside = 0 <= row < arrival.shape[0] and 0 <= col < arrival.shape[1]
    at = whole[row, col] if inside else math.inf
    told = marching.march(arrival, speed, CELL_M, until=(row, col), beyond=beyond)
    assert told == pytest.approx(at + beyond, abs=1e-9)
    assert alike(arrival, np.where(whole <= told, whole, np.inf), told)


@given(worlds(), st.integers(0, 23), st.integers(0, 23), st.floats(0.05, 1.0))
def test_a_front_that_goes_on_ends_so_much_beyond_a_cell(world, row, col, known_m):
    arrival, speed = world
    marching.march(arrival, speed, CELL_M)
    again = np.where(arrival <= known_m, arrival, np.inf)
    told = marching.march(again, speed, CELL_M, until=(row, col), beyond=0.2)
    limit = max(told, known_m)
    assert alike(again, np.where(arrival <= limit, arrival, np.inf), limit)


def plain_descent(arrival, start, limit):
    path = [start]
    for _ in range(limit):
        row, col = path[-1]
        around = [
            ((arrival[row, col] - arrival[y, x]) * (1.0 if y == row or x == col else 2**-0.5), y, x)
            for y in range(max(0, row - 1), min(arrival.shape[0], row + 2))
            for x in range(max(0, col - 1), min(arrival.shape[1], col + 2))
        ]
        falls, y, x = max(around, key=lambda one: one[0])  # of equals the first
        if arrival[row, col] <= 0 or falls <= 0:
            break
        path.append((y, x))
    return path


@given(worlds(), st.integers(0, 23), st.integers(0, 23), st.sampled_from([0, 3, 4000]))
def test_a_descent_goes_where_it_is_steepest(world, row, col, limit):
    arrival, speed = world
    marching.march(arrival, speed, CELL_M)
    inside = row < arrival.shape[0] and col < arrival.shape[1]
    path = marching.descend(arrival, (row, col), limit)
    if inside and math.isfinite(arrival[row, col]):
        assert path.tolist() == [list(cell) for cell in plain_descent(arrival, (row, col), limit)]
    else:
        assert path.shape == (0, 2)


@given(worlds(), st.integers(0, 10**6), st.integers(0, 6))
def test_what_a_change_touches_is_the_earliest_at_it_or_beside_it(world, seed, changes):
    arrival, speed = world
    marching.march(arrival, speed, CELL_M)
    rng, now = np.random.default_rng(seed), speed.copy()
    for _ in range(changes):
        now[rng.integers(speed.shape[0]), rng.integers(speed.shape[1])] = rng.choice([0.0, 0.5])
    beside = [
        arrival[y, x]
        for r, c in np.argwhere(now != speed)
        for y, x in ((r, c), (r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1))
        if 0 <= y < arrival.shape[0] and 0 <= x < arrival.shape[1]
    ]
    before = speed.copy()
    assert marching.touched(arrival, before, now) == min(beside, default=math.inf)
    assert np.array_equal(before, now)


def test_distances_on_open_floor_are_nearly_straight():
    arrival = np.full((201, 201), np.inf)
    arrival[100, 100] = 0.0
    marching.march(arrival, np.ones((201, 201), bool), CELL_M)
    y, x = np.mgrid[-100:101, -100:101] * CELL_M
    straight = np.hypot(x, y)
    far = straight > 1.0
    ratio = arrival[far] / straight[far]
    assert ratio.min() > 1.0 - 1e-9
    assert ratio.max() < 1.05
    assert np.median(ratio) < 1.015


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_distances_between_things_are_those_of_another_library(seed):
    """scikit-fmm's second order is nearer to straight; both agree within a few percent."""
    rng = np.random.default_rng(seed)
    free = np.ones((80, 80), bool)
    for _ in range(12):
        r, c = rng.integers(0, 70, 2)
        free[r : r + rng.integers(2, 20), c : c + rng.integers(2, 6)] = False
    start = tuple(np.argwhere(free)[rng.integers(free.sum())])
    arrival = np.full(free.shape, np.inf)
    arrival[start] = 0.0
    phi = np.ma.MaskedArray(np.where(arrival == 0, -1.0, 1.0), mask=~free)
    marching.march(arrival, free, CELL_M)
    other = skfmm.distance(phi, dx=CELL_M)
    reached = ~np.ma.getmaskarray(other) & np.isfinite(arrival)
    assert reached.sum() > 1
    gap = np.abs(arrival[reached] - np.abs(other.data[reached]))
    assert np.all(gap <= 0.06 * arrival[reached] + CELL_M)


def test_a_window_of_a_larger_array_is_marched_in_place():
    whole = np.full((20, 30), np.inf)
    open_ = np.ones((20, 30), np.float32)
    window = slice(5, 15), slice(10, 25)
    whole[7, 12] = 0.0
    marching.march(whole[window], open_[window], CELL_M)
    assert np.isfinite(whole).sum() == 150
    assert np.isfinite(whole[window]).all()


@pytest.mark.parametrize(
    ("arrival", "speed", "cell_m", "limit", "error"),
    [
        (np.zeros((2, 2)), np.zeros((2, 3), bool), CELL_M, math.inf, "is not the shape"),
        (np.zeros((2, 2)), np.full((2, 2), 1.5, np.float32), CELL_M, math.inf, "speed outside"),
        (np.zeros((2, 2)), np.full((2, 2), np.nan, np.float32), CELL_M, math.inf, "speed outside"),
        (np.full((2, 2), -1.0), np.zeros((2, 2), bool), CELL_M, math.inf, "arrival below 0"),
        (np.full((2, 2), np.nan), np.zeros((2, 2), bool), CELL_M, math.inf, "arrival below 0"),
        (np.zeros((2, 2)), np.full((2, 2), 1e-30, np.float32), CELL_M, math.inf, "so small"),
        (np.full((2, 2), 1e300), np.zeros((2, 2), bool), CELL_M, math.inf, "too late"),
        (np.zeros((2, 2)), np.zeros((2, 2), bool), 0.0, math.inf, "no size"),
        (np.zeros((2, 2)), np.zeros((2, 2), bool), 1e-320, math.inf, "no size"),
        (np.zeros((2, 2)), np.zeros((2, 2), bool), math.inf, math.inf, "without end"),
        (HUGE, HUGE_MASK, CELL_M, math.inf, "more cells than"),
        (np.zeros((2, 2)), np.zeros((2, 2), bool), CELL_M, math.nan, "no limit"),
        (np.zeros(4), np.zeros((2, 2), bool), CELL_M, math.inf, "1 dimensions"),
        (np.zeros((4, 4))[:, ::2], np.zeros((4, 2), bool), CELL_M, math.inf, "not contiguous"),
    ],
)
def test_what_cannot_be_marched_is_told(arrival, speed, cell_m, limit, error):
    with pytest.raises(ValueError, match=error):
        marching.march(arrival, speed, cell_m, limit)


def test_a_descent_of_less_than_no_cells_is_told():
    with pytest.raises(ValueError, match="limit"):
        marching.descend(np.zeros((2, 2)), (0, 0), -1)
    assert marching.descend(np.zeros((2, 2)), (0, 0), sys.maxsize).tolist() == [[0, 0]]


@pytest.mark.parametrize("kind", [np.float64, np.int16])
def test_speeds_of_another_kind_are_told(kind):
    with pytest.raises(TypeError, match="speed"):
        marching.march(np.zeros((2, 2)), np.zeros((2, 2), kind), CELL_M)


@pytest.mark.parametrize("dtype", [np.float32, np.int64])
def test_arrivals_of_another_kind_are_told(dtype):
    with pytest.raises(TypeError, match="arrival"):
        marching.march(np.zeros((2, 2), dtype), np.zeros((2, 2), bool), CELL_M)
