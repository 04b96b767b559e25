"""Depth as real cameras give it: errors by distance, steps, range, holes, and the same twice."""

import numpy as np
import pytest

from hil_sim.simulation.depth_cameras import CAMERAS, edges, mixed, photograph_depth

H, W = 120, 160
FOCAL_PX = 97.0
NO_GLASS = np.zeros((H, W), bool)
ROUGH = np.random.default_rng(1).integers(90, 166, (H, W, 1)).repeat(3, 2).astype(np.uint8)


def wall(metres: float) -> np.ndarray:
    return np.full((H, W), metres, np.float32)


def post() -> np.ndarray:
    """A post 1 m away before a wall 3 m away, in columns 70 to 89."""
    depth = wall(3.0)
    depth[:, 70:90] = 1.0
    return depth


def photographed(
    name: str, depth: np.ndarray, rgb: np.ndarray = ROUGH, seed: int = 0
) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return photograph_depth(CAMERAS[name], depth, rgb, NO_GLASS, FOCAL_PX, rng)


@pytest.mark.parametrize("metres", [1.0, 2.0, 3.0])
@pytest.mark.parametrize(
    ("name", "sigma_1m"), [("kinect-v1", 0.07 / 43.5), ("realsense-d435", 0.08 / 22.35)]
)
def test_error_grows_with_the_square_where_disparity_is_measured(
    name: str, sigma_1m: float, metres: float
) -> None:
    read = photographed(name, wall(metres))
    read = read[read > 0]
    step = 0.125 / 43.5 * metres**2 if name == "kinect-v1" else 0.0
    assert read.std() == pytest.approx(np.hypot(sigma_1m * metres**2, step / 12**0.5), rel=0.15)
    assert read.mean() == pytest.approx(metres, abs=0.003 * metres**2)


def test_disparity_comes_in_steps() -> None:
    read = photographed("kinect-v1", wall(3.0))
    disparity = 43.5 / read[read > 0]
    np.testing.assert_allclose(disparity * 8, np.round(disparity * 8), atol=1e-3)
    assert len(np.unique(read)) < 12


def test_time_of_flight_errs_less_where_more_light_comes_back() -> None:
    def deviation(metres: float, light: int) -> float:
        read = photographed("azure-kinect", wall(metres), np.full((H, W, 3), light, np.uint8))
        return float(read[read > 0].std())

    assert deviation(3.8, 40) == pytest.approx(0.017, rel=0.1)
    assert deviation(1.9, 40) == pytest.approx(0.0085, rel=0.1)
    assert deviation(1.9, 160) == pytest.approx(0.00425, rel=0.1)
    dark = photographed("azure-kinect", wall(3.0), np.full((H, W, 3), 10, np.uint8))
    assert (dark == 0).all()


@pytest.mark.parametrize("name", CAMERAS)
def test_nothing_out_of_range_and_nothing_where_nothing_is(name: str) -> None:
    near_m, far_m = CAMERAS[name].near_m, CAMERAS[name].far_m
    for metres in (near_m / 2, far_m * 1.5, 0.0):
        assert (photographed(name, wall(metres)) == 0).all()
    middle = photographed(name, wall((near_m + min(far_m, 4)) / 2))
    assert (middle > 0).mean() > 0.8


@pytest.mark.parametrize(("name", "side"), [("kinect-v1", 1), ("realsense-d435", -1)])
def test_what_is_hidden_from_the_second_eye_is_a_hole_beside_the_post(name: str, side: int) -> None:
    lost = (photographed(name, post()) == 0).mean(axis=0)
    width = FOCAL_PX * CAMERAS[name].baseline_m * (1 / 1.0 - 1 / 3.0)
    shadow = slice(91, 91 + int(width) - 1) if side > 0 else slice(70 - int(width), 68)
    other = slice(60, 68) if side > 0 else slice(91, 99)
    assert (lost[shadow] == 1).all()
    assert (lost[other] < 0.2).all()


def test_stereo_loses_its_left_band_and_what_has_no_texture_afar() -> None:
    read = photographed("realsense-d435", wall(0.5))
    band = int(FOCAL_PX * 0.05 / 0.5)
    assert (read[:, :band] == 0).all()
    assert (read[:, band + 1 :] > 0).mean() > 0.9
    smooth = np.full((H, W, 3), 120, np.uint8)
    near, far = (photographed("realsense-d435", wall(z), smooth) for z in (2.0, 4.5))
    assert (near > 0).mean() > 0.95
    assert 0.1 < (far > 0).mean() < 0.4


def test_light_by_way_of_the_walls_lengthens_corners() -> None:
    column = np.abs(np.arange(W) - 80) / 40
    corner = np.broadcast_to(3.0 - column, (H, W)).astype(np.float32)
    reads = [photographed("azure-kinect", corner, seed=n) for n in range(8)]
    error = np.mean([np.where(r > 0, r - corner, np.nan) for r in reads], axis=0)
    assert np.nanmean(error[:, 75:85]) > 0.02
    assert abs(np.nanmean(error[:, 20:30])) < 0.005


def test_mixed_pixels_lie_between_at_edges_alone() -> None:
    depth = post()
    read = mixed(depth, 0.5, np.random.default_rng(0))
    changed = read != depth
    assert (edges(depth) | ~changed).all()
    assert changed[edges(depth)].mean() == pytest.approx(0.5, abs=0.1)
    assert read.min() >= 1.0
    assert read.max() <= 3.0


@pytest.mark.parametrize("name", CAMERAS)
def test_the_same_seed_gives_the_same_image(name: str) -> None:
    first = photographed(name, post())
    np.testing.assert_array_equal(photographed(name, post()), first)
    assert (photographed(name, post(), seed=1) != first).any()
