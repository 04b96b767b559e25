"""A whole turn on the spot in a furnished home, as PyBullet renders it, by a camera's noise."""

import math
from typing import Any

import numpy as np
import pytest

from hil_sim.driving.rig import camera_of, open_world
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.protocol import ONROBOT
from runtime.core.types import Intrinsics, Mount
from runtime.doctor.hearing import Glimpse, glimpse
from runtime.doctor.sight import seen_turns

STEP_RAD = 0.35


@pytest.mark.slow  # it renders 18 frames
def test_its_sum_is_right_within_two_percent():
    camera, noise = camera_of(ONROBOT), np.random.default_rng(0)
    focal = camera.width / 2 / math.tan(camera.hfov_rad / 2)
    middle = camera.width / 2, camera.height / 2
    intrinsics = Intrinsics(focal, focal, *middle, camera.width, camera.height)
    scene = open_scene("maple")
    x, y = np.array(scene.rooms[0].polygon).mean(axis=0)

    def seen(world: Any, n: int) -> Glimpse:
        frame = world.render(x, y, n * STEP_RAD, camera, ONROBOT.tilt_rad)
        rgb = np.clip(frame.rgb + noise.normal(0, 6, frame.rgb.shape), 0, 255).astype(np.uint8)
        depth = frame.depth_m * (1 + noise.normal(0, 0.01, frame.depth_m.shape))
        depth[noise.random(depth.shape) < 0.2] = 0
        return glimpse((n + 1) * 10**8, rgb, depth.astype(np.float32))

    with open_world(scene, Assets(), "auto") as world:
        glimpses = [seen(world, n) for n in range(round(math.tau / STEP_RAD))]
    mount = Mount(z_m=camera.z_m, pitch_rad=ONROBOT.tilt_rad)
    turns = seen_turns(glimpses, intrinsics, mount)
    assert len(turns) >= 0.8 * (len(glimpses) - 1)
    total = sum(turn.turn_rad for turn in turns)
    assert total / (STEP_RAD * len(turns)) == pytest.approx(1.0, abs=0.02)
