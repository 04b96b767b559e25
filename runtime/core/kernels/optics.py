"""The compiled part of what is done to images before anything is seen in them."""

from typing import NamedTuple

from runtime.core.kernels import _compiled
from runtime.core.types import F32


class Camera(NamedTuple):
    """A pinhole that depth is put into, px; and how many of its pixels one of the image that the
    depth is of is wide and high, for something equally far from both."""

    fx: float
    fy: float
    cx: float
    cy: float
    wide: float
    high: float


def register_depth(
    seen: F32,
    depth_m: F32,
    across: F32,
    down: F32,
    placed: tuple[tuple[float, float, float, float], ...],
    camera: Camera,
) -> None:
    """Writes to `seen` (h, w) m the nearest of what falls on each pixel of a depth image (H, W),
    whose rays are `across` and `down` (H, W), m per m of depth; 0 where nothing does. `placed`: the
    three rows of the (3, 4) from its frame to the camera's, m. ValueError for shapes that do not
    fit."""
    numbers = [value for row in placed for value in row]
    _compiled.register_depth(seen, depth_m, across, down, *numbers, *camera)
