"""A drive that nobody recorded: a robot goes round in a furnished room of right angles, past two
doorways behind which it never looks round the corner: there is always something to decide. What
the bench plays when it is given no file."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from runtime.core.geometry import rays
from runtime.core.types import F32, F64, U8, Intrinsics, Mount, Pose
from runtime.robot import wire
from runtime.robot.session import TopicsConfig

FRAME_S, ODOMETRY_S = 0.1, 0.05
ROUND_FRAMES = 120  # poses of a round, rendered once
RADIUS_M = 0.8
LENS = Intrinsics(460.0, 460.0, 319.5, 239.5, 640, 480)
BOXES = (  # x0, x1, y0, y1, height: the room round its middle first, m
    (-3.5, 4.5, -2.5, 3.0, 2.4),
    (1.9, 2.8, -1.0, 0.9, 0.75),
    (-2.6, -1.8, -2.4, -0.6, 0.9),
    (-1.2, 0.6, 2.2, 2.9, 1.8),
    (-0.2, 0.2, -0.2, 0.2, 1.1),
    (2.6, 4.4, 1.9, 2.9, 0.45),
)
DOORWAYS = ((4.4, 5.0, -1.9, -1.1), (-3.0, -2.2, 2.9, 3.3))  # through the room's walls, into
BEYOND = ((5.0, 9.0, -4.5, 4.0), (-6.5, 1.0, 3.3, 7.5))  # the rooms behind them: x0, x1, y0, y1


@dataclass(frozen=True)
class Published:
    """What is published, and when: nanoseconds of the drive."""

    topic: str
    at_ns: int
    payload: bytes


def drive(seconds: float, topics: TopicsConfig, mount: Mount) -> Iterator[Published]:
    """The messages of so many seconds, in their order."""
    shown = min(ROUND_FRAMES, math.ceil(seconds / FRAME_S))
    frames = [_frame(_pose(n * FRAME_S), mount) for n in range(shown)]
    begin_ns = 10**18
    for tick in range(round(seconds / ODOMETRY_S)):
        at_s = tick * ODOMETRY_S
        stamp = begin_ns + round(at_s * 1e9)
        yield Published(topics.odom, stamp, wire.encode_odometry(_pose(at_s), stamp))
        frame, rest = divmod(tick, round(FRAME_S / ODOMETRY_S))
        if rest == 0:
            rgb, depth = frames[frame % ROUND_FRAMES]
            info = wire.encode_camera_info(LENS, stamp)
            yield Published(topics.camera_info, stamp, info)
            yield Published(topics.depth, stamp, wire.encode_depth(depth, stamp))
            yield Published(topics.color, stamp, wire.encode_color(rgb, stamp))


def _pose(at_s: float) -> Pose:
    """A circle, a round in ROUND_FRAMES frames."""
    turn = math.tau * at_s / (ROUND_FRAMES * FRAME_S)
    yaw = math.remainder(turn + math.pi / 2, math.tau)
    return Pose(RADIUS_M * math.cos(turn), RADIUS_M * math.sin(turn), yaw)


def _frame(pose: Pose, mount: Mount) -> tuple[U8, F32]:
    """Colour (H, W, 3) and depth (H, W), m."""
    table = rays(LENS, mount, 1)
    forward, left, up = np.broadcast_arrays(table.forward, table.left, table.up)
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    east, north = c * forward - s * left, s * forward + c * left
    x, y = pose.x_m + c * mount.x_m - s * mount.y_m, pose.y_m + s * mount.x_m + c * mount.y_m
    depth = np.where(up < -1e-3, -mount.z_m / np.minimum(up, -1e-3), np.inf)
    paint = np.zeros(depth.shape)
    for n, (x0, x1, y0, y1, high) in enumerate(BOXES):
        near, far = _slab(x0 - x, x1 - x, y0 - y, y1 - y, east, north)
        if n == 0:
            for doorway, room in zip(DOORWAYS, BEYOND, strict=True):
                far = _through(doorway, (x, y), (east, north), far)
                far = _through(room, (x, y), (east, north), far)
        at = far if n == 0 else near
        hit = (at > 0.05) & (near <= far) & (mount.z_m + at * up <= high) & (at < depth)
        depth, paint = np.where(hit, at, depth), np.where(hit, n + 1, paint)
    depth = np.where(depth < 8.0, depth, 0.0).astype(np.float32)
    grain = np.random.default_rng(0).integers(0, 24, (*depth.shape, 3))
    shade = (40 + 160 / (1 + depth))[..., None] + paint[..., None] * (7, -5, 11) + grain
    return np.clip(shade, 0, 255).astype(np.uint8), depth


def _through(
    space: tuple[float, float, float, float],
    eye: tuple[float, float],
    ray: tuple[F64, F64],
    at: F64,
) -> F64:
    """How far rays get that have come so far: those that are in the next space then, through
    it."""
    (x0, x1, y0, y1), (x, y), (east, north), on = space, eye, ray, at + 1e-3
    x_on, y_on = x + east * on, y + north * on
    inside = (x_on > x0) & (x_on < x1) & (y_on > y0) & (y_on < y1)
    _, far = _slab(x0 - x, x1 - x, y0 - y, y1 - y, east, north)
    return np.where(inside, far, at)


def _slab(
    x0: float, x1: float, y0: float, y1: float, east: F64, north: F64
) -> tuple[F64, F64]:  # fmt: skip
    """Along each ray, where it enters and leaves a rectangle around which the camera is at 0, 0."""
    east = np.where(np.abs(east) < 1e-6, 1e-6, east)
    north = np.where(np.abs(north) < 1e-6, 1e-6, north)
    xs, ys = np.stack([x0 / east, x1 / east]), np.stack([y0 / north, y1 / north])
    near = np.maximum(xs.min(axis=0), ys.min(axis=0))
    far = np.minimum(xs.max(axis=0), ys.max(axis=0))
    return near, far
