"""Frames and projections are inverse to each other and follow REP 103 / 105."""

import math
from dataclasses import replace

import numpy as np
import pytest
from apartment import MOUNT
from hypothesis import given
from hypothesis import strategies as st
from numpy_things import base_to_map

from runtime.core.geometry import (
    GridFrame,
    Standoff,
    map_to_optical,
    mount_of,
    optical_to_base,
    placed,
    project,
    rays,
    seen_from,
    standoff,
    wrap_angle,
)
from runtime.core.types import Intrinsics, Mount, Pose

CAMERA = Intrinsics(97.0, 95.0, 80.0, 60.0, 160, 120)
ANGLE = st.floats(-20.0, 20.0)
METRES = st.floats(-10.0, 10.0)
POSES = st.builds(Pose, METRES, METRES, ANGLE)
MOUNTS = st.builds(
    Mount,
    x_m=st.floats(-0.3, 0.3),
    y_m=st.floats(-0.3, 0.3),
    z_m=st.floats(0.1, 1.5),
    roll_rad=st.floats(-0.5, 0.5),
    pitch_rad=st.floats(-0.5, 0.5),
    yaw_rad=st.floats(-3.0, 3.0),
)


def backproject(depth_m: np.ndarray) -> np.ndarray:
    """(H, W) m -> (N, 3) m of the pixels with depth, in the camera optical frame."""
    v, u = np.nonzero(depth_m)
    z = depth_m[v, u].astype(np.float64)
    x = (u + 0.5 - CAMERA.cx) / CAMERA.fx * z
    y = (v + 0.5 - CAMERA.cy) / CAMERA.fy * z
    return np.stack([x, y, z], axis=1)


@given(ANGLE)
def test_wrapping_keeps_the_direction(angle: float):
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_projecting_undoes_backprojecting(seed: int):
    depth = np.random.default_rng(seed).uniform(0.3, 6.0, (120, 160)).astype(np.float32)
    pixels = project(backproject(depth), CAMERA)
    v, u = np.indices(depth.shape)
    assert np.allclose(pixels, np.stack([u.ravel(), v.ravel()], axis=1), atol=1e-6)


def test_a_level_camera_looks_forward_with_left_to_the_left():
    rotation = optical_to_base(Mount())
    assert np.allclose(rotation @ [0, 0, 1], [1, 0, 0])
    assert np.allclose(rotation @ [1, 0, 0], [0, -1, 0])
    assert np.allclose(rotation @ [0, 1, 0], [0, 0, -1])


def test_positive_pitch_looks_down():
    assert (optical_to_base(Mount(pitch_rad=0.4)) @ [0, 0, 1])[2] < 0


@given(MOUNTS)
def test_a_mount_is_read_from_its_rotation(mount: Mount) -> None:
    read = mount_of(optical_to_base(mount), np.array([mount.x_m, mount.y_m, mount.z_m]), 9)
    assert vars(read) == pytest.approx(vars(mount), abs=1e-8)


@given(POSES, MOUNTS)
def test_map_to_optical_undoes_the_way_out(pose: Pose, mount: Mount):
    optical = np.array([[0.3, -0.2, 2.0], [0.0, 0.0, 1.0]])
    offset = np.array([mount.x_m, mount.y_m, mount.z_m])
    world = base_to_map(optical @ optical_to_base(mount).T + offset, pose)
    assert np.allclose(map_to_optical(world, pose, mount), optical, atol=1e-9)


@given(MOUNTS)
def test_the_ray_table_is_the_backprojection(mount: Mount):
    table = rays(CAMERA, mount, 4)
    depth = np.zeros((120, 160), np.float32)
    depth[2::4, 2::4] = 2.0
    expected = backproject(depth) @ optical_to_base(mount).T
    found = np.stack([a.ravel() for a in (table.forward, table.left, table.up)], axis=1) * 2.0
    assert np.allclose(found, expected, atol=1e-5)


def test_a_mount_that_only_rises_keeps_its_ray_table():
    table = rays(CAMERA, MOUNT, 4)
    assert rays(CAMERA, replace(MOUNT, x_m=0.3, z_m=2.0), 4) is table
    assert rays(CAMERA, replace(MOUNT, pitch_rad=MOUNT.pitch_rad + 0.01), 4) is not table


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_a_cells_centre_is_in_the_cell(x: float, y: float):
    frame = GridFrame(-4.0, -4.0, 0.05, 160, 160)
    row, col = frame.cell(x, y)
    assert tuple(frame.cells(np.array([x, y]))) == (row, col)
    cx, cy = frame.centres(np.array([row, col], np.int32))
    assert abs(cx - x) <= 0.025 + 1e-9
    assert abs(cy - y) <= 0.025 + 1e-9


@pytest.mark.parametrize(("cell", "inside"), [((0, 0), True), ((-1, 0), False), ((0, 160), False)])
def test_containment(cell: tuple[int, int], inside: bool):
    assert GridFrame(0.0, 0.0, 0.05, 160, 160).contains(*cell) is inside


@given(st.floats(-3.9, 3.9), st.floats(-3.9, 3.9), st.integers(0, 99), st.integers(0, 99))
def test_a_part_of_a_grid_has_the_numbers_of_the_whole(x: float, y: float, row: int, col: int):
    whole = GridFrame(-4.0, -4.1, 0.05, 160, 170)
    part = replace(whole, rows=60, cols=50, first_row=row, first_col=col)
    first = np.array([row, col])
    cells = whole.cells(np.array([x, y]))
    assert (part.cells(np.array([x, y])) + first == cells).all()
    assert (part.cell(x, y) + first == cells).all()
    assert (part.centres(cells - first.astype(np.int32)) == whole.centres(cells)).all()


def test_how_far_away_a_thing_is_in_the_image():
    lens = Intrinsics(fx=240.0, fy=240.0, cx=320.0, cy=240.0, width=640, height=480)
    ahead = replace(MOUNT, x_m=0.1, z_m=0.9)  # its lowest ray falls by 45 degrees
    assert standoff(lens, ahead, 0.0, 0.4) == Standoff(nearest_m=pytest.approx(0.6))
    assert standoff(lens, ahead, 0.0, 0.9) == standoff(lens, ahead, 0.5, 1.5) == Standoff()
    assert standoff(lens, replace(ahead, pitch_rad=0.3), 0.0, 0.4).nearest_m < 0.5
    assert standoff(lens, replace(ahead, pitch_rad=-1.0), 0.0, 0.4).nearest_m == math.inf
    assert standoff(lens, ahead, 1.3, 1.5) == Standoff(middle_m=pytest.approx(0.6))
    assert standoff(lens, replace(ahead, pitch_rad=-0.3), 1.3, 1.5).middle_m < 0.5
    assert standoff(lens, replace(ahead, pitch_rad=1.0), 1.3, 1.5).middle_m == math.inf


@given(POSES, POSES)
def test_a_pose_in_a_frame_is_told_outside_of_it_and_back(frame: Pose, pose: Pose):
    back = seen_from(frame, placed(frame, pose))
    assert math.isclose(back.x_m, pose.x_m, abs_tol=1e-6)
    assert math.isclose(back.y_m, pose.y_m, abs_tol=1e-6)
    assert abs(wrap_angle(back.yaw_rad - pose.yaw_rad)) < 1e-9
