"""Depth put into another camera's pixels in C is what plain Python puts there."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.kernels.optics import Camera, register_depth

F32 = np.float32
HOLES = (0.0, -1.0, math.nan, math.inf, -math.inf, 1e30)
ROWS = ((1.0, 0.0, 0.0, 0.03), (0.0, 0.998, -0.06, 0.0), (0.0, 0.06, 0.998, -0.02))


def span(middle: F32, wide: F32, size: int) -> range:
    half = F32(0.5) * min(wide * F32(1.25), F32(8.0))
    first = max(np.floor(middle - half + F32(0.5)), F32(0))
    high = middle + half - F32(0.5)
    last = min(np.floor(high), F32(size - 1))
    if last < first or high < 0:
        return range(int(np.floor(middle)), int(np.floor(middle)) + 1)
    return range(int(first), int(last) + 1)


def by_python(shape, depth, across, down, rows, camera):
    """One pixel after the other."""
    seen = np.zeros(shape, F32)
    t = np.array(rows, F32)
    for d, a, b in zip(depth.ravel(), across.ravel(), down.ravel(), strict=True):
        if not (d > 0 and np.isfinite(d)):
            continue
        point = F32(a * d), F32(b * d), d
        x, y, z = (
            F32(F32(F32(r[0] * point[0]) + F32(r[1] * point[1])) + F32(r[2] * d)) + r[3] for r in t
        )
        if not z > F32(0.02):
            continue
        per_m = F32(1) / z
        u = F32(F32(F32(camera.fx) * x) * per_m) + F32(camera.cx)
        v = F32(F32(F32(camera.fy) * y) * per_m) + F32(camera.cy)
        if not (0 <= u < shape[1] and 0 <= v < shape[0]):
            continue
        larger = d * per_m
        for row in span(v, F32(camera.high) * larger, shape[0]):
            for col in span(u, F32(camera.wide) * larger, shape[1]):
                if not 0 < seen[row, col] <= z:
                    seen[row, col] = z
    return seen


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.sampled_from((0.4, 1.0, 2.6)))
def test_each_pixel_is_put_where_plain_python_puts_it(seed: int, wide: float):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.1, 4.0, (12, 16)).astype(F32)
    depth = np.where(rng.random(depth.shape) < 0.2, rng.choice(HOLES, depth.shape), depth)
    depth = depth.astype(F32)
    across, down = rng.uniform(-0.6, 0.6, (2, 12, 16)).astype(F32)
    camera = Camera(20.0 * wide, 20.0 * wide, 10.0, 8.0, wide, wide)
    seen = np.full((15, 20), -7.0, F32)
    register_depth(seen, depth, across, down, ROWS, camera)
    with np.errstate(all="ignore"):
        wanted = by_python(seen.shape, depth, across, down, ROWS, camera)
    np.testing.assert_array_equal(seen, wanted)


def test_rays_of_another_image_are_refused():
    depth = np.ones((4, 5), F32)
    camera = Camera(1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match=r"down: \(5, 5\) is not the shape of depth_m"):
        register_depth(depth.copy(), depth, depth, np.ones((5, 5), F32), ROWS, camera)
    with pytest.raises(TypeError, match="across"):
        register_depth(depth.copy(), depth, depth.astype(float), depth, ROWS, camera)
