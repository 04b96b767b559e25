"""What the off-screen renderer draws: where things are, what is whose, and light; and who draws
where there is no EGL."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from hil_sim.simulation.raster import NOTHING, Raster, RasterError
from hil_sim.simulation.shell import Surface

LIGHT = ((0.3, -0.4, 0.9), (1.0, 1.0, 1.0), 0.5, 0.5)
SIZE = (160, 120)
HFOV = math.radians(79)
CUBE = np.array(
    [
        [[x, y, z] for x, y, z in face]
        for face in (
            [(-1, -1, 0), (-1, 1, 2), (-1, 1, 0)], [(-1, -1, 0), (-1, -1, 2), (-1, 1, 2)],
            [(-1, -1, 2), (1, -1, 2), (1, 1, 2)], [(-1, -1, 2), (1, 1, 2), (-1, 1, 2)],
            [(-1, -1, 0), (1, -1, 0), (1, -1, 2)], [(-1, -1, 0), (1, -1, 2), (-1, -1, 2)],
        )
    ],
    float,
)  # fmt: skip
FLOOR = np.array(
    [[[-9, -9, 0], [9, -9, 0], [9, 9, 0]], [[-9, -9, 0], [9, 9, 0], [-9, 9, 0]]], float
)


def available() -> bool:
    try:
        Raster().close()
    except RasterError:
        return False
    return True


needs_egl = pytest.mark.skipif(not available(), reason="no EGL device can be opened here")


def written(tmp_path: Path, name: str, triangles: np.ndarray, bgr: tuple[int, int, int]) -> Path:
    obj, skin = tmp_path / f"{name}.obj", tmp_path / f"{name}.png"
    cv2.imwrite(str(skin), np.full((4, 4, 3), bgr, np.uint8))
    Surface(triangles, np.zeros((len(triangles), 3, 2))).write(obj, skin)
    return obj


def look(raster: Raster, x: float = 0.0, yaw: float = 0.0, **more):
    return raster.draw((x, 0.0, 0.9), yaw, 0.0, SIZE, HFOV, LIGHT, **more)


@needs_egl
def test_depth_colour_and_owner_of_two_sizes_of_one_mesh(tmp_path: Path):
    with Raster() as raster:
        cube = written(tmp_path, "cube", CUBE, (10, 20, 200))
        raster.add(cube, (4.0, 1.2, 0.0), 0.0, (0.5, 0.5, 0.5), owner=0)
        raster.add(cube, (4.0, -1.2, 0.0), 0.0, (0.25, 0.5, 0.5), owner=7)
        rgb, depth, owner = look(raster)
    assert set(np.unique(owner)) == {NOTHING, 0, 7}
    assert np.median(depth[owner == 0]) == pytest.approx(3.5, abs=0.002)
    assert np.median(depth[owner == 7]) == pytest.approx(3.75, abs=0.002)
    left = np.argwhere(owner == 0)[:, 1].mean()
    right = np.argwhere(owner == 7)[:, 1].mean()
    assert left < SIZE[0] / 2 < right
    red = rgb[owner == 0]
    assert (red[:, 0] > 4 * red[:, 2]).all()
    assert (depth[owner == NOTHING] == 0).all()


@needs_egl
def test_paint_takes_the_place_of_a_colour_and_keeps_light_and_dark(tmp_path: Path):
    with Raster() as raster:
        for owner, grey in enumerate((40, 220)):
            cube = written(tmp_path, f"cube{owner}", CUBE, (grey, grey, 200))  # BGR: red
            place = (4.0, 1.2 - 2.4 * owner, 0.0), 0.0, (0.5, 0.5, 0.5)
            raster.add(cube, *place, owner=owner, paint=(0.1, 0.2, 0.8))
        rgb, _, owners = look(raster)
    dark, light = (rgb[owners == owner].mean(axis=0) for owner in (0, 1))
    for painted in (dark, light):
        assert painted[2] > 3 * painted[0]
    assert light[2] > 1.2 * dark[2]


@needs_egl
def test_a_thing_throws_a_shadow_on_the_floor_and_moves_with_it(tmp_path: Path):
    floor, cube = (
        written(tmp_path, "floor", FLOOR, (200, 200, 200)),
        written(tmp_path, "cube", CUBE, (10, 20, 200)),
    )
    with Raster() as raster:
        raster.add(floor)
        number = raster.add(cube, (4.0, 0.0, 0.0), 0.0, (0.4, 0.4, 0.4), owner=0)
        first, _, owner = look(raster)
        ground = first[owner == NOTHING][:, 0]
        tones = np.unique(ground[ground > 60])
        assert tones.max() - tones.min() > 20  # lit, and not
        raster.place(number, (40.0, 0.0, 0.0), 0.0)
        second, _, owner = look(raster)
    ground = second[-20:, :, 0]
    assert (owner == NOTHING).all()
    assert ground.max() - ground.min() <= 2


@needs_egl
def test_the_same_view_is_the_same_picture_whatever_was_drawn_before(tmp_path: Path):
    cube = written(tmp_path, "cube", CUBE, (10, 20, 200))
    with Raster() as raster:
        raster.add(cube, (4.0, 1.0, 0.0), 0.4, (0.5, 0.5, 0.5), owner=0)
        first = look(raster)
        look(raster, 1.0, 2.0)
        again = look(raster)
        depth_only = look(raster, colour=False)
    for a, b in zip(first, again, strict=True):
        assert a.tobytes() == b.tobytes()
    assert not depth_only[0].any()
    assert depth_only[1].tobytes() == first[1].tobytes()


WHICH = """
import sys
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.format import Room, Scene, SceneObject
from hil_sim.simulation.camera import CameraModel
from hil_sim.simulation.scene_physics import ScenePhysics
from pathlib import Path
floor = ((-1.0, -2.0), (5.0, -2.0), (5.0, 2.0), (-1.0, 2.0))
box = SceneObject("box", "other", "builtin:box", (3.0, 0.0, 0.5), 0.0, (0.8, 0.8, 0.8))
scene = Scene("one", (), (), (Room("a", "bedroom", floor),), (box,))
with ScenePhysics(scene, Assets(Path(sys.argv[1])), sys.argv[2]) as world:
    frame = world.render(0.0, 0.0, 0.0, CameraModel(320, 240))
    front = sorted(frame.depth_m[frame.segmentation == 0].tolist())
    Path(sys.argv[3]).write_text(f'["{world.renderer}", {front[len(front) // 2]}]')
"""


def used(tmp_path: Path, renderer: str, **env: str) -> tuple[list, str]:
    out = tmp_path / "out.json"
    command = [sys.executable, "-c", WHICH, str(tmp_path), renderer, str(out)]
    done = subprocess.run(
        command, env=os.environ | env, capture_output=True, text=True, timeout=120
    )
    return (json.loads(out.read_text()) if out.is_file() else []), done.stderr


def test_without_egl_the_software_renderer_draws_the_same_geometry(tmp_path: Path):
    nowhere = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json"}
    found, _ = used(tmp_path, "auto", **nowhere)
    assert found[0] == "tiny"
    assert found[1] == pytest.approx(2.6, abs=0.02)


def test_egl_that_is_asked_for_and_not_there_is_an_error(tmp_path: Path):
    nowhere = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json"}
    found, said = used(tmp_path, "egl", **nowhere)
    assert not found
    assert "renderer: egl" in said.splitlines()[-1]
