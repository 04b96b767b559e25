"""The mount by the floor that is seen, in a room whose planes are known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from runtime.core.geometry import optical_to_base
from runtime.core.mapping.floor_plane import mount_by_floor
from runtime.core.types import F32, Intrinsics, Mount

CAMERA = Intrinsics(194.0, 194.0, 160.0, 120.0, 320, 240)
NOMINAL = Mount(z_m=0.88)


def room(mount: Mount, ahead_m: float = 3.5, table: bool = False, noise: float = 0.0) -> F32:
    """Depth of a floor, three walls and perhaps a table, (H, W) m, seen from the mount."""
    v, u = np.indices((CAMERA.height, CAMERA.width)) + 0.5
    optical = np.stack(
        [(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)], -1
    )
    rays = optical @ optical_to_base(mount).T
    with np.errstate(divide="ignore", invalid="ignore"):
        walls = [-mount.z_m / rays[..., 2], ahead_m / rays[..., 0]]
        walls += [1.5 / rays[..., 1], -1.5 / rays[..., 1]]
        depth = np.min([np.where(d > 0, d, np.inf) for d in walls], axis=0)
        if table:
            top = (0.5 - mount.z_m) / rays[..., 2]
            x, y = top * rays[..., 0], top * rays[..., 1]
            on = (top > 0) & (x > 1.0) & (x < 2.4) & (np.abs(y) < 0.6)
            depth = np.where(on & (top < depth), top, depth)
    error = np.random.default_rng(0).standard_normal(depth.shape)
    return (depth + noise * depth**2 * error).astype(np.float32)


@pytest.mark.parametrize("noise", [0.0, 0.004])
@pytest.mark.parametrize(
    "true",
    [
        Mount(z_m=0.93, pitch_rad=0.09),
        Mount(z_m=0.8, pitch_rad=-0.06, roll_rad=0.1),
        Mount(z_m=0.88, pitch_rad=0.15, roll_rad=-0.05),
    ],
)
def test_height_and_tilt_are_found(true: Mount, noise: float) -> None:
    found = mount_by_floor(room(true, table=True, noise=noise), CAMERA, NOMINAL, NOMINAL)
    assert found.z_m == pytest.approx(true.z_m, abs=0.01)
    assert found.pitch_rad == pytest.approx(true.pitch_rad, abs=math.radians(0.3))
    assert found.roll_rad == pytest.approx(true.roll_rad, abs=math.radians(0.3))


def test_what_is_configured_besides_is_kept() -> None:
    nominal = Mount(0.1, -0.05, 0.88, math.pi / 2, 0.0, 0.3)  # on its side, looking left
    true = replace(nominal, z_m=0.92, pitch_rad=0.1)
    found = mount_by_floor(room(true), CAMERA, nominal, nominal)
    assert (found.x_m, found.y_m, found.yaw_rad) == (0.1, -0.05, 0.3)
    assert found.roll_rad == pytest.approx(math.pi / 2, abs=math.radians(0.3))
    assert found.z_m == pytest.approx(0.92, abs=0.01)


@pytest.mark.parametrize(
    "depth",
    [
        np.zeros((240, 320), np.float32),
        room(NOMINAL, ahead_m=0.8),  # a wall, and no floor before it
        room(Mount(z_m=0.88, pitch_rad=0.4)),  # far from what is configured
        room(Mount(z_m=0.55)),
    ],
    ids=["nothing", "wall", "tilt", "height"],
)
def test_without_a_floor_the_last_mount_holds(depth: F32) -> None:
    last = Mount(z_m=0.9, pitch_rad=0.05)
    assert mount_by_floor(depth, CAMERA, NOMINAL, last) is last


def test_a_mount_that_rests_does_not_tremble() -> None:
    last = NOMINAL
    found = set()
    for noise in (0.001, 0.002, 0.003, 0.004):
        last = mount_by_floor(room(Mount(z_m=0.9, pitch_rad=0.03), noise=noise), CAMERA, NOMINAL,
                              last)  # fmt: skip
        found.add(last)
    assert len(found) == 1
