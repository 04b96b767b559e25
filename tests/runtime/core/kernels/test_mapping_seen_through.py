"""What is seen through is what plain Python finds, cell by cell and height by height."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.geometry import map_to_optical, optical_to_base
from runtime.core.kernels import mapping as kernels
from runtime.core.types import Intrinsics, Mount, Pose

CAMERA = Intrinsics(48.0, 48.0, 32.0, 24.0, 64, 48)
MOUNTS = (Mount(), Mount(0.1, -0.05, 0.5, 0.02, 0.3, 0.1), Mount(z_m=0.3, yaw_rad=2.8))
SHAPE, CELL_M, AROUND = (60, 70), 0.05, 25
RULES = kernels.Through(3.0, 0.07, 0.15, 0.04, 0.02, 2, 0.8)
BETWEEN = 15  # places from one height to the next, at which nothing may be read either
HOLES = (0.0, np.nan, np.inf, -np.inf, -1.0, 3.01, 65.535)


def sight(depth: np.ndarray, at: np.ndarray) -> str:
    """What is read where a point (3,) of the camera's optical frame is in the image."""
    x, y, away = at
    if not 0.1 < away <= RULES.max_depth_m:
        return "out"
    half = CAMERA.fx * CELL_M / 2 / away
    left = math.floor(CAMERA.fx * x / away + CAMERA.cx - half)
    right = math.floor(CAMERA.fx * x / away + CAMERA.cx + half)
    row = math.floor(CAMERA.fy * y / away + CAMERA.cy)
    if left < 0 or right >= CAMERA.width or not 0 <= row < CAMERA.height:
        return "out"
    slack = RULES.margin_m + RULES.slack * away
    read = depth[row, left : right + 1].astype(np.float64)
    known = read[(read > 0) & (read <= RULES.max_depth_m)]
    if (known < away + slack).any():
        here = (known >= away - slack) & (known < away + slack)
        return "here" if here.any() else "hidden"
    return "passed" if len(known) == len(read) else "unknown"


def by_python(evidence, stood, depth, corner, pose, mount):
    evidence, stood = evidence.copy(), stood.copy()
    row, col = (math.floor((at - low) / CELL_M) for at, low in
                zip((pose.y_m, pose.x_m), corner[::-1], strict=True))  # fmt: skip
    for r, c in np.ndindex(SHAPE):
        if abs(r - row) > AROUND or abs(c - col) > AROUND:
            continue
        if evidence[r, c] <= 0:
            stood[r, c] = 0
            continue
        heights = RULES.lowest_m + RULES.apart_m / BETWEEN * np.arange(7 * BETWEEN + 1)
        points = np.column_stack([
            np.full(len(heights), corner[0] + (c + 0.5) * CELL_M),
            np.full(len(heights), corner[1] + (r + 0.5) * CELL_M), heights,
        ])  # fmt: skip
        optical = map_to_optical(points, pose, mount)
        seen = [sight(depth, at) for at in optical[::BETWEEN]]
        stands = {k for k in range(8) if stood[r, c] >> k & 1 or seen[k] == "here"}
        blocked = {k for k in range(8) if seen[k] in ("here", "hidden")}
        passed = {k for k in range(8) if seen[k] == "passed"}
        if blocked & (stands or set(range(8))):
            stands -= passed
        elif (
            (0 in passed or len(passed & stands) >= 3)
            and (stands or optical[0, 2] <= RULES.flat_m)
            and not any(sight(depth, at) == "here" for at in optical)
        ):
            evidence[r, c] -= RULES.miss
            stands = stands if evidence[r, c] > 0 else set()
        stood[r, c] = sum(1 << k for k in stands)
    return evidence, stood


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(MOUNTS), st.floats(-3, 3))
def test_it_is_what_plain_python_finds(seed: int, mount: Mount, yaw_rad: float):
    rng = np.random.default_rng(seed)
    evidence = rng.integers(-4, 6, SHAPE).astype(np.int16)
    stood = rng.integers(0, 256, SHAPE).astype(np.uint8)
    stood[rng.random(SHAPE) < 0.3] = 0
    depth = np.where(rng.random((48, 64)) < 0.9, 3.0, rng.uniform(0.1, 1.3, (48, 64)))
    depth[rng.random(depth.shape) < 0.02] = rng.choice(HOLES)
    depth = depth.astype(np.float32)
    corner, pose = (-1.7, -1.5), Pose(*rng.uniform(-2, 2, 2), yaw_rad)
    wanted = by_python(evidence, stood, depth, corner, pose, mount)
    before = evidence.copy()
    told = see_through(evidence, stood, depth, corner, pose, mount)
    np.testing.assert_array_equal(evidence, wanted[0])
    np.testing.assert_array_equal(stood, wanted[1])
    rows, cols = np.nonzero(evidence != before)
    box = (rows.min(), rows.max() + 1, cols.min(), cols.max() + 1) if len(rows) else None
    assert told == box


def see_through(evidence, stood, depth, corner, pose, mount) -> kernels.Ends | None:
    return kernels.see_through(
        evidence, stood, depth, (*corner, CELL_M, AROUND),
        (pose.x_m, pose.y_m, math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)),
        (mount.x_m, mount.y_m, mount.z_m, *optical_to_base(mount).ravel().tolist(),
         CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy),
        RULES,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("stood", "corner", "told"),
    [
        (np.zeros((60, 71), np.uint8), (0.0, 0.0), "stood"),
        (np.zeros(SHAPE, np.uint8), (math.nan, 0.0), "view"),
        (np.zeros(SHAPE, np.uint8), (math.inf, 0.0), "view"),
        (np.zeros(SHAPE, np.int16), (0.0, 0.0), "stood"),
    ],
)
def test_what_does_not_fit_is_told(stood: np.ndarray, corner: tuple[float, float], told: str):
    evidence, depth = np.zeros(SHAPE, np.int16), np.zeros((48, 64), np.float32)
    with pytest.raises((ValueError, TypeError), match=told):
        see_through(evidence, stood, depth, corner, Pose(0, 0, 0), Mount())


def test_without_cells_it_is_refused():
    arrays = np.zeros(SHAPE, np.int16), np.zeros(SHAPE, np.uint8), np.zeros((48, 64), np.float32)
    with pytest.raises(ValueError, match="no cells"):
        kernels.see_through(*arrays, (0.0, 0.0, 0.0, 5), (0.0,) * 4, (0.0,) * 16, RULES)
