"""Holes in a floor: how deep they are, and the surfaces that are drawn of them."""

import math

import numpy as np
import pytest

from hil_sim.scenes.format import Hole
from hil_sim.scenes.holes import RISE_M, RUN_M, depth_at, levels, sides, trapezoids
from hil_sim.scenes.scene_file import load_scene

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
PIT = Hole(SQUARE, 1.5)
STAIRS = Hole(SQUARE, 0.6, math.pi / 2)  # down toward +y


def area(quads: np.ndarray) -> float:
    """Of (N, 4, 2), counter-clockwise."""
    x, y = quads[..., 0], quads[..., 1]
    return float((x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y).sum() / 2)


def test_a_pit_is_as_deep_everywhere_and_stairs_lead_down():
    assert depth_at([PIT], 1.0, 1.0) == 1.5
    assert depth_at([PIT], 2.1, 1.0) == 0.0
    treads = [depth_at([STAIRS], 1.0, y) for y in (0.1, 0.1 + RUN_M, 0.1 + 2 * RUN_M, 1.9)]
    assert treads == pytest.approx([RISE_M, 2 * RISE_M, 3 * RISE_M, 0.6])


@pytest.mark.parametrize("hole", [PIT, STAIRS])
def test_the_ground_covers_the_hole_once_at_its_depth(hole: Hole):
    parts = levels(hole)
    assert sum(area(trapezoids([part])) for part, _ in parts) == pytest.approx(4.0)
    for part, depth_m in parts:
        x, y = np.mean(part, axis=0)
        assert depth_at([hole], float(x), float(y)) == pytest.approx(depth_m)


def test_the_floor_is_what_no_hole_takes():
    around = ((-1.0, -1.0), (4.0, -1.0), (4.0, 4.0), (-1.0, 4.0))
    triangle = ((2.5, 0.0), (3.5, 0.5), (3.0, 3.0))
    assert area(trapezoids([around, SQUARE, triangle])) == pytest.approx(25 - 4 - 1.375)


def test_sides_stand_round_a_hole_and_face_into_it():
    upright = sides([PIT]).reshape(-1, 3, 3)
    a, b, c = upright.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    assert np.linalg.norm(normal, axis=1).sum() / 2 == pytest.approx(8.0 * 1.5)
    inward = np.array([1.0, 1.0]) - upright.mean(axis=1)[:, :2]
    assert ((normal[:, :2] * inward).sum(axis=1) > 0).all()


def test_no_side_stands_between_two_holes_of_one_depth():
    other = Hole(((2.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0)), 1.5)
    between = sides([PIT, other]).reshape(-1, 3, 3)[..., 0]
    assert not (np.abs(between - 2.0) < 1e-6).all(axis=1).any()


def test_stairs_have_a_riser_to_each_tread():
    heights = np.unique(sides([STAIRS])[..., 2].round(6))
    assert set(heights) >= {0.0, -round(RISE_M, 6), -round(2 * RISE_M, 6), -0.6}


@pytest.mark.parametrize(("name", "inside"), [("landing", (2.5, 2.0)), ("dais", (1.0, 4.0))])
def test_the_bundled_homes_with_edges_have_them(name: str, inside: tuple[float, float]):
    scene = load_scene(name)
    assert depth_at(scene.holes, *inside) > 0.15
    starts = [np.mean(area, axis=0) for area in scene.spawn]
    assert all(depth_at(scene.holes, float(x), float(y)) == 0 for x, y in starts)
