"""Lenses that bend: images as a pinhole takes them, against formulas worked out by hand."""

import numpy as np
import pytest
from bent_lens import directions, painted, wall

from runtime.core.optics.lens import Lens, lens_rays, straightened
from runtime.core.optics.upright import upright_image
from runtime.core.types import Intrinsics

CAMERA = Intrinsics(150.0, 155.0, 82.0, 57.0, 160, 120)
LENSES = {
    "plumb_bob": (-0.28, 0.07, 0.001, -0.0012, 0.0),
    "rational_polynomial": (0.4, -0.1, 0.0005, 0.0003, 0.02, 0.72, -0.05, 0.01),
    "equidistant": (-0.02, 0.006, -0.003, 0.0004),
}
KINDS = pytest.mark.parametrize("model", sorted(LENSES))


def lens(model: str) -> Lens:
    return Lens(CAMERA, LENSES[model], model == "equidistant")


@KINDS
@pytest.mark.parametrize("quarters", range(4))
def test_colour_is_what_a_pinhole_sees(model: str, quarters: int):
    straight = straightened(lens(model), quarters)
    taken = painted(*directions(CAMERA, model, LENSES[model]))
    wanted = upright_image(painted(*directions(CAMERA)), quarters)
    got = straight.color(taken)
    assert got.shape == wanted.shape
    seen = got.any(axis=2)
    assert seen.mean() > 0.9
    off = np.abs(got.astype(int) - wanted)[seen].max(axis=1)
    assert np.quantile(off, 0.99) <= 3
    bent = np.abs(upright_image(taken, quarters).astype(int) - wanted)
    assert bent.max() > 10  # there was something to undo
    assert straight.intrinsics.width == wanted.shape[1]


@KINDS
def test_depth_is_the_nearest_reading_and_none_is_made_up(model: str):
    taken = wall(*directions(CAMERA, model, LENSES[model]))
    got, wanted = straightened(lens(model)).depth(taken), wall(*directions(CAMERA))
    assert np.isin(got[got > 0], taken).all()
    np.testing.assert_allclose(got[got > 0], wanted[got > 0], rtol=0.006)


@KINDS
def test_rays_are_those_of_the_lens(model: str):
    across, down = lens_rays(lens(model))
    x, y = directions(CAMERA, model, LENSES[model])
    np.testing.assert_allclose(across, x, atol=2e-4)
    np.testing.assert_allclose(down, y, atol=2e-4)


def test_a_pinhole_s_images_are_not_touched():
    straight = straightened(Lens(CAMERA))
    rgb, depth = np.zeros((120, 160, 3), np.uint8), np.zeros((120, 160), np.float32)
    assert straight.color(rgb) is rgb
    assert straight.depth(depth) is depth
    assert straight.intrinsics is CAMERA


def test_a_polynomial_that_turns_back_shows_no_place_twice():
    folding = Lens(CAMERA, (-1.2, 0.0, 0.0, 0.0, 0.0))  # beyond r = 0.53 it comes back
    straight = straightened(folding)
    x, y = directions(CAMERA)
    got = straight.depth(np.ones((120, 160), np.float32))
    assert not got[np.hypot(x, y) > 0.56].any()
    assert got[np.hypot(x, y) < 0.4].all()
    assert straight.share < 1
