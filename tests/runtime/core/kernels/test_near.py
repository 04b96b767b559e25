"""What the compiled loop finds near the body is what plain NumPy does."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.geometry import rays
from runtime.core.kernels.near import NearRules, near_points
from runtime.core.types import Intrinsics, Mount

SEEDS = st.integers(0, 2**32 - 1)
CAMERA = Intrinsics(48.0, 48.0, 32.0, 24.0, 64, 48)
MOUNTS = (Mount(), Mount(0.1, -0.05, 0.5, 0.02, 0.5, 0.1), Mount(z_m=0.3, yaw_rad=2.8))
HOLES = (0.0, np.nan, np.inf, -np.inf, -1.0, 65.535)
F32 = np.float32


def rules(stride=1, mount=MOUNTS[0], **other):
    told = {
        "floor_m": 0.07, "slack": 0.02, "height_m": 1.0, "ahead_m": 2.5, "aside_m": 1.5,
        "behind_m": 0.3, "cell_m": 0.1, "least": 3.0, "least_drops": 5.0,
    }  # fmt: skip
    return NearRules(stride, 5.0, mount.x_m, mount.y_m, mount.z_m, **(told | other))


def by_numpy(depth, table, n):
    """Every cell in turn, of all pixels at once."""
    d = depth[n.stride // 2 :: n.stride, n.stride // 2 :: n.stride]
    with np.errstate(all="ignore"):
        height = d * table.up + F32(n.z_m)
        ahead, aside = d * table.forward, d * table.left
        off = F32(n.floor_m) + F32(n.slack) * np.hypot(ahead, aside)
        valid = (d > 0) & (d <= F32(5.0)) & (height <= F32(n.height_m))
        share = F32(n.z_m) / -table.up
        below = share * table.forward, share * table.left
    found = []
    for kind, is_it, (x, y), least in (
        (0, valid & (height >= off), (ahead, aside), n.least),
        (1, valid & (height < -off), below, n.least_drops),
    ):
        x, y = (x + F32(n.x_m))[is_it], (y + F32(n.y_m))[is_it]
        z = height[is_it]
        per_m = F32(1 / n.cell_m)
        near = (x >= -n.behind_m) & (x < n.ahead_m) & (np.abs(y) < n.aside_m)
        x, y, z = x[near], y[near], z[near]
        row = ((x + F32(n.behind_m)) * per_m).astype(int)
        col = ((y + F32(n.aside_m)) * per_m).astype(int)
        for r, c in sorted(set(zip(row, col, strict=True))):
            here = (row == r) & (col == c)
            around = (np.abs(row - r) <= 1) & (np.abs(col - c) <= 1)
            if around.sum() >= least:
                found.append((x[here].mean(), y[here].mean(), z[here].mean(), kind, z[here].min()))
    return np.array(found).reshape(-1, 5)


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.sampled_from(MOUNTS), st.sampled_from((1, 2, 3)))
def test_near_points_are_those_of_numpy(seed, mount, stride):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.2, 4.0) * np.ones((48, 64)) * rng.choice([1.0, 0.6], (48, 64))
    depth = np.where(rng.random((48, 64)) < 0.3, rng.choice(HOLES, (48, 64)), depth).astype(F32)
    table, n = rays(CAMERA, mount, stride), rules(stride, mount)
    found = np.empty((4000, 5), F32)
    count = near_points(found, depth, table.forward, table.left, table.up, n)
    wanted = by_numpy(depth, table, n)
    assert count == len(wanted)
    assert found[:count] == pytest.approx(wanted, abs=1e-4)


def test_no_more_is_told_than_there_is_room_for():
    table = rays(CAMERA, Mount(), 1)
    depth, found = np.full((48, 64), 1.0, F32), np.full((3, 5), -1.0, F32)
    assert near_points(found[:2], depth, table.forward, table.left, table.up, rules()) == 2
    assert (found[2] == -1.0).all()


@pytest.mark.parametrize(
    ("other", "shape", "columns", "told"),
    [
        ({"stride": 0}, (48, 64), 5, "stride"),
        ({}, (48, 63), 5, "depth_m"),
        ({}, (48, 64), 4, "found"),
        ({"cell_m": 0.0}, (48, 64), 5, "cells"),
        ({"cell_m": float("nan")}, (48, 64), 5, "cells"),
        ({"cell_m": 1e-6}, (48, 64), 5, "cells"),
        ({"aside_m": float("inf")}, (48, 64), 5, "cells"),
    ],
)
def test_what_does_not_fit_is_told(other, shape, columns, told):
    table, depth = rays(CAMERA, Mount(), 1), np.ones(shape, F32)
    found = np.empty((10, columns), F32)
    with pytest.raises(ValueError, match=told):
        near_points(found, depth, table.forward, table.left, table.up, rules()._replace(**other))
