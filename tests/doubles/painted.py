"""The flat-land apartment in paint: every surface has a pattern that stays where it is, so that
images of it can be compared."""

import math

import numpy as np
from apartment import INTRINSICS, MOUNT, Apartment

from runtime.core.geometry import rays
from runtime.core.types import Observation

TILE_M = 0.15


class Painted(Apartment):
    def observe(self) -> Observation:
        seen = super().observe()
        table, depth, pose = rays(INTRINSICS, MOUNT, 1), seen.depth_m, seen.pose
        c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        ahead, left = table.forward * depth, table.left * depth
        x, y = pose.x_m + c * ahead - s * left, pose.y_m + s * ahead + c * left
        tiles = [
            np.floor(v / TILE_M + 1e-4).astype(np.int64)
            for v in (x, y, MOUNT.z_m + table.up * depth)
        ]
        mixed = tiles[0] * 73856093 ^ tiles[1] * 19349663 ^ tiles[2] * 83492791
        grey = np.where(depth > 0, (mixed * 2654435761 >> 8) % 220 + 20, 128).astype(np.uint8)
        rgb = np.repeat(grey[:, :, None], 3, axis=2)
        return Observation(seen.stamp_ns, rgb, depth, pose, seen.intrinsics)
