"""Flying pixels go, thin things, edges and slopes stay."""

import numpy as np
import pytest

from runtime.core.mapping.solid_depth import solid
from runtime.core.types import Intrinsics

H, W = 120, 160
CAMERA = Intrinsics(97.0, 97.0, W / 2, H / 2, W, H)
NEAR_M, FAR_M = 2.0, 4.0


def edge(veil: int) -> np.ndarray:
    """A wall before another from column 80 on, with a veil of so many pixels on the edge."""
    depth = np.full((H, W), FAR_M, np.float32)
    depth[:, 80:] = NEAR_M
    depth[:, 80 : 80 + veil] = np.linspace(FAR_M, NEAR_M, veil + 2)[1:-1]
    return depth


def plane(normal: tuple[float, float, float], away_m: float, far_m: float = 5.0) -> np.ndarray:
    """A plane with that unit normal (optical frame), so far from the camera."""
    v, u = np.indices((H, W)) + 0.5
    rays = np.stack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones((H, W))])
    along = np.tensordot(normal, rays, 1)
    depth = away_m / np.where(along > 1e-6, along, np.inf)
    return np.where((depth > 0) & (depth <= far_m), depth, 0).astype(np.float32)


@pytest.mark.parametrize("veil", [1, 2])
@pytest.mark.parametrize("upright", [True, False])
def test_a_veil_between_two_walls_goes_and_the_walls_stay(veil: int, upright: bool) -> None:
    depth = edge(veil) if upright else np.ascontiguousarray(edge(veil).T)
    left = solid(depth)
    between = (depth > NEAR_M + 0.01) & (depth < FAR_M - 0.01)
    assert between.sum() == veil * H
    assert (left[between] == 0).all()
    np.testing.assert_array_equal(left[~between], depth[~between])


def test_it_is_a_copy_and_unknown_stays_unknown() -> None:
    depth = edge(1)
    depth[5, 5], depth[50, 81] = np.nan, 0.0
    before = depth.copy()
    left = solid(depth)
    np.testing.assert_array_equal(depth, before)
    assert np.isnan(left[5, 5])
    assert left[50, 81] == 0


def test_a_veil_beside_the_shadow_of_what_stands_before_goes() -> None:
    depth = edge(1)
    depth[:, 70:80] = 0.0
    assert (solid(depth)[:, 80] == 0).all()


@pytest.mark.parametrize("width", [1, 2, 3])
def test_a_leg_stays(width: int) -> None:
    depth = np.full((H, W), FAR_M, np.float32)
    depth[:, 81:] = 3.2  # what is behind it differs from side to side
    depth[20:100, 80 : 80 + width] = 2.5
    np.testing.assert_array_equal(solid(depth)[20:100, 80 : 80 + width], 2.5)


@pytest.mark.parametrize(
    "depth",
    [
        plane((0, 1, 0), 0.88),  # the floor, as far as depth is used
        plane((0, 1, 0), 0.13),  # a table a little lower than the camera
        plane((0.9998, 0, 0.02), 0.25),  # a wall that the robot drives along
        edge(0),
    ],
    ids=["floor", "table", "wall", "edge"],
)
def test_slopes_and_sharp_edges_stay(depth: np.ndarray) -> None:
    np.testing.assert_array_equal(solid(depth), depth)


def test_noise_is_no_veil() -> None:
    depth = plane((0, 1, 0), 0.88)
    noise = np.random.default_rng(0).standard_normal(depth.shape)
    noisy = (depth + 0.004 * depth**2 * noise).astype(np.float32)
    assert (solid(noisy)[depth > 0] == 0).mean() < 0.002
