"""Matrices (4, 4) between the scene, a camera's view and OpenGL's clip space."""

import math

import numpy as np

from runtime.core.types import F64

NEAR_M, FAR_M = 0.05, 25.0


def placed(position_m: tuple[float, float, float], yaw_rad: float) -> F64:
    """Model -> scene, turned about the vertical."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    x, y, z = position_m
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, z], [0, 0, 0, 1.0]])


def looking(eye: F64, ahead: F64) -> F64:
    """World -> view: x right, y up, z backward."""
    up = np.array([0.0, 0.0, 1.0]) if abs(ahead[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = [right, np.cross(right, ahead), -ahead]
    matrix[:3, 3] = -matrix[:3, :3] @ eye
    return matrix


def camera_matrices(
    eye: tuple[float, float, float],
    yaw_rad: float,
    pitch_rad: float,
    size: tuple[int, int],
    hfov_rad: float,
) -> tuple[F64, F64]:
    """World -> view, and world -> clip space."""
    c = math.cos(pitch_rad)
    ahead = np.array([c * math.cos(yaw_rad), c * math.sin(yaw_rad), -math.sin(pitch_rad)])
    view = looking(np.array(eye), ahead)
    focal = 1.0 / math.tan(hfov_rad / 2)
    lens = np.zeros((4, 4))
    lens[0, 0], lens[1, 1] = focal, focal * size[0] / size[1]
    lens[2, 2] = -(FAR_M + NEAR_M) / (FAR_M - NEAR_M)
    lens[2, 3] = -2 * FAR_M * NEAR_M / (FAR_M - NEAR_M)
    lens[3, 2] = -1.0
    return view, lens @ view


def orthographic(radius_m: float) -> F64:
    """View -> clip space of a light that shines on a sphere from its rim."""
    return np.array(
        [
            [1 / radius_m, 0, 0, 0],
            [0, 1 / radius_m, 0, 0],
            [0, 0, -1 / radius_m, -1.0],
            [0, 0, 0, 1],
        ]
    )


def side_planes(size: tuple[int, int], hfov_rad: float) -> F64:
    """(4, 3) inward normals of the view's sides, through the eye, in view space."""
    h = hfov_rad / 2
    v = math.atan(math.tan(h) * size[1] / size[0])
    return np.array(
        [
            [math.cos(h), 0, -math.sin(h)],
            [-math.cos(h), 0, -math.sin(h)],
            [0, math.cos(v), -math.sin(v)],
            [0, -math.cos(v), -math.sin(v)],
        ]
    )


def applied(matrix: F64, point: F64) -> F64:
    """A (3,) point, moved by the matrix."""
    moved: F64 = matrix[:3, :3] @ point + matrix[:3, 3]
    return moved


def column_major(matrix: F64) -> bytes:
    """As OpenGL takes a uniform."""
    return matrix.T.astype(np.float32).tobytes()
