"""A flat-land apartment for testing the core: walls and boxes on a fine grid, depth by ray casting.

It knows nothing of PyBullet or Zenoh; a closed loop over it runs in seconds.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from runtime.core.geometry import Rays, rays
from runtime.core.types import Action, Detections, Intrinsics, Mount, Observation, Pose
from runtime.core.world import NewestImage

INTRINSICS = Intrinsics(97.06, 97.06, 80.0, 60.0, 160, 120)
MOUNT = Mount()
CELL = 0.02
KEPT = 100  # images of which it is known what they showed
NO_DETECTIONS = Detections(
    np.zeros((0, 4), np.float32),
    np.zeros(0, np.float32),
    np.zeros(0, np.int32),
    np.zeros((0, 8), np.float32),
    np.zeros(0, np.float32),
)


@dataclass
class Apartment:
    """Heights (m) over a fine grid; origin at (0, 0), x along columns, y along rows."""

    heights: np.ndarray
    pose: Pose
    things: dict[str, tuple[float, float, float]] = field(default_factory=dict)  # name -> x, y, r
    rooms: list[tuple[tuple[float, float, float, float], int]] = field(default_factory=list)
    room_count: int = 0
    stamp_ns: int = 0
    path_m: float = 0.0
    collisions: int = 0
    shown: dict[int, Observation] = field(default_factory=dict)  # by the number in the image

    @classmethod
    def of(cls, plan: str, pose: Pose, scale_m: float = 0.25) -> "Apartment":
        """`#` wall, `o` furniture of 0.5 m, `b` a box of 0.2 m, others floor; first line is the
        largest y."""
        table = {"#": 2.5, "o": 0.5, "b": 0.2}
        lines = plan.strip("\n").split("\n")
        width = max(map(len, lines))
        coarse = np.array(
            [[table.get(c, 0.0) for c in line.ljust(width)] for line in reversed(lines)]
        )
        n = round(scale_m / CELL * 2)
        fine = np.kron(coarse, np.ones((n, n)))[::2, ::2]
        return cls(fine, pose)

    def observe(self) -> Observation:
        """Depth and pose; the colour image is black but for one pixel, which numbers the pose."""
        self.stamp_ns += 100_000_000
        pose = self.pose  # a robot in real time goes on meanwhile
        depth = self.depth(rays(INTRINSICS, MOUNT, 1), pose)
        rgb = np.zeros((*depth.shape, 3), np.uint8)
        number = max(self.shown, default=0)
        if not self.shown or self.shown[number].pose != pose:  # else all is as it was
            number += 1
        rgb[0, 0] = [number & 255, number >> 8 & 255, number >> 16]
        obs = Observation(self.stamp_ns, rgb, depth, pose, INTRINSICS)
        self.shown[number] = obs
        self.shown.pop(number - KEPT, None)
        return obs

    def of_image(self, rgb: np.ndarray) -> Observation:
        """What was observed when that image was taken; without its number, what is now."""
        red, green, blue = (int(value) for value in rgb[0, 0])
        return self.shown.get(red | green << 8 | blue << 16) or self.observe()

    def depth(self, table: Rays, pose: Pose) -> np.ndarray:
        w = table.up.shape[1]
        floor = np.where(table.up < -1e-6, -MOUNT.z_m / np.minimum(table.up, -1e-6), np.inf)
        depth = floor
        for column in range(w):
            azimuth = math.atan2(table.left[0, column], table.forward[0, column])
            for distance, height in self._hits(pose, pose.yaw_rad + azimuth):
                z = distance * math.cos(azimuth)
                ray_height = MOUNT.z_m + z * table.up[:, column]
                hit = (ray_height <= height) & (z < depth[:, column])
                depth[:, column] = np.where(hit, z, depth[:, column])
        return np.where((depth > 0.3) & (depth < 5.0), depth, 0).astype(np.float32)

    def _hits(self, pose: Pose, heading: float) -> list[tuple[float, float]]:
        """(distance, height) of the surfaces along a heading, rising heights only."""
        t = np.arange(0.02, 5.5, CELL)
        cols = ((pose.x_m + t * math.cos(heading)) / CELL).astype(int)
        rows = ((pose.y_m + t * math.sin(heading)) / CELL).astype(int)
        inside = (rows >= 0) & (cols >= 0)
        inside &= (rows < self.heights.shape[0]) & (cols < self.heights.shape[1])
        heights = np.where(
            inside,
            self.heights[
                np.clip(rows, 0, self.heights.shape[0] - 1),
                np.clip(cols, 0, self.heights.shape[1] - 1),
            ],
            2.5,
        )
        top = np.maximum.accumulate(heights)
        rise = np.flatnonzero(np.diff(np.r_[0.0, top]) > 0)
        return [(float(t[i]), float(top[i])) for i in rise]

    def detect(self, names: tuple[str, ...], obs: Observation, score: float = 0.8) -> Detections:
        """A perfect detector of `things` within 4 m that nothing hides, from the pose of `obs`."""
        boxes, labels = [], []
        for name, (x, y, r) in sorted(self.things.items()):
            if name not in names:
                continue
            dx, dy = x - obs.pose.x_m, y - obs.pose.y_m
            c, s = math.cos(obs.pose.yaw_rad), math.sin(obs.pose.yaw_rad)
            forward, left = c * dx + s * dy, -s * dx + c * dy
            if not 0.6 < forward < 4.0:
                continue
            u = INTRINSICS.cx - left / forward * INTRINSICS.fx
            if not 5 < u < INTRINSICS.width - 5:
                continue
            v = INTRINSICS.cy + (MOUNT.z_m - 0.3) / forward * INTRINSICS.fy
            if v >= INTRINSICS.height - 2 or obs.depth_m[int(v), int(u)] < forward - r - 0.3:
                continue
            half = r / forward * INTRINSICS.fx
            boxes.append([u - half, v - half, u + half, v + half])
            labels.append(names.index(name))
        rooms = np.zeros(self.room_count, np.float32)
        for (x0, y0, x1, y1), kind in self.rooms:
            if x0 <= obs.pose.x_m < x1 and y0 <= obs.pose.y_m < y1:
                rooms[kind] = 1.0
        n = len(boxes)
        return Detections(
            np.array(boxes, np.float32).reshape(n, 4),
            np.full(n, score, np.float32),
            np.array(labels, np.int32),
            np.zeros((n, 8), np.float32),
            rooms,
        )

    def apply(self, action: Action, forward_m: float = 0.25, turn_rad: float = math.pi / 6) -> bool:
        """Move the robot; a blocked step stops before the obstacle. True if it was blocked."""
        p = self.pose
        if action is Action.TURN_LEFT:
            self.pose = Pose(p.x_m, p.y_m, math.remainder(p.yaw_rad + turn_rad, math.tau))
        elif action is Action.TURN_RIGHT:
            self.pose = Pose(p.x_m, p.y_m, math.remainder(p.yaw_rad - turn_rad, math.tau))
        elif action is Action.MOVE_FORWARD:
            for n in range(1, 11):
                d = forward_m * n / 10
                x, y = p.x_m + d * math.cos(p.yaw_rad), p.y_m + d * math.sin(p.yaw_rad)
                if not self.fits(x, y):
                    self.collisions += 1
                    return True
                self.path_m += forward_m / 10
                self.pose = Pose(x, y, p.yaw_rad)
        return False

    def fits(self, x: float, y: float, radius_m: float = 0.18) -> bool:
        """Whether the body disc touches nothing."""
        n = math.ceil(radius_m / CELL)
        row, col = int(y / CELL), int(x / CELL)
        r, c = np.mgrid[-n : n + 1, -n : n + 1]
        near = np.hypot(r, c) * CELL <= radius_m
        rows, cols = (row + r[near]), (col + c[near])
        if (rows < 0).any() or (cols < 0).any():
            return False
        if (rows >= self.heights.shape[0]).any() or (cols >= self.heights.shape[1]).any():
            return False
        return bool((self.heights[rows, cols] == 0).all())


TWO_ROOMS = """
########################################
#                 #                    #
#                 #                    #
#    oo           #          ooo       #
#    oo           #          ooo       #
#                                      #
#                                      #
#                                      #
#                                      #
#                 #                    #
#        b        #                    #
#                 #           oo       #
#                 #           oo       #
#                 #                    #
########     ###########################
#                                      #
#                                      #
#   ooo                                #
#   ooo                                #
#                                      #
########################################
"""


def looked_from(pose: Pose, *called: int) -> NewestImage:
    """An image of which no more is known than where it was taken and which instances it calls what
    is sought; nothing is read in it."""
    rgb, depth_m = np.zeros((120, 160, 3), np.uint8), np.zeros((120, 160), np.float32)
    return NewestImage(Observation(0, rgb, depth_m, pose, INTRINSICS), MOUNT, frozenset(called))
