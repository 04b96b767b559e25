"""A camera that is mounted on its side or upside down: its images set upright, by quarter turns,
and what its intrinsics and its mount are then."""

import math
from dataclasses import replace
from typing import Final, TypeVar

import cv2
import numpy as np

from runtime.core.geometry import wrap_angle
from runtime.core.types import F32, F64, U8, Intrinsics, Mount

Image = TypeVar("Image", F32, U8)
M = TypeVar("M", bound=Mount)
QUARTER_RAD: Final = math.pi / 2
_ROTATED: Final = {
    1: cv2.ROTATE_90_CLOCKWISE,
    2: cv2.ROTATE_180,
    3: cv2.ROTATE_90_COUNTERCLOCKWISE,
}


def quarters_of(roll_rad: float) -> int:
    """By how many quarter turns, 0 to 3, a camera of that roll leans to the right: its images are
    upright when they are turned as many to the right, which is clockwise."""
    return round(roll_rad / QUARTER_RAD) % 4


def upright_mount(mount: M) -> M:
    """The mount of the same camera whose images are set upright: its roll is what is left of it,
    at most 45 degrees. One that is upright is given back as it is."""
    quarters = quarters_of(mount.roll_rad)
    if not quarters:
        return mount
    return replace(mount, roll_rad=wrap_angle(mount.roll_rad - quarters * QUARTER_RAD))


def upright_intrinsics(intrinsics: Intrinsics, quarters: int) -> Intrinsics:
    """Of the image that is turned clockwise so often."""
    i = intrinsics
    for _ in range(quarters):
        i = Intrinsics(i.fy, i.fx, i.height - i.cy, i.cx, i.height, i.width)
    return i


def upright_image(image: Image, quarters: int) -> Image:
    """(H, W, ...) turned clockwise so often; the image itself where that is never."""
    if not quarters:
        return image
    turned: Image = np.asarray(cv2.rotate(image, _ROTATED[quarters]), image.dtype)
    return turned


def upright_axes(quarters: int) -> F64:
    """(3, 3) from the optical frame of the camera to that of its upright images."""
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters]
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
