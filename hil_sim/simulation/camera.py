"""What looks at a scene, what lights it, and what is seen."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class CameraModel:
    """A pinhole camera with square pixels and its principal point in the middle."""

    width: int = 640
    height: int = 480
    hfov_rad: float = math.radians(79.0)
    z_m: float = 0.88

    @property
    def focal_px(self) -> float:
        """Focal length in pixels."""
        return self.width / 2 / math.tan(self.hfov_rad / 2)


HM3D_CAMERA = CameraModel()


@dataclass(frozen=True)
class Light:
    """One distant light, toward which `direction` points, and what comes from everywhere."""

    direction: tuple[float, float, float] = (0.5, -0.7, 1.2)
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    ambient: float = 0.5
    diffuse: float = 0.5


@dataclass(frozen=True)
class Appearance:
    """How a scene is lit; colours are the scene's own."""

    light: Light = Light()


@dataclass(frozen=True)
class Frame:
    """rgb (H, W, 3) uint8; depth_m (H, W) float32 along the optical axis, 0 where nothing is;
    segmentation (H, W) int32, index into the scene's objects or -1."""

    rgb: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    segmentation: NDArray[np.int32]
