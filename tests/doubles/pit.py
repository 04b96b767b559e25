"""A room with a hole in its floor, as a camera sees it: exact depth by ray casting. It knows
nothing of PyBullet."""

import math
from dataclasses import dataclass, replace

import numpy as np

from runtime.core.geometry import optical_rays, optical_to_base
from runtime.core.mapping.grid import NavigationMap, integrate
from runtime.core.types import Intrinsics, Mount, Observation, Pose

CAMERA = Intrinsics(97.0, 97.0, 80.0, 60.0, 160, 120)
RADIUS_M, HEIGHT_M, DEPTH_M = 0.18, 1.0, 5.0
LEVEL, TILTED = Mount(), Mount(pitch_rad=math.radians(30.0))


@dataclass(frozen=True)
class Pit:
    """A room from `low` to `high`, m, with a box of a hole in it: x from, to, y from, to, depth. Of
    an `island` all but the box is so much lower."""

    hole: tuple[float, float, float, float, float] | None
    low: tuple[float, float] = (-3.0, -3.0)
    high: tuple[float, float] = (3.0, 3.0)
    mount: Mount = LEVEL
    island: bool = False

    def depth(self, pose: Pose) -> np.ndarray:
        """(H, W) m, for a camera above the base's middle."""
        rays = optical_rays(CAMERA, 1) @ optical_to_base(self.mount).T
        c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        x, y = c * rays[..., 0] - s * rays[..., 1], s * rays[..., 0] + c * rays[..., 1]
        up, camera = rays[..., 2], np.array([pose.x_m, pose.y_m])
        with np.errstate(divide="ignore", invalid="ignore"):
            walls = _leaves(x, y, camera, self.low, self.high)
            down = np.where(up < 0, -self.mount.z_m / up, (2.5 - self.mount.z_m) / up)
            if self.hole is not None:
                x0, x1, y0, y1, deep = self.hole
                fx, fy = camera[0] + down * x, camera[1] + down * y
                over = (up < 0) & self._low(fx, fy)
                ground = -(self.mount.z_m + deep) / up
                far = np.inf if self.island else _leaves(x, y, camera, (x0, y0), (x1, y1))
                down = np.where(over, np.minimum(ground, far), down)
        return np.minimum(walls, down).astype(np.float32)

    def _low(self, x, y):
        """Whether the floor is missing at points, m."""
        if self.hole is None:
            return np.zeros(np.shape(x), bool)
        x0, x1, y0, y1, _ = self.hole
        within = (x > x0) & (x < x1) & (y > y0) & (y < y1)
        return ~within if self.island else within

    def falls(self, x_m: float, y_m: float, feet_m: float = 0.09) -> bool:
        """Whether a robot that stands there has left the floor."""
        turns = np.arange(8) * math.tau / 8
        x, y = x_m + feet_m * np.cos(turns), y_m + feet_m * np.sin(turns)
        return bool(self._low(np.r_[x, x_m], np.r_[y, y_m]).any())

    def hits(self, x_m: float, y_m: float) -> bool:
        """Whether it touches a wall."""
        return not (
            self.low[0] + RADIUS_M < x_m < self.high[0] - RADIUS_M
            and self.low[1] + RADIUS_M < y_m < self.high[1] - RADIUS_M
        )

    def observe(self, pose: Pose, rng: np.random.Generator | None = None) -> Observation:
        """With noise of a mid-range camera where there is an `rng`."""
        depth = self.depth(pose)
        if rng is not None:
            noise = 0.002 * depth**2 * rng.standard_normal(depth.shape)
            depth = np.where(rng.random(depth.shape) < 0.002, 0.0, depth + noise)
        rgb = np.zeros((*depth.shape, 3), np.uint8)
        return Observation(0, rgb, depth.astype(np.float32), pose, CAMERA)

    def look(
        self,
        grid: NavigationMap,
        pose: Pose,
        turns: int = 12,
        rng: np.random.Generator | None = None,
        mount: Mount | None = None,
    ) -> None:
        """Look around, two frames at each turn; `mount`: what the runtime takes it for."""
        taken = mount or self.mount
        for n in range(2 * turns):
            here = replace(pose, yaw_rad=pose.yaw_rad + n // 2 * math.tau / 12)
            obs = self.observe(here, rng)
            integrate(grid, obs, taken, RADIUS_M, HEIGHT_M, DEPTH_M)

    def inside(self, grid: NavigationMap, margin_m: float = 0.05) -> np.ndarray:
        """(R, C) the cells well inside the hole."""
        assert self.hole is not None
        x0, x1, y0, y1, _ = self.hole
        rows, cols = np.indices(grid.frame.shape)
        x, y = grid.frame.centres(np.stack([rows, cols], axis=-1).astype(np.int32)).transpose(
            2, 0, 1
        )
        within_x = (x > x0 + margin_m) & (x < x1 - margin_m)
        return within_x & (y > y0 + margin_m) & (y < y1 - margin_m)


def _leaves(x, y, camera, low, high):
    """How far along rays (H, W) a box around the camera, or before it, is left."""
    along_x = (np.where(x > 0, high[0], low[0]) - camera[0]) / x
    along_y = (np.where(y > 0, high[1], low[1]) - camera[1]) / y
    return np.minimum(along_x, along_y)
