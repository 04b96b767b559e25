"""A camera that is mounted otherwise than it is configured: known by the floor of a first look."""

import math
from dataclasses import replace

import numpy as np
import pytest

from runtime.core.geometry import optical_rays, optical_to_base
from runtime.core.mapping.floor_plane import CARRIED
from runtime.core.mapping.mount_check import MountCheck, MountVerdict
from runtime.core.types import F32, Intrinsics, Mount

CAMERA = Intrinsics(194.0, 194.0, 160.0, 120.0, 320, 240)
MOUNT = Mount(z_m=0.88)


def room(mount: Mount, yaw_rad: float, bed: bool = False, noise: float = 0.004) -> F32:
    """Depth in a room of 7 x 6 m, seen from near its middle; with a bed in one half of it."""
    rays = optical_rays(CAMERA, 1) @ optical_to_base(mount).T
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    x, y = c * rays[..., 0] - s * rays[..., 1], s * rays[..., 0] + c * rays[..., 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        planes = [-mount.z_m / rays[..., 2], (2.4 - mount.z_m) / rays[..., 2]]
        planes += [3.7 / x, -3.3 / x, 3.1 / y, -2.9 / y]
        depth = np.min([np.where(d > 0, d, np.inf) for d in planes], axis=0)
        top = (0.5 - mount.z_m) / rays[..., 2]
        on = bed & (top > 0) & (top * x > 0.5) & (top < depth)
        depth = np.where(on, top, depth)
    error = np.random.default_rng(round(100 * yaw_rad)).standard_normal(depth.shape)
    return (depth + noise * depth**2 * error).astype(np.float32)


def looked(
    true: Mount, configured: Mount = MOUNT, turn_deg: int = 360, **scene
) -> MountVerdict | None:
    check, verdict = MountCheck(), None
    for yaw_deg in range(0, turn_deg, 30):
        yaw_rad = math.radians(yaw_deg)
        check.look(room(true, yaw_rad, **scene), CAMERA, configured, yaw_rad)
        verdict = check.verdict(configured)
    return verdict


def test_a_mount_that_is_as_configured_fits():
    verdict = looked(MOUNT)
    assert verdict is not None
    assert verdict.fits
    assert verdict.maps


@pytest.mark.parametrize(
    "true",
    [
        Mount(z_m=0.80),
        Mount(z_m=0.88, pitch_rad=math.radians(2)),
        Mount(z_m=0.95, pitch_rad=math.radians(-3), roll_rad=math.radians(4)),
        Mount(z_m=0.45, pitch_rad=math.radians(20)),
        Mount(z_m=1.1),
    ],
)
def test_what_would_fit_is_found_and_the_robot_held(true: Mount):
    verdict = looked(true)
    assert verdict is not None
    assert not verdict.maps
    assert verdict.found.z_m == pytest.approx(true.z_m, abs=0.01)
    assert verdict.found.pitch_rad == pytest.approx(true.pitch_rad, abs=math.radians(0.3))
    assert verdict.found.roll_rad == pytest.approx(true.roll_rad, abs=math.radians(0.3))


def test_a_little_off_is_told_and_gone_on_with():
    verdict = looked(Mount(z_m=0.93))
    assert verdict is not None
    assert verdict.maps
    assert not verdict.fits


def test_one_direction_is_not_enough_and_a_bed_in_it_is_no_floor():
    assert looked(MOUNT, turn_deg=30, bed=True) is None
    verdict = looked(MOUNT, bed=True)
    assert verdict is not None
    assert verdict.fits


def test_nothing_that_is_a_floor_is_no_verdict():
    check = MountCheck()
    for n in range(8):
        check.look(np.zeros((240, 320), np.float32), CAMERA, MOUNT, n * math.pi / 4)
    assert check.verdict(MOUNT) is None


def test_it_is_told_in_a_line_with_the_numbers_and_the_keys():
    found = replace(MOUNT, z_m=0.8, pitch_rad=0.035)
    told = MountVerdict(found, False, False).in_words(MOUNT)
    assert told == (
        "camera: the floor appears 0.08 m high, tilted by +2.0 and rolled by +0.0 degrees; what "
        "fits: camera.z_m = 0.800, camera.pitch_rad = 0.0350, camera.roll_rad = 0.0000 "
        "(rfnav calibrate)"
    )


def test_a_camera_on_its_side_is_told_its_own_roll():
    configured = replace(MOUNT, roll_rad=math.pi / 2)
    told = MountVerdict(replace(MOUNT, roll_rad=0.05), False, False).in_words(configured)
    assert f"camera.roll_rad = {math.pi / 2 + 0.05:.4f}" in told


@pytest.mark.parametrize(("roll_deg", "maps"), [(8, True), (20, False)])
def test_a_mount_that_is_followed_may_not_roll_by_more_than_is_followed(roll_deg: int, maps: bool):
    check, true = MountCheck(CARRIED), Mount(z_m=0.88, roll_rad=math.radians(roll_deg))
    for yaw_deg in range(0, 360, 30):
        yaw = math.radians(yaw_deg)
        check.look(room(true, yaw), CAMERA, MOUNT, yaw)
    verdict = check.verdict(MOUNT)
    assert verdict is not None
    assert verdict.maps == maps
