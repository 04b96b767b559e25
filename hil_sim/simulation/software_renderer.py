"""A view drawn by PyBullet's own renderer, where there is no EGL."""

import math

import numpy as np
import pybullet
from numpy.typing import NDArray

from hil_sim.simulation.camera import CameraModel, Light
from hil_sim.simulation.projection import FAR_M, NEAR_M


def draw_software(
    client: int,
    eye: tuple[float, float, float],
    yaw_rad: float,
    pitch_rad: float,
    camera: CameraModel,
    light: Light,
) -> tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.int32]]:
    """What a level camera of a PyBullet client sees (positive pitch looks down): (H, W, 3) RGB,
    (H, W) m along the optical axis (0: nothing), (H, W) body ids (-1: none)."""
    view, lens = _matrices(eye, yaw_rad, pitch_rad, camera)
    _, _, rgba, buffer, bodies = pybullet.getCameraImage(
        camera.width,
        camera.height,
        view,
        lens,
        shadow=0,
        lightDirection=light.direction,
        lightColor=light.colour,
        lightAmbientCoeff=light.ambient,
        lightDiffuseCoeff=light.diffuse,
        lightSpecularCoeff=0.03,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=client,
    )
    shape = camera.height, camera.width
    z = np.reshape(np.asarray(buffer, np.float32), shape)
    metres = FAR_M * NEAR_M / (FAR_M - (FAR_M - NEAR_M) * z)
    metres[z >= 1.0] = 0.0
    ids = np.reshape(np.asarray(bodies, np.int32), shape)
    ids = np.where(ids < 0, -1, ids & 0xFFFFFF)
    rgb = np.reshape(np.asarray(rgba, np.uint8), (*shape, 4))[..., :3]
    return np.ascontiguousarray(rgb), metres, ids


Matrix = tuple[float, ...]


def _matrices(
    eye: tuple[float, float, float], yaw_rad: float, pitch_rad: float, camera: CameraModel
) -> tuple[Matrix, Matrix]:
    c = math.cos(pitch_rad)
    ahead = (c * math.cos(yaw_rad), c * math.sin(yaw_rad), -math.sin(pitch_rad))
    view = pybullet.computeViewMatrix(
        eye, tuple(e + a for e, a in zip(eye, ahead, strict=True)), (0, 0, 1)
    )
    half_w = NEAR_M * math.tan(camera.hfov_rad / 2)
    half_h = half_w * camera.height / camera.width
    lens = pybullet.computeProjectionMatrix(-half_w, half_w, -half_h, half_h, NEAR_M, FAR_M)
    return view, lens
