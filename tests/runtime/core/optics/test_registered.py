"""Depth of one camera in the pixels of another, in a room whose planes are known."""

import math

import cv2
import numpy as np
import pytest
from bent_lens import directions

from runtime.core.geometry import optical_to_base
from runtime.core.optics.lens import Lens
from runtime.core.optics.registered import (
    Extrinsics,
    mount_beside,
    registered,
    resized,
    resized_intrinsics,
)
from runtime.core.types import F32, Intrinsics, Mount

DEPTH = Intrinsics(210.0, 210.0, 160.0, 120.0, 320, 240)
COLOR = Intrinsics(300.0, 302.0, 214.0, 118.0, 424, 240)
BESIDE = np.array(
    [[1.0, 0.0, 0.0, -0.06], [0.0, math.cos(0.02), -math.sin(0.02), 0.004],
     [0.0, math.sin(0.02), math.cos(0.02), 0.01], [0.0, 0.0, 0.0, 1.0]]
)  # fmt: skip
BOX_M, WALL_M, SIDE_M = 1.2, 3.0, 0.25


def room(camera: Intrinsics, at: np.ndarray, model: str = "", d: tuple[float, ...] = ()) -> F32:
    """(H, W) m, of a wall and a square box before it that are planes of the first camera's frame,
    seen from a camera at `at` (4, 4), from its frame to the first's."""
    x, y = directions(camera, model, d)
    rays = np.stack([x, y, np.ones(x.shape)], -1) @ at[:3, :3].T
    depth = np.full(x.shape, np.inf)
    for plane_m, half_m in ((WALL_M, np.inf), (BOX_M, SIDE_M)):
        along = (plane_m - at[2, 3]) / rays[..., 2]
        hit = at[:3, 3] + along[..., None] * rays
        on = (np.abs(hit[..., :2]) < half_m).all(axis=-1)
        depth = np.where(on & (along < depth), along, depth)
    return depth.astype(np.float32)


def hidden(depth: F32) -> np.ndarray:
    """What the box hides from the first camera, of the second camera's image, or nearly."""
    x, y = directions(COLOR)
    points = np.stack([x, y, np.ones(x.shape)], -1) * depth[..., None]
    there = (points - BESIDE[:3, 3]) @ BESIDE[:3, :3]  # in the first camera's frame
    at_box = there[..., :2] * (BOX_M / there[..., 2:])
    return (there[..., 2] > BOX_M + 0.1) & (np.abs(at_box) < SIDE_M + 0.02).all(axis=-1)


def edges(depth: F32) -> np.ndarray:
    """Within three pixels of where the nearest and the farthest around differ."""
    kernel = np.ones((7, 7), np.uint8)
    return cv2.dilate(depth, kernel) - cv2.erode(depth, kernel) > 0.5


@pytest.mark.parametrize(
    ("model", "d"),
    [("", ()), ("plumb_bob", (-0.2, 0.05, 0.001, 0.0, 0.0))],
    ids=["pinhole", "bent"],
)
def test_depth_is_what_the_other_camera_would_have_measured(model: str, d: tuple[float, ...]):
    taken = room(DEPTH, np.eye(4), model, d)
    got = registered(taken, Lens(DEPTH, d), Extrinsics.of(BESIDE), COLOR)
    wanted = room(COLOR, np.linalg.inv(BESIDE))
    x, y = directions(COLOR)
    inside = (np.abs(x) < 0.55) & (np.abs(y) < 0.35)  # what both see
    clear = inside & ~edges(wanted) & ~hidden(wanted)
    holes = (got == 0) & clear
    assert holes.sum() <= 0.001 * clear.sum()
    told = clear & (got > 0)
    np.testing.assert_allclose(got[told], wanted[told], rtol=0.004)


def test_the_nearer_hides_what_is_behind():
    taken = room(DEPTH, np.eye(4))
    got = registered(taken, Lens(DEPTH), Extrinsics.of(BESIDE), COLOR)
    box = room(COLOR, np.linalg.inv(BESIDE)) < 2
    inner = box & ~edges(room(COLOR, np.linalg.inv(BESIDE)))
    assert inner.sum() > 1000
    assert (got[inner] < 2).all()


def test_what_the_first_camera_could_not_see_stays_unknown():
    got = registered(room(DEPTH, np.eye(4)), Lens(DEPTH), Extrinsics.of(BESIDE), COLOR)
    beside_the_box = got[100:140, :]
    assert (beside_the_box == 0).any(axis=1).all()


def test_in_the_same_place_with_the_same_view_nothing_changes():
    taken = room(DEPTH, np.eye(4))
    taken[5:9, 7:30] = 0
    taken[20, 20] = np.inf
    got = registered(taken, Lens(DEPTH), Extrinsics.of(np.eye(4)), DEPTH)
    same = np.isfinite(taken) & ~edges(np.where(np.isfinite(taken), taken, 0))
    np.testing.assert_allclose(got[same], taken[same], rtol=1e-6)
    assert np.isfinite(got).all()


def test_the_mount_beside_another_is_where_its_points_are():
    mount = Mount(0.1, -0.05, 0.9, 0.2, 0.3, -0.4)
    beside = mount_beside(mount, Extrinsics.of(BESIDE))
    point = np.array([0.3, -0.2, 2.0])  # in the depth camera's frame
    wanted = optical_to_base(mount) @ (BESIDE[:3, :3] @ point + BESIDE[:3, 3]) + (0.1, -0.05, 0.9)
    got = optical_to_base(beside) @ point + (beside.x_m, beside.y_m, beside.z_m)
    np.testing.assert_allclose(got, wanted, atol=1e-3)


def test_another_size_of_the_same_view_is_scaled():
    small = resized_intrinsics(COLOR, 212, 120)
    assert small == Intrinsics(150.0, 151.0, 107.0, 59.0, 212, 120)
    depth = room(small, np.eye(4))
    large = resized(depth, 424, 240)
    assert np.isin(large, depth).all()
    clear = ~edges(large)
    np.testing.assert_allclose(large[clear], room(COLOR, np.eye(4))[clear], rtol=1e-3)
