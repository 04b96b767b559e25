"""Where a goal is looked at from, and that it is in the picture."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from hil_sim.ground_truth.closeups import close_up
from hil_sim.scenes.format import Room, Scene, SceneObject, Wall
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.viewpoints import floor_of
from hil_sim.simulation.scene_physics import ScenePhysics

pytestmark = pytest.mark.slow  # the software renderer draws each home a dozen times

CORNERS = ((0.0, 0.0), (5.0, 0.0), (5.0, 5.0), (0.0, 5.0))
CUBE = SceneObject("cube", "box", "builtin:box", (2.5, 2.5, 0.6), 0.5, (0.1, 0.1, 0.1))
SCREEN = SceneObject("screen", "other", "builtin:box", (2.5, 2.2, 0.0), 0.0, (2.0, 0.05, 1.4))


def room(*objects: SceneObject) -> Scene:
    ends = zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True)
    walls = tuple(Wall(start, end) for start, end in ends)
    return Scene("one", walls, (), (Room("all", "kitchen", CORNERS),), objects)


@pytest.mark.parametrize("others", [(), (SCREEN,)])
def test_a_small_thing_fills_the_picture_from_a_metre(others, tmp_path: Path):
    with ScenePhysics(room(CUBE, *others), Assets(tmp_path), "tiny") as world:
        seen = close_up(world, floor_of(world.scene), 0, (96, 72))
        assert seen is not None
        assert seen.away_m == pytest.approx(1.0, abs=0.1)
        assert seen.rgb.shape == (72, 96, 3)
        middle, corner = seen.rgb[36, 48].astype(int), seen.rgb[2, -3].astype(int)
        assert abs(middle - corner).sum() > 30  # the cube, not the wall behind it


def test_what_no_place_sees_is_not_drawn(tmp_path: Path):
    around = [
        replace(SCREEN, id=f"s{i}", yaw_rad=i * math.pi / 2, size_m=(0.8, 0.05, 2.4),
                position_m=(2.5 + 0.4 * math.sin(i * math.pi / 2),
                            2.5 - 0.4 * math.cos(i * math.pi / 2), 0.0))
        for i in range(4)
    ]  # fmt: skip
    with ScenePhysics(room(CUBE, *around), Assets(tmp_path), "tiny") as world:
        assert close_up(world, floor_of(world.scene), 0, (96, 72)) is None
