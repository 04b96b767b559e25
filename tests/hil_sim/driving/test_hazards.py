"""How much of what is put in the way an image shows."""

import math

import numpy as np
import pytest

from hil_sim.driving.hazards import pixels_of
from hil_sim.simulation.body import Body
from hil_sim.simulation.protocol import ONROBOT
from runtime.core.geometry import rays
from runtime.core.types import Mount, Pose


def depth_of(body, pose):
    """(H, W) m: each pixel's ray ends on an upright cylinder, or nowhere."""
    table = rays(ONROBOT.intrinsics, Mount(z_m=ONROBOT.camera_z_m), 1)
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    dx, dy = c * table.forward - s * table.left, s * table.forward + c * table.left
    x, y = pose.x_m - body.x_m, pose.y_m - body.y_m
    a, b = dx * dx + dy * dy, 2 * (dx * x + dy * y)
    root = b * b - 4 * a * (x * x + y * y - (body.size_m[0] / 2) ** 2)
    depth = np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / (2 * a), 0.0)
    high = ONROBOT.camera_z_m + depth * table.up
    return np.where((depth > 0) & (high > 0) & (high < body.size_m[2]), depth, 0).astype(np.float32)


@pytest.mark.parametrize("pose", [Pose(1.0, 2.0, 0.0), Pose(-1.0, 0.5, 2.0)])
def test_pixels_of_a_body_are_those_within_the_sensors_range(pose):
    at = pose.xy + 1.2 * np.array([math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)])
    leg = Body("leg", float(at[0]), float(at[1]), 0.3, (0.06, 0.06, 0.9))
    depth_m = depth_of(leg, pose)
    shown = int((depth_m > 0).sum())
    assert shown > 2000
    assert abs(pixels_of(leg, depth_m, pose, ONROBOT) - shown) < 0.05 * shown
    beside = Body("leg", leg.x_m + 0.5, leg.y_m, 0.0, leg.size_m)
    assert pixels_of(beside, depth_m, pose, ONROBOT) == 0
    near = Body("leg", *(pose.xy + 0.25 * (at - pose.xy) / 1.2), 0.0, leg.size_m)
    assert pixels_of(near, depth_of(near, pose), pose, ONROBOT) == 0  # nearer than depth is told
    box = Body("box", leg.x_m, leg.y_m, pose.yaw_rad + math.pi / 2, (0.5, 0.04, 0.9))
    assert pixels_of(box, depth_m, pose, ONROBOT) > 0.9 * shown
