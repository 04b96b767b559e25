"""What stands near the body by one image."""

import math

import numpy as np
import pytest

from runtime.core.geometry import optical_to_base, rays
from runtime.core.mapping.near_points import AHEAD_M, near_points
from runtime.core.mapping.solid_depth import solid
from runtime.core.types import Intrinsics, Mount

CAMERA = Intrinsics(262.0, 262.0, 160.0, 120.0, 320, 240)
LEVEL, TILTED = Mount(), Mount(0.1, 0.0, 0.6, 0.0, 0.5, 0.0)
HEIGHT_M, MOST_M = 1.0, 5.0


def view(mount, *boxes, pit=None, noise=0.0):
    """Depth (H, W) of a floor at 0 in a room of 4 m, with boxes (x0, x1, y0, y1, z0, z1) m, base
    frame; `pit` (x0, x1, y0, y1): there the floor is a metre lower."""
    table = rays(CAMERA, mount, 1)
    at = np.array([mount.x_m, mount.y_m, mount.z_m])
    d = np.stack([table.forward, table.left, table.up], axis=-1).astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(d[..., 2] < 0, -at[2] / d[..., 2], np.inf)
        if pit is not None:
            x, y = at[0] + depth * d[..., 0], at[1] + depth * d[..., 1]
            inside = (x > pit[0]) & (x < pit[1]) & (y > pit[2]) & (y < pit[3])
            depth = np.where(inside, -(at[2] + 1.0) / d[..., 2], depth)
        depth = np.minimum(depth, np.where(d[..., 0] > 0, (4.0 - at[0]) / d[..., 0], np.inf))
        for box in boxes:
            low, high = np.array(box[::2]), np.array(box[1::2])
            a, b = (low - at) / d, (high - at) / d
            enters, leaves = np.minimum(a, b).max(axis=-1), np.maximum(a, b).min(axis=-1)
            hit = (enters < leaves) & (enters > 0)
            depth = np.where(hit, np.minimum(depth, enters), depth)
    rng = np.random.default_rng(0)
    depth = depth * (1 + noise * rng.standard_normal(depth.shape))
    return np.where(depth < 6.0, depth, 0.0).astype(np.float32)


@pytest.mark.parametrize("mount", [LEVEL, TILTED])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_an_empty_floor_is_empty_however_it_is_seen(mount, noise):
    seen = near_points(view(mount, noise=noise), CAMERA, mount, HEIGHT_M, MOST_M)
    assert not len(seen.obstacles)
    assert not len(seen.drops)


@pytest.mark.parametrize("mount", [LEVEL, TILTED])
def test_a_box_and_a_leg_are_where_they_stand(mount):
    box = (1.3, 1.6, -0.2, 0.2, 0.0, 0.8)
    leg = (1.0, 1.03, 0.5, 0.53, 0.0, 0.7)
    seen = near_points(view(mount, box, leg), CAMERA, mount, HEIGHT_M, MOST_M)
    x, y, z = seen.obstacles.T
    front = np.abs(y) < 0.22
    assert x[front].min() == pytest.approx(1.3, abs=0.02)
    assert np.hypot(x[~front] - 1.0, y[~front] - 0.5).max() < 0.06
    assert (~front).any()
    assert (z < HEIGHT_M).all()
    assert (seen.lowest_m <= z).all()
    assert seen.lowest_m[front].min() < 0.3
    assert not len(seen.drops)


def test_what_hangs_higher_than_the_body_is_passed_under():
    shelf = (1.0, 1.4, -0.5, 0.5, 1.05, 1.3)
    assert not len(near_points(view(LEVEL, shelf), CAMERA, LEVEL, 1.0, MOST_M).obstacles)
    assert len(near_points(view(LEVEL, shelf), CAMERA, LEVEL, 1.2, MOST_M).obstacles)


def test_a_pit_is_told_where_its_floor_is_missing():
    pit = (1.0, 1.8, -0.5, 0.5)
    seen = near_points(view(TILTED, pit=pit, noise=0.01), CAMERA, TILTED, HEIGHT_M, MOST_M)
    assert seen.drops[:, 0].min() == pytest.approx(1.0, abs=0.05)
    assert (seen.drops[:, 0] < 1.85).all()
    assert (np.abs(seen.drops[:, 1]) < 0.55).all()
    assert not len(seen.obstacles)


def test_a_few_pixels_in_mid_air_are_nothing():
    depth = view(LEVEL)
    rng = np.random.default_rng(1)
    for _ in range(60):
        depth[rng.integers(240), rng.integers(320)] = rng.uniform(0.3, 1.5)
    assert not len(near_points(solid(depth), CAMERA, LEVEL, HEIGHT_M, MOST_M).obstacles)


def test_unknown_depth_tells_nothing():
    for value in (0.0, math.nan, math.inf, -1.0):
        depth = np.full((240, 320), value, np.float32)
        seen = near_points(depth, CAMERA, LEVEL, HEIGHT_M, MOST_M)
        assert not len(seen.obstacles)
        assert not len(seen.drops)


def test_only_what_is_near_is_told():
    far = (AHEAD_M + 0.1, 3.0, -0.4, 0.4, 0.0, 0.9)
    assert not len(near_points(view(LEVEL, far), CAMERA, LEVEL, HEIGHT_M, MOST_M).obstacles)
    turned = Mount(yaw_rad=math.pi / 2)
    beside = (-0.3, 0.3, 1.2, 1.4, 0.0, 0.9)
    seen = near_points(view(turned, beside), CAMERA, turned, HEIGHT_M, MOST_M)
    assert seen.obstacles[:, 1].min() == pytest.approx(1.2, abs=0.02)
    assert optical_to_base(turned)[1, 2] == pytest.approx(1.0)  # it looks to the left
