"""What is compiled is what OpenCV and NumPy make of the same, to the last bit."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.geometry import GridFrame, rays
from runtime.core.kernels import _compiled
from runtime.core.kernels import mapping as kernels
from runtime.core.types import Intrinsics, Mount, Pose

SEEDS = st.integers(0, 2**32 - 1)
CAMERA = Intrinsics(48.0, 48.0, 32.0, 24.0, 64, 48)
MOUNTS = (Mount(), Mount(0.1, -0.05, 0.5, 0.02, 0.3, 0.1), Mount(z_m=0.3, yaw_rad=2.8))
HOLES = (0.0, np.nan, np.inf, -np.inf, -1.0, 65.535)
MOST_M, FLOOR_M, HEIGHT_M, CELL_M = 5.0, 0.07, 1.0, 0.05
SLACK, LIP_M, DROP_WITHIN_M = 0.03, 0.03, 3.0
WEIGHTS = kernels.Weights(2, 4, 2, 20, 6)


def depth_image(rng: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    """Walls, slopes and noise, with holes of every kind."""
    slope = rng.uniform(0.3, 6.0) + rng.uniform(-0.05, 0.05) * np.arange(shape[1])
    depth = np.broadcast_to(slope, shape) * rng.choice([1.0, 1.0, 0.5], shape)
    depth = np.where(rng.random(shape) < 0.5, depth, rng.uniform(0.1, 7.0, shape))
    some = rng.random(shape) < rng.choice([0.0, 0.2, 0.9])
    return np.where(some, rng.choice(HOLES, shape), depth).astype(np.float32)


def holes_by_numpy(depth, table, camera_m, pixels):
    """By azimuth, how near something may stand where so many pixels in a row tell nothing."""
    nearest = np.full(len(table.azimuths), np.inf, np.float32)
    groups = np.broadcast_to(table.groups, depth.shape)
    hole = (depth == 0) & (np.float32(MOST_M) * table.up + np.float32(camera_m) <= 0)
    below = np.minimum(np.arange(len(depth)) + 1, len(depth) - 1)
    with np.errstate(divide="ignore"):
        floor_m = np.float32(camera_m) / -table.up[below] * table.reach[below]
    for row, col in np.argwhere(hole):
        top = bottom = row
        while top > 0 and hole[top - 1, col]:
            top -= 1
        while bottom + 1 < len(depth) and hole[bottom + 1, col]:
            bottom += 1
        if bottom - top + 1 >= pixels and floor_m[row, col] >= 0:
            group = groups[row, col]
            nearest[group] = min(nearest[group], floor_m[row, col])
    return nearest


def cells_of(ahead, aside, table, pose, mount, frame):
    """Of points, m from the camera; at the grid's rim those outside of it."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    ox = pose.x_m + c * mount.x_m - s * mount.y_m - frame.x0_m
    oy = pose.y_m + s * mount.x_m + c * mount.y_m - frame.y0_m
    r = 1.0 / frame.resolution_m
    col = ((np.float32(c) * ahead - np.float32(s) * aside + np.float32(ox)) * r).astype(np.int32)
    row = ((np.float32(s) * ahead + np.float32(c) * aside + np.float32(oy)) * r).astype(np.int32)
    row, col = np.clip(row, 0, frame.rows - 1), np.clip(col, 0, frame.cols - 1)
    return row * frame.cols + col


def edges_by_pixel(floor, obstacle, drop, low, distance, crossing_m, table):
    """Pixel by pixel from the lowest row up. By azimuth: the floor before the second point of a
    drop, how near that is, how many points there are; which points count at all; and which are
    floor, after all."""
    count, groups = len(table.azimuths), np.broadcast_to(table.groups, floor.shape)
    near, far = np.full(count, np.inf, np.float32), np.zeros(count, np.float32)
    edge, opening = np.zeros(count, np.float32), np.zeros(count, np.float32)
    points, counted = np.zeros(count, int), np.zeros(floor.shape, bool)
    floor = floor.copy()
    for row in reversed(range(floor.shape[0])):
        for col in np.flatnonzero(floor[row] | obstacle[row] | drop[row] | low[row]):
            g, here = groups[row, col], distance[row, col]
            behind = low[row, col] and points[max(0, g - 1) : g + 2].sum() >= WEIGHTS.hits_needed
            if behind:
                floor[row, col] = False
            if obstacle[row, col]:
                near[g] = min(near[g], here)
            elif floor[row, col]:
                far[g] = max(far[g], here)
            elif (behind or drop[row, col]) and 0 <= crossing_m[row, col] <= near[g]:
                counted[row, col] = True
                if points[g] < WEIGHTS.hits_needed:
                    edge[g], opening[g] = far[g], crossing_m[row, col]
                    points[g] += 1
    return near, far, edge, opening, points, counted, floor


def beside(values):
    """(A,) -> (3, A): of each azimuth, of the one before it and of the one after."""
    padded = np.pad(values, 1)
    return np.stack([padded[:-2], padded[1:-1], padded[2:]])


def seen_by_numpy(before, depth_m, table, pose, mount, frame, stride, pixels):
    """Evidence and drops afterwards, and what is told by azimuth."""
    (evidence, drops), half = before, stride // 2
    depth = depth_m[half::stride, half::stride]
    depth = np.where((depth > 0) & (depth <= MOST_M), depth, np.float32(0))
    height, distance = depth * table.up + np.float32(mount.z_m), depth * table.reach
    valid = depth > 0
    floor = valid & (np.abs(height) < FLOOR_M)
    obstacle = valid & (height >= FLOOR_M) & (height <= HEIGHT_M)
    drop = valid & (height < -(np.float32(FLOOR_M) + np.float32(SLACK) * distance))
    low = valid & (height < -np.float32(LIP_M)) & ~drop
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = np.float32(mount.z_m) / -table.up
        found = edges_by_pixel(floor, obstacle, drop, low, distance, crossing * table.reach, table)
    near, far, edge, opening, points, counted, floor = found
    at = np.where(counted, crossing, depth)
    place = table, pose, mount, frame
    cells = cells_of(at * table.forward, at * table.left, *place)
    after, sunk, count = evidence.ravel().copy(), drops.ravel().copy(), evidence.size
    close = counted & (at * table.reach <= np.float32(DROP_WITHIN_M))
    hits = np.bincount(cells[obstacle], minlength=count)
    falls = np.bincount(cells[close], minlength=count)
    hit, bare = hits >= WEIGHTS.hits_needed, np.bincount(cells[floor], minlength=count) > 0
    after[hit] = np.minimum(after[hit] + WEIGHTS.hit, WEIGHTS.most)
    solid = bare & (hits == 0) & (falls == 0)
    after[solid] = np.maximum(after[solid] - WEIGHTS.miss, -WEIGHTS.most)
    deep = (falls >= WEIGHTS.hits_needed) & ~bare
    sunk[deep] = np.minimum(sunk[deep] + 1, WEIGHTS.drop_most)
    sunk[solid & (sunk > 0)] -= 1
    edge, opening, points = (beside(values) for values in (edge, opening, points))
    ends = points.sum(axis=0) >= WEIGHTS.hits_needed
    edge, opening = edge.max(axis=0), opening.max(axis=0)
    seen = np.where(np.isfinite(near), near, far)
    seen = np.where(ends, np.minimum(seen, edge), seen)
    seen = np.minimum(seen, holes_by_numpy(depth, table, mount.z_m, pixels))
    told = np.stack([seen, np.minimum(far, seen), np.where(ends & (edge <= 0), opening, 0)])
    shape = evidence.shape
    return after.reshape(shape), sunk.reshape(shape), told, (falls > 0).reshape(shape)


@settings(max_examples=120, deadline=None)
@given(SEEDS, st.sampled_from(MOUNTS), st.sampled_from([1, 2, 3]), st.floats(-9, 9),
       st.floats(-9, 9), st.floats(-math.pi, math.pi))  # fmt: skip
def test_a_depth_image_is_booked_as_numpy_would(seed, mount, stride, x, y, yaw):
    """Wherever the camera is: in the grid, at its rim, outside of it."""
    rng = np.random.default_rng(seed)
    frame, pose = GridFrame(-4.0, -3.0, CELL_M, 120, 160), Pose(x, y, yaw)
    depth = depth_image(rng, (CAMERA.height, CAMERA.width))
    table = rays(CAMERA, mount, stride)
    evidence = rng.integers(-20, 21, frame.shape).astype(np.int16)
    drops = rng.choice([0, 0, 1, 3, 6], frame.shape).astype(np.uint8)
    before = evidence.copy(), drops.copy()
    expected, sunk, range_m, falls = seen_by_numpy(
        before, depth, table, pose, mount, frame, stride, 3
    )
    c, s = math.cos(yaw), math.sin(yaw)
    view = kernels.DepthView(
        stride, MOST_M, mount.z_m, FLOOR_M, HEIGHT_M, c, s,
        x + c * mount.x_m - s * mount.y_m - frame.x0_m,
        y + s * mount.x_m + c * mount.y_m - frame.y0_m, 1.0 / CELL_M, SLACK, LIP_M, DROP_WITHIN_M,
    )  # fmt: skip
    around = math.ceil(MOST_M * table.farthest / CELL_M) + 2
    found_m, window, dropped = kernels.integrate(
        evidence, drops, depth, (table.forward, table.left, table.up, table.reach), table.groups,
        len(table.azimuths), view, WEIGHTS, around, 3,
    )  # fmt: skip
    assert np.array_equal(evidence, expected)
    assert np.array_equal(drops, sunk)
    assert np.array_equal(found_m, range_m)
    assert dropped == box_of(falls)
    told = np.zeros(frame.shape, bool)
    if window:
        told[window[0] : window[1], window[2] : window[3]] = True
    assert told[(evidence != before[0]) | (drops != before[1])].all()


def flying_by_numpy(nearness: np.ndarray) -> np.ndarray:
    """Along rows, in plain numbers."""
    near, flies = nearness.astype(int), np.zeros(nearness.shape, bool)
    for p in range(4, near.shape[1] - 4):
        a, b, c, here, e, f, g = (near[:, p + n] for n in (-4, -2, -1, 0, 1, 2, 4))
        before, after = here - b, f - here
        between = np.maximum(np.minimum(before, after), -np.maximum(before, after))
        off = np.minimum(abs(here - 2 * b + a), abs(g - 2 * f + here))
        alone = np.minimum(abs(here - c), abs(e - here))
        flies[:, p] = (np.minimum(between, off) > 32) & (alone > 8)
    return flies


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.integers(1, 30), st.integers(1, 50))
def test_flying_pixels_are_those_of_plain_numbers(seed, rows, cols):
    rng = np.random.default_rng(seed)
    depth = depth_image(rng, (rows, cols))
    inverse = np.zeros(depth.shape, np.float32)
    np.divide(1600, np.maximum(depth, np.float32(0.2)), out=inverse, where=depth > 0)
    nearness = inverse.astype(np.int16)
    flies = flying_by_numpy(nearness) | flying_by_numpy(nearness.T).T
    expected = np.where(flies, np.float32(0), depth)
    assert np.array_equal(kernels.solid(depth, 1600, 0.2, 32, 8), expected, equal_nan=True)


def masks_by_opencv(evidence, drops, bumped, swept, doubtful):
    occupied = (evidence >= 4) | (drops >= 2) | bumped
    gap = np.ones((5, 5), np.uint8)
    closed = cv2.morphologyEx(occupied.view(np.uint8), cv2.MORPH_CLOSE, gap) > 0
    free = ((evidence < 0) | (swept & ~closed & ~doubtful)) & ~occupied
    return occupied, free, ~(occupied | free)


def drawn_window(rng: np.random.Generator, shape: tuple[int, int]) -> kernels.Ends:
    top, bottom = np.sort(rng.integers(0, shape[0] + 1, 2)).tolist()
    left, right = np.sort(rng.integers(0, shape[1] + 1, 2)).tolist()
    return top, bottom, left, right


@settings(max_examples=120, deadline=None)
@given(SEEDS, st.integers(1, 40), st.integers(1, 40))
def test_masks_within_a_window_are_those_of_the_whole_map(seed, rows, cols):
    rng = np.random.default_rng(seed)
    evidence = rng.choice([-5, 0, 0, 3, 4, 9], (rows, cols)).astype(np.int16)
    drops = rng.choice([0, 1, 2], (rows, cols), p=[0.9, 0.07, 0.03]).astype(np.uint8)
    bumped, swept, doubtful = (rng.random((rows, cols)) < share for share in (0.05, 0.7, 0.2))
    layers = evidence, drops, bumped, swept, doubtful
    masks = tuple(rng.random((rows, cols)) < 0.5 for _ in range(3))
    before, window = [mask.copy() for mask in masks], drawn_window(rng, (rows, cols))
    _, known = kernels.derive(*layers, masks, 4, 2, window)
    part = np.s_[window[0] : window[1], window[2] : window[3]]
    for mask, was, whole in zip(masks, before, masks_by_opencv(*layers), strict=True):
        was[part] = whole[part]
        assert np.array_equal(mask, was)
    held = np.zeros((rows, cols), bool)
    held[part] = ~masks[2][part]
    assert known == box_of(held)


def box_of(mask: np.ndarray) -> kernels.Ends | None:
    """The smallest window that holds all that is marked."""
    if not mask.any():
        return None
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return int(rows[0]), int(rows[-1]) + 1, int(cols[0]), int(cols[-1]) + 1


@settings(max_examples=80, deadline=None)
@given(SEEDS, st.integers(1, 30), st.integers(1, 30))
def test_what_changed_of_the_masks_is_told_to_the_cell(seed, rows, cols):
    rng = np.random.default_rng(seed)
    evidence = rng.choice([-5, 0, 9], (rows, cols)).astype(np.int16)
    drops, bumped = np.zeros((rows, cols), np.uint8), np.zeros((rows, cols), bool)
    layers = evidence, drops, bumped, rng.random((rows, cols)) < 0.5, bumped
    masks = tuple(np.zeros((rows, cols), bool) for _ in range(3))
    whole = 0, rows, 0, cols
    kernels.derive(*layers, masks, 4, 2, whole)
    occupied, free = masks[0].copy(), masks[1].copy()
    spots = rng.integers(0, (rows, cols), (3, 2))
    evidence[tuple(spots.T)] = rng.choice([-5, 0, 9], 3)
    drops[tuple(rng.integers(0, (rows, cols), 2))] = 2
    changed, _ = kernels.derive(*layers, masks, 4, 2, whole)
    assert changed == box_of((masks[0] ^ occupied) | (masks[1] ^ free))


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.integers(1, 40), st.integers(1, 40), st.integers(0, 3))
def test_the_boundary_is_that_of_dilated_masks(seed, rows, cols, gap):
    rng = np.random.default_rng(seed)
    state = rng.choice(4, (rows, cols), p=[0.6, 0.2, 0.05, 0.15])
    free, unknown, occupied, given_up = (state == n for n in range(4))
    free |= given_up
    edge = rng.random((rows, cols)) < 0.3
    before, window = edge.copy(), drawn_window(rng, (rows, cols))
    changed = kernels.boundary(edge, free, unknown, occupied, given_up, gap, window)
    size = 2 * gap + 1
    beside = cv2.dilate(unknown.view(np.uint8), np.ones((3, 3), np.uint8)).reshape(rows, cols)
    walls = cv2.dilate(occupied.view(np.uint8), np.ones((size, size), np.uint8))
    whole = free & (beside > 0) & (walls.reshape(rows, cols) == 0) & ~given_up
    expected, part = before.copy(), np.s_[window[0] : window[1], window[2] : window[3]]
    expected[part] = whole[part]
    assert np.array_equal(edge, expected)
    assert changed == box_of(edge ^ before)


def labelled_by_opencv(mask: np.ndarray) -> list[np.ndarray]:
    count, labels = cv2.connectedComponents(mask.view(np.uint8), connectivity=8)
    return [np.argwhere(labels == n) for n in range(1, count)]


@settings(max_examples=150, deadline=None)
@given(SEEDS, st.integers(2, 40), st.integers(2, 40), st.floats(0.02, 0.7))
def test_connected_sets_are_opencvs_in_its_order(seed, rows, cols, share):
    mask = np.random.default_rng(seed).random((rows, cols)) < share
    found, expected = kernels.components(mask, 6, 4), labelled_by_opencv(mask)
    assert len(found) == len(expected)
    assert all(np.array_equal(a - (6, 4), b) for a, b in zip(found, expected, strict=True))


@settings(max_examples=80, deadline=None)
@given(SEEDS, st.integers(1, 20), st.integers(1, 20), st.integers(0, 4))
def test_what_two_sets_share_is_counted_cell_by_cell(seed, first, second, reach):
    rng = np.random.default_rng(seed)
    one, other = (rng.integers(0, 14, (n, 2)).astype(np.int32) for n in (first, second))
    apart = np.abs(one[:, None] - other[None]).max(axis=2).min(axis=1)
    assert kernels.shared(one, other, reach) == (apart <= reach).sum()


def terrain_by_numpy(distance, free, driven, dead_end, rules):
    """Clearance, where the body fits, speed."""
    rows, cols = np.indices(free.shape)
    x = rules.x0_m + (cols + rules.first_col + 0.5) * rules.cell_m - rules.x_m
    y = rules.y0_m + (rows + rules.first_row + 0.5) * rules.cell_m - rules.y_m
    away, hard = np.hypot(x, y), rules.hard_m
    clearance = distance * np.float32(rules.cell_m) - np.float32(rules.cell_m / 2)
    clearance = np.minimum(clearance, np.float32(rules.most_m))
    proven = free & (driven > 0)
    np.maximum(clearance, np.float32(hard), out=clearance, where=proven)
    if rules.squeeze_m > 0:
        tight = (away <= rules.squeeze_m) & free & (clearance >= rules.loose_m)
        np.maximum(clearance, np.float32(hard), out=clearance, where=tight)
    passable = free & (clearance >= hard) | (free & (away <= rules.escape_m))
    passable = passable & ~dead_end | (free & (away <= rules.dead_end_m))
    ease = np.clip((clearance - hard) / rules.comfort_m, 0.0, 1.0)
    speed = np.float32(rules.slowest) + np.float32(1 - rules.slowest) * ease
    speed[~passable] = 0
    return clearance, passable, speed


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.sampled_from([0.0, 0.7, math.inf]), st.floats(-1, 4), st.floats(-1, 4))
def test_terrain_is_what_numpy_makes_of_the_distances(seed, squeeze_m, x, y):
    rng, shape = np.random.default_rng(seed), (41, 53)
    distance = rng.choice([0.0, 1.0, 1.4, 3.7, 4.5, 8.0, 60.0], shape).astype(np.float32)
    free, dead_end = rng.random(shape) < 0.7, rng.random(shape) < 0.1
    driven = rng.integers(0, 2, shape).astype(np.uint8)
    rules = kernels.Rules(0.05, -1.013, 0.4, 7, 30, x, y, 0.7, 0.2, 0.2, 0.25, squeeze_m, 0.11,
                          0.35, 0.15)  # fmt: skip
    made = np.empty(shape, np.float32), np.empty(shape, bool), np.empty(shape, np.float32)
    kernels.survey(distance, free, driven, dead_end, made, rules)
    for one, other in zip(
        made, terrain_by_numpy(distance, free, driven, dead_end, rules), strict=True
    ):
        assert np.array_equal(one, other)


FREE = np.ones((4, 4), bool)
EVIDENCE = np.zeros((4, 4), np.int16)
NO_DROPS = np.zeros((4, 4), np.uint8)
LAYERS = EVIDENCE, NO_DROPS, FREE, FREE, FREE
FAR = np.array([[-(2**31), -(2**31)], [2**31 - 1, 2**31 - 1]], np.int32)
MANY = np.broadcast_to(np.zeros(50000, bool), (50000, 50000))
WHOLE = 0, 4, 0, 4
LONG = np.broadcast_to(np.zeros((1, 4), np.int16), (2**29, 4))


def test_a_window_may_be_in_numpys_numbers():
    window = tuple(np.array([1, 3, 0, 4]))
    masks = np.zeros((4, 4), bool), np.ones((4, 4), bool), np.ones((4, 4), bool)
    kernels.derive(EVIDENCE, NO_DROPS, ~FREE, ~FREE, ~FREE, masks, 4, 2, window)
    assert masks[1].any(axis=1).tolist() == [True, False, False, True]


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: kernels.solid(FREE.astype(np.float32), 1600, 0.01, 32, 8), "16 bits"),
        (lambda: kernels.derive(*LAYERS[:3], FREE[:2], FREE, (FREE,) * 3, 4, 2, WHOLE), "swept"),
        (lambda: kernels.derive(*LAYERS, (FREE,) * 3, 4, 2, (0, 5, 0, 4)), "window"),
        (lambda: kernels.derive(*LAYERS, (FREE,) * 3, 99999, 2, WHOLE), "occupied"),
        (lambda: kernels.derive(*LAYERS, (FREE,) * 3, 4, 0, WHOLE), "drop_at"),
        (lambda: kernels.boundary(FREE, FREE, FREE, FREE, FREE, -1, (0, 4, 0, 4)), "wall_gap"),
        (lambda: kernels.boundary(FREE, FREE, FREE, FREE, FREE, 1, (3, 2, 0, 4)), "window"),
        (lambda: kernels.components(FREE, -1, 0), "top"),
        (
            lambda: kernels.shared(np.zeros((2, 3), np.int32), np.zeros((2, 2), np.int32), 1),
            "cells",
        ),
        (lambda: kernels.shared(FAR, FAR, 1), "more cells than"),
        (
            lambda: _compiled.components(MANY, FAR[:0], np.zeros((1, 0), np.int32), 0, 0),
            "more cells than",
        ),
        (lambda: kernels.derive(LONG, *LAYERS[1:], (FREE,) * 3, 4, 2, WHOLE), "too large"),
    ],
)
def test_what_does_not_fit_is_told(call, error):
    with pytest.raises(ValueError, match=error):
        call()


@pytest.mark.parametrize("shape", [(48, 63), (47, 64), (24, 32)])
def test_a_depth_image_of_another_camera_is_told(shape):
    table = rays(CAMERA, Mount(), 2)
    view = kernels.DepthView(2, 5.0, 0.88, 0.07, 1.0, 1.0, 0.0, 1.0, 1.0, 20.0, SLACK, LIP_M, 3.0)
    with pytest.raises(ValueError, match="depth_m"):
        kernels.integrate(
            np.zeros((40, 40), np.int16), np.zeros((40, 40), np.uint8),
            np.zeros(shape, np.float32),
            (table.forward, table.left, table.up, table.reach), table.groups,
            len(table.azimuths), view, WEIGHTS, 130, 3,
        )  # fmt: skip
