"""Depth images of boxes on a floor, to the pixel, for a level camera at the origin."""

from dataclasses import dataclass

import numpy as np

from runtime.core.geometry import rays
from runtime.core.types import F32, Intrinsics, Mount, Observation, Pose

CAMERA = Intrinsics(388.0, 388.0, 320.0, 240.0, 640, 480)
MOUNT = Mount(z_m=0.88)
READS_M = (0.3, 5.0)
HERE = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Box:
    """Its middle and sides on the plan, from and to which height, m. Glass tells no depth."""

    x_m: float
    y_m: float
    sides_m: tuple[float, float]
    low_m: float
    high_m: float
    glass: bool = False


def wall(x_m: float, glass: bool = False) -> Box:
    """Across the view, from its near side on."""
    return Box(x_m + 0.05, 0.0, (0.1, 9.0), 0.0, 2.5, glass)


def depth_of(*boxes: Box) -> F32:
    """(480, 640) m along the optical axis, 0 where nothing is read."""
    table = rays(CAMERA, MOUNT, 1)
    shape = len(table.up), table.left.shape[1]
    ahead, left, up = (np.broadcast_to(a, shape) for a in (table.forward, table.left, table.up))
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(up < 0, -MOUNT.z_m / up, np.inf)
        for box in boxes:
            near, far = np.full(shape, -np.inf), np.full(shape, np.inf)
            for at, half, way, eye in (
                (box.x_m, box.sides_m[0] / 2, ahead, 0.0),
                (box.y_m, box.sides_m[1] / 2, left, 0.0),
                ((box.low_m + box.high_m) / 2, (box.high_m - box.low_m) / 2, up, MOUNT.z_m),
            ):
                ends = (at - half - eye) / way, (at + half - eye) / way
                near, far = np.maximum(near, np.minimum(*ends)), np.minimum(far, np.maximum(*ends))
            met = (near <= far) & (near > 0) & (near < np.abs(depth))
            depth = np.where(met, -near if box.glass else near, depth)
    read = (depth >= READS_M[0]) & (depth <= READS_M[1])
    return np.where(read, depth, 0).astype(np.float32)


def seen(depth_m: F32, seed: int | None = None) -> Observation:
    """As a camera tells it; with a seed, with the noise of a usual one."""
    if seed is not None:
        noise = np.random.default_rng(seed).standard_normal(depth_m.shape).astype(np.float32)
        depth_m = np.where(depth_m > 0, depth_m + 0.003 * depth_m**2 * noise, 0).astype(np.float32)
    return Observation(0, np.zeros((480, 640, 3), np.uint8), depth_m, HERE, CAMERA)
