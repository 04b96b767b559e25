"""Drawing through EGL: each in a process of its own, as the renderer wants it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hil_sim import egl

TWO_BOXES = """
import json, sys
import numpy as np
from pathlib import Path
from hil_sim.assets import Assets
from hil_sim.scene import Room, Scene, SceneObject
from hil_sim.world import Camera, World

floor = ((-1.0, -2.0), (5.0, -2.0), (5.0, 2.0), (-1.0, 2.0))
boxes = tuple(
    SceneObject(f"box-{n}", "other", "builtin:box", (3.0, y, 0.5), 0.0, (side, side, side))
    for n, (y, side) in enumerate([(-0.8, 0.8), (0.8, 0.4)])
)
scene = Scene("two", (), (), (Room("a", "bedroom", floor),), boxes)
with World(scene, Assets(Path(sys.argv[1])), sys.argv[2]) as world:
    frame = world.render(0.0, 0.0, 0.0, Camera(320, 240))
    fronts = [float(np.median(frame.depth_m[frame.segmentation == n])) for n in (0, 1)]
    Path(sys.argv[3]).write_text(json.dumps([world.renderer, *fronts]))
"""


def draw(tmp_path: Path, renderer: str, **env: str) -> tuple[str, float, float]:
    """The renderer used, and how far away it shows the fronts of a 0.8 m and a 0.4 m box."""
    result = tmp_path / "result.json"
    command = [sys.executable, "-c", TWO_BOXES, str(tmp_path), renderer, str(result)]
    subprocess.run(command, env=os.environ | env, check=True, capture_output=True, timeout=120)
    used, large, small = json.loads(result.read_text())
    return used, large, small


@pytest.mark.skipif(not egl.available(), reason="no EGL device can be opened on this machine")
def test_two_sizes_of_one_mesh_are_both_drawn_right(tmp_path: Path):
    used, large, small = draw(tmp_path, "egl")
    assert used == "egl"
    assert large == pytest.approx(2.6, abs=0.01)
    assert small == pytest.approx(2.8, abs=0.01)


def test_without_a_driver_auto_falls_back(tmp_path: Path):
    used, large, small = draw(tmp_path, "auto", __EGL_VENDOR_LIBRARY_FILENAMES="/none")
    assert used == "tiny"
    assert (large, small) == pytest.approx((2.6, 2.8), abs=0.01)
