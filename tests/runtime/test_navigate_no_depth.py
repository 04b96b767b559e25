"""Depth that is not there: nothing is placed, nothing breaks, and the search goes on."""

from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment

from runtime import navigate
from runtime.core.types import Detections, Pose
from runtime.core.world import World

CFG = navigate.NavigateConfig()
NAMES, ROOMS = ("toilet", "sofa"), ("bathroom",)


@pytest.mark.parametrize("depth", [np.nan, np.inf, 0.0, -1.0])
def test_frames_without_depth_place_nothing(depth: float) -> None:
    home = Apartment.of(TWO_ROOMS, Pose(1.0, 3.2, 0.0))
    obs = home.observe()
    blind = replace(obs, depth_m=np.full_like(obs.depth_m, depth))
    toilet = Detections(
        np.array([[40, 30, 90, 80]], np.float32),
        np.array([0.9], np.float32),
        np.array([0], np.int32),
        np.ones((1, 8), np.float32),
        np.array([1.0], np.float32),
    )
    world = World.begin("toilet", NAMES, ROOMS, obs.pose, 0.18)
    for k in range(3):
        frame = replace(blind, stamp_ns=obs.stamp_ns + k)
        navigate.perceive(world, frame, toilet, MOUNT, CFG)
        navigate.steer(world, navigate.act(world, CFG), CFG)
    assert not world.semantic.instances
    navigate.perceive(world, replace(obs, stamp_ns=obs.stamp_ns + 9), toilet, MOUNT, CFG)
    assert world.semantic.instances
