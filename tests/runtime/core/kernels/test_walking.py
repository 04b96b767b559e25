"""What is compiled is what OpenCV and NumPy make of the same, to the last bit."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.geometry import GridFrame
from runtime.core.kernels import _compiled, walking

CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
SQUARE = np.ones((3, 3), np.uint8)
FAR = np.array([[0, 0], [2**31 - 1, 2**31 - 1]], np.int32)
ROW, MANY = np.zeros(50000, np.float32), np.broadcast_to(np.zeros(50000, bool), (50000, 50000))
STEPS = np.lib.stride_tricks.as_strided(ROW, (50000, 50000), (0, 4))  # all rows are one
SEEDS = st.integers(0, 2**32 - 1)


def dilated_step_by_step(passable: np.ndarray, seeds: np.ndarray, limit: int) -> np.ndarray:
    """A dilation a step, by a cross and a square in turn, until one adds nothing."""
    reached, steps = seeds.astype(np.uint8), np.where(seeds, 0.0, np.inf).astype(np.float32)
    for n in range(1, limit + 1):
        wider = cv2.dilate(reached, CROSS if n % 2 else SQUARE) & (passable | seeds)
        new = (wider > 0) & (reached == 0)
        if not new.any():
            break
        steps[new], reached = n, wider
    return steps


@settings(max_examples=150, deadline=None)
@given(SEEDS, st.integers(1, 40), st.integers(1, 40), st.floats(0.2, 1.0), st.integers(0, 90))
def test_a_walk_is_a_dilation_a_step(seed: int, rows: int, cols: int, share: float, limit: int):
    rng = np.random.default_rng(seed)
    passable = rng.random((rows + 4, cols + 4)) < share
    seeds = rng.random(passable.shape) < 0.02
    for part in (np.s_[:], np.s_[2:-2, 1:-3]):
        steps, reached = walking.walk(passable[part], seeds[part], limit)
        assert np.array_equal(steps, dilated_step_by_step(passable[part], seeds[part], limit))
        assert reached == np.isfinite(steps).sum()


def test_a_walk_through_more_steps_than_a_byte_holds():
    passable = np.ones((3, 700), bool)
    seeds = np.zeros_like(passable)
    seeds[1, 0] = True
    steps, _ = walking.walk(passable, seeds, 650)
    assert steps[1, 650] == 650
    assert np.isinf(steps[1, 651])


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.integers(1, 30), st.integers(1, 30), st.integers(1, 6), st.integers(0, 6))
def test_touch_is_the_least_of_a_filtered_image(seed, rows, cols, things, margin):
    rng = np.random.default_rng(seed)
    away = rng.choice([0.0, 1.5, 2.0, 7.0, np.inf], (rows, cols)).astype(np.float32)
    blobs = []
    for _ in range(things):
        low = rng.integers(-8, 34, 2)
        blob = np.argwhere(rng.random(rng.integers(1, 7, 2)) < 0.7) + low
        blobs.append(blob if len(blob) else low[None])
    cells = np.concatenate(blobs).astype(np.int32)
    starts = np.cumsum([0, *map(len, blobs)])[:-1].astype(np.int32)
    least = cv2.erode(away, np.ones((2 * margin + 1,) * 2, np.uint8)).reshape(rows, cols)
    expected = [
        min((least[r, c] for r, c in blob if 0 <= r < rows and 0 <= c < cols), default=np.inf)
        for blob in blobs
    ]
    assert walking.reach_things(away, cells, starts, margin).tolist() == expected


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(1, 40), st.integers(1, 40), st.integers(2, 9), st.integers(0, 12))
def test_means_are_numpys_of_the_cells_that_are_walked_to(seed, rows, cols, layers, limit):
    rng = np.random.default_rng(seed)
    stack = rng.random((layers, rows, cols)).astype(np.float32)
    passable = rng.random((rows, cols)) < rng.choice([0.3, 0.7, 1.0])
    held = [rng.integers(0, (rows, cols), (n, 2)).astype(np.int32) for n in (1, 5, 2)]
    ends = np.cumsum([len(cells) for cells in held], dtype=np.int32)
    found = walking.means(stack, passable, np.concatenate(held), ends, limit)
    for cells, means in zip(held, found, strict=True):
        seeds = np.zeros((rows, cols), bool)
        seeds[tuple(cells.T)] = True
        near = np.isfinite(dilated_step_by_step(passable, seeds, limit))
        total = np.zeros(layers, np.float32)
        for row, col in np.argwhere(near):
            total += stack[:, row, col]
        assert np.array_equal(means, total / np.float32(near.sum()))


def nearest_of_one(arrival, cells, snap, first):
    """By a dilated mask: row, column and arrival."""
    padded = np.full((80, 80), np.inf)  # cell (0, 0) is at 20, 20
    padded[20 : 20 + arrival.shape[0], 20 : 20 + arrival.shape[1]] = arrival
    near = padded[cells[:, 0] + 20, cells[:, 1] + 20]
    if np.isfinite(near).any():
        best = int(near.argmin())
        return *cells[best].tolist(), float(near[best])
    mask = np.zeros((80, 80), np.uint8)
    mask[cells[:, 0] + 20, cells[:, 1] + 20] = 1
    mask = cv2.dilate(mask, np.ones((2 * snap + 1, 2 * snap + 1), np.uint8))
    mask[: 20 + first[0]], mask[:, : 20 + first[1]] = 0, 0
    near = np.where(mask > 0, padded, np.inf)
    flat = int(near.argmin()) if np.isfinite(near).any() else int(mask.argmax())
    row, col = divmod(flat, 80)
    return row - 20, col - 20, float(near[row, col])


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.integers(1, 30), st.integers(1, 30), st.integers(0, 7), st.integers(1, 6))
def test_the_nearest_cell_of_a_set_or_close_by_it(seed, rows, cols, snap, sets):
    rng = np.random.default_rng(seed)
    arrival = rng.integers(0, 9, (rows, cols)).astype(float)
    arrival[rng.random(arrival.shape) < rng.choice([0.5, 0.97, 1.0])] = np.inf
    first = tuple(rng.integers(-9, 1, 2).tolist())
    held = [rng.integers(first, 38, (rng.integers(1, 12), 2)).astype(np.int32) for _ in range(sets)]
    ends = np.cumsum([len(cells) for cells in held], dtype=np.int32)
    places, away = walking.nearest(arrival, np.concatenate(held), ends, snap, first)
    expected = [nearest_of_one(arrival, cells, snap, first) for cells in held]
    assert [
        (*place, at) for place, at in zip(places.tolist(), away.tolist(), strict=True)
    ] == expected


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.integers(2, 40), st.integers(2, 40), st.integers(2, 60), st.booleans())
def test_lines_of_sight_are_numpys_points(seed, rows, cols, steps, part):
    rng = np.random.default_rng(seed)
    occupied = rng.random((rows, cols)) < rng.choice([0.02, 0.2])
    first = rng.integers(-5, 5, 2).tolist() if part else [0, 0]
    frame = GridFrame(*rng.uniform(-3, 3, 2), 0.05, rows, cols, *first)
    low, high = frame.centres(np.array([[-1, -1], [rows, cols]]))
    start, ends = rng.uniform(low, high), rng.uniform(low, high, (7, 2))
    place = frame.x0_m, frame.y0_m, frame.resolution_m, *first
    seen = walking.in_sight(occupied, place, (float(start[0]), float(start[1])), ends, steps)
    line = start + np.linspace(0.0, 1.0, steps)[:-1, None, None] * (ends - start)
    at = np.moveaxis(frame.cells(line) + 1, -1, 0)
    blocked = np.pad(occupied, 1)[tuple(at.clip(0, np.array([rows + 1, cols + 1])[:, None, None]))]
    assert seen.tolist() == (~blocked.any(axis=0)).tolist()


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: walking.walk(np.ones((3, 3), bool), np.ones((3, 4), bool), 3), "passable"),
        (lambda: walking.walk(np.ones((3, 3), bool), np.ones((3, 3), bool), 65535), "limit"),
        (lambda: walking.walk(np.ones((3, 3), bool), np.ones((3, 3), bool), -1), "limit"),
        (
            lambda: walking.reach_things(
                np.ones((3, 3), np.float32), np.zeros((2, 2), np.int32), np.array([3], np.int32), 1
            ),
            "starts",
        ),
        (
            lambda: walking.means(
                np.ones((2, 3, 3), np.float32),
                np.ones((3, 3), bool),
                np.full((1, 2), 3, np.int32),
                np.array([1], np.int32),
                4,
            ),
            "cells",
        ),
        (
            lambda: walking.nearest(
                np.ones((3, 3)), np.zeros((2, 2), np.int32), np.array([0, 2], np.int32), 1, (0, 0)
            ),
            "ends",
        ),
        (
            lambda: walking.nearest(
                np.full((3, 3), np.inf), FAR, np.array([2], np.int32), 1, (0, 0)
            ),
            "more cells than",
        ),
        (
            lambda: walking.in_sight(
                np.ones((3, 3), bool), (0.0, 0.0, 0.0, 0, 0), (0.0, 0.0), np.zeros((1, 2)), 4
            ),
            "cell_m",
        ),
        (
            lambda: walking.in_sight(
                np.ones((3, 3), bool), (0.0, 0.0, 0.1, 0, 0), (0.0, 0.0), np.zeros((1, 3)), 4
            ),
            "ends",
        ),
        (lambda: _compiled.walk(STEPS, MANY, MANY, 3), "more cells than"),
    ],
)
def test_what_does_not_fit_is_told(call, error):
    with pytest.raises(ValueError, match=error):
        call()
