"""A search by a camera that is mounted otherwise than configured: what is said, and what is not
mapped."""

import math

import numpy as np
import pytest

from runtime.core.geometry import optical_rays, optical_to_base
from runtime.core.types import Intrinsics, Mount, Pose
from runtime.errors import SensorError
from runtime.robot.floor_look import FloorLook
from runtime.robot.optics import Pair
from runtime.robot.transforms import CameraConfig

CAMERA = Intrinsics(97.0, 97.0, 80.0, 60.0, 160, 120)
RGB = np.zeros((120, 160, 3), np.uint8)


def pair(true: Mount, told: Mount | None = None) -> Pair:
    """An empty floor that ends at 4 m."""
    up = (optical_rays(CAMERA, 1) @ optical_to_base(true).T)[..., 2]
    with np.errstate(divide="ignore"):
        depth = np.where(up < 0, np.minimum(4.0, -true.z_m / up), 4.0).astype(np.float32)
    return Pair(RGB, depth, CAMERA, told, False)


def turned(look: FloorLook, true: Mount, told: Mount | None = None, frames: int = 24) -> list[str]:
    """What is said against each image of a whole turn."""
    angles = [math.tau * n / frames for n in range(frames)]
    return [said(look, pair(true, told), yaw) for yaw in angles]


def said(look: FloorLook, seen: Pair, yaw_rad: float = 0.0) -> str:
    """Why it is refused; "" where it is not."""
    try:
        look.check(seen, Pose(0.0, 0.0, yaw_rad))
    except SensorError as error:
        return str(error)
    return ""


def test_a_mount_that_fits_is_said_nothing_of():
    lines: list[str] = []
    assert turned(FloorLook(CameraConfig(), lines.append), Mount()) == [""] * 24
    assert lines == []


def test_one_that_is_off_by_little_is_said_once_and_mapped():
    lines: list[str] = []
    assert turned(FloorLook(CameraConfig(), lines.append), Mount(z_m=0.93)) == [""] * 24
    assert len(lines) == 1
    assert "camera.z_m = 0.93" in lines[0]


def test_one_that_is_off_by_more_is_refused_with_the_numbers_from_a_third_direction_on():
    look = FloorLook(CameraConfig(), pytest.fail)
    lines = turned(look, Mount(z_m=0.80, pitch_rad=0.03))
    assert lines[:6] == [""] * 6
    assert all(lines[6:])
    assert lines[-1].startswith("camera: the floor appears 0.08 m high, tilted by +1.7")
    assert "camera.z_m = 0.80" in lines[-1]


def test_what_is_mended_is_looked_at_again():
    look = FloorLook(CameraConfig(), pytest.fail)
    assert turned(look, Mount(z_m=0.80))[-1]
    assert said(look, pair(Mount())) == ""
    assert turned(look, Mount()) == [""] * 24


def test_by_tf_it_is_tf_that_is_wrong():
    look = FloorLook(CameraConfig(mount="tf"), pytest.fail)
    line = turned(look, Mount(z_m=1.0), Mount(z_m=0.88))[-1]
    assert line.startswith("tf: the floor appears 0.12 m low")
    assert "z 1.00" in line


def test_a_camera_that_is_carried_may_be_off_by_more_and_not_by_anything():
    carried = CameraConfig(mount="floor")
    assert turned(FloorLook(carried, pytest.fail), Mount(z_m=0.95, pitch_rad=0.1)) == [""] * 24
    assert turned(FloorLook(carried, pytest.fail), Mount(z_m=0.6))[-1]
