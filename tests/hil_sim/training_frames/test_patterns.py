"""Patterns on rendered things."""

from random import Random

import numpy as np

from hil_sim.training_frames.patterns import patterned

GREY = np.full((120, 160, 3), 128, np.uint8)


def two_things() -> np.ndarray:
    things = np.full((120, 160), -1, np.int32)
    things[10:60, 10:100] = 0
    things[70:110, 40:150] = 4
    return things


def test_only_things_are_patterned_and_shade_stays() -> None:
    things, shaded = two_things(), GREY.copy()
    shaded[:, 80:] = 40
    out = patterned(Random(1), shaded, things, 1.0)
    assert (out[things < 0] == shaded[things < 0]).all()
    for thing in (0, 4):
        mask = things == thing
        lit, dark = out[mask & (shaded[..., 0] == 128)], out[mask & (shaded[..., 0] == 40)]
        assert lit.std(axis=0).max() > 3
        assert lit.mean() > 1.5 * dark.mean()
    assert not np.allclose(out[things == 0].mean(axis=0), out[things == 4].mean(axis=0), atol=5)


def test_a_share_of_the_things() -> None:
    things, rng = two_things(), Random(2)
    changed = [bool((patterned(rng, GREY, things, 0.3) != GREY).any()) for _ in range(60)]
    assert 0.3 < np.mean(changed) < 0.7  # 1 - 0.7 ** 2
    assert (patterned(rng, GREY, things, 0.0) == GREY).all()
