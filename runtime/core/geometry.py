"""Angles, camera rays and the grid's frame. Pure functions; frames and units in each docstring."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from runtime.core.types import F32, F64, I32, Intrinsics, Mount, Pose


def wrap_angle(angle_rad: float) -> float:
    """Any angle -> the same direction in (-pi, pi]."""
    wrapped = math.remainder(angle_rad, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def bearing(from_xy: tuple[float, float], to_xy: tuple[float, float]) -> float:
    """Direction of `to` seen from `from` in the map frame, rad."""
    return math.atan2(to_xy[1] - from_xy[1], to_xy[0] - from_xy[0])


def project(points: F64, intrinsics: Intrinsics) -> F64:
    """(N, 3) m in the optical frame, z > 0 -> (N, 2) pixels; (0, 0) is the middle of the first."""
    x, y, z = points.T
    return np.stack(
        [x / z * intrinsics.fx + intrinsics.cx - 0.5, y / z * intrinsics.fy + intrinsics.cy - 0.5],
        axis=1,
    )


def placed(frame: Pose, pose: Pose) -> Pose:
    """A pose in a frame, in what the frame's own pose is in."""
    c, s = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    x_m = frame.x_m + c * pose.x_m - s * pose.y_m
    y_m = frame.y_m + s * pose.x_m + c * pose.y_m
    return Pose(x_m, y_m, wrap_angle(frame.yaw_rad + pose.yaw_rad))


def seen_from(frame: Pose, pose: Pose) -> Pose:
    """The way back: a pose in what the frame's own pose is in, in the frame."""
    c, s = math.cos(frame.yaw_rad), math.sin(frame.yaw_rad)
    dx, dy = pose.x_m - frame.x_m, pose.y_m - frame.y_m
    return Pose(c * dx + s * dy, c * dy - s * dx, wrap_angle(pose.yaw_rad - frame.yaw_rad))


_OPTICAL_AXES = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""x ahead, y to the left, z up, by x right, y down, z ahead."""


@lru_cache(maxsize=64)
def optical_to_base(mount: Mount) -> F64:
    """(3, 3) rotation from the camera optical frame to the base frame (REP 103, 105)."""
    cr, sr = math.cos(mount.roll_rad), math.sin(mount.roll_rad)
    cp, sp = math.cos(mount.pitch_rad), math.sin(mount.pitch_rad)
    cy, sy = math.cos(mount.yaw_rad), math.sin(mount.yaw_rad)
    roll = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    pitch = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    yaw = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    rotation: F64 = yaw @ pitch @ roll @ _OPTICAL_AXES
    rotation.flags.writeable = False  # it is shared
    return rotation


def mount_of(rotation: F64, offset_m: F64, digits: int) -> Mount:
    """(3, 3) from the camera optical frame to the base frame, and (3,) where the camera is in it ->
    the mount, rounded."""
    turn = rotation @ _OPTICAL_AXES.T
    roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    pitch = math.asin(max(-1.0, min(1.0, -float(turn[2, 0]))))
    return Mount(*(round(float(v), digits) for v in (*offset_m, roll, pitch, yaw)))


def map_to_optical(points: F64, pose: Pose, mount: Mount) -> F64:
    """(N, 3) m in the map frame -> (N, 3) m in the camera optical frame."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    dx, dy = points[:, 0] - pose.x_m, points[:, 1] - pose.y_m
    base = np.stack([c * dx + s * dy, -s * dx + c * dy, points[:, 2]], axis=1)
    offset = np.array([mount.x_m, mount.y_m, mount.z_m])
    return np.asarray((base - offset) @ optical_to_base(mount), np.float64)


@dataclass(frozen=True)
class Rays:
    """Directions of an image's sampled pixels in the base frame, per metre of depth.

    forward, left, up: (h, w); reach: (h, w), of the horizontal part, farthest: its most. groups:
    which azimuth a pixel is of, (h, w), or (1, w) where all pixels of a column are of one;
    azimuths: (B,) rad in the base frame, ascending.
    """

    stride: int
    forward: F32
    left: F32
    up: F32
    reach: F32
    farthest: float
    groups: I32
    azimuths: F32


class Standoff(NamedTuple):
    """How far before the base a thing has to be at least to be in the image, m: what of it is
    nearest, and its middle. 0: wherever it is; inf: the camera looks past it anyway."""

    nearest_m: float = 0.0
    middle_m: float = 0.0


def standoff(intrinsics: Intrinsics, mount: Mount, low_m: float, high_m: float) -> Standoff:
    """For a thing that reaches from `low_m` up to `high_m`: what is below the camera is seen by the
    top of its nearest side; what is above it by its middle, for it may lean over what is below."""
    down = math.atan2(intrinsics.height - intrinsics.cy, intrinsics.fy) + mount.pitch_rad
    up = math.atan2(intrinsics.cy, intrinsics.fy) - mount.pitch_rad
    if high_m < mount.z_m:
        return Standoff(nearest_m=_off(mount, mount.z_m - high_m, down))
    if low_m > mount.z_m:
        return Standoff(middle_m=_off(mount, 0.5 * (low_m + high_m) - mount.z_m, up))
    return Standoff()


def _off(mount: Mount, off_m: float, edge_rad: float) -> float:
    """How far before the base an edge of the image is so far below or above the camera, m."""
    return mount.x_m + off_m / math.tan(edge_rad) if edge_rad > 0 else math.inf


@lru_cache(maxsize=8)
def pixel_offsets(intrinsics: Intrinsics, stride: int) -> tuple[F64, F64]:
    """(w,) and (h,) px to the right of and below the principal point, of every `stride`-th pixel's
    middle; shared."""
    across = np.arange(stride // 2, intrinsics.width, stride) + 0.5 - intrinsics.cx
    down = np.arange(stride // 2, intrinsics.height, stride) + 0.5 - intrinsics.cy
    return np.asarray(across, np.float64), np.asarray(down, np.float64)


@lru_cache(maxsize=8)
def optical_rays(intrinsics: Intrinsics, stride: int) -> F64:
    """(h, w, 3) m per metre of depth in the optical frame, of every `stride`-th pixel; shared."""
    across, down = pixel_offsets(intrinsics, stride)
    x, y = np.meshgrid(across / intrinsics.fx, down / intrinsics.fy)
    return np.stack([x, y, np.ones(x.shape)], axis=-1)


def rays(intrinsics: Intrinsics, mount: Mount, stride: int, bins_per_rad: float = 240.0) -> Rays:
    """The ray table of a camera, every `stride`-th pixel; computed once for how a mount is turned,
    wherever it is."""
    turned = Mount(0.0, 0.0, 0.0, mount.roll_rad, mount.pitch_rad, mount.yaw_rad)
    return _rays(intrinsics, turned, stride, bins_per_rad)


@lru_cache(maxsize=8)
def _rays(intrinsics: Intrinsics, mount: Mount, stride: int, bins_per_rad: float) -> Rays:
    across, down = pixel_offsets(intrinsics, stride)
    right, below, ahead = optical_to_base(mount).T
    base = [
        (right[i] / intrinsics.fx * across)[None]
        + (below[i] / intrinsics.fy * down + ahead[i])[:, None]
        for i in range(3)
    ]
    bins = np.floor(np.arctan2(base[1], base[0]) * bins_per_rad).astype(np.int32)
    bins = bins[:1] if (bins == bins[0]).all() else bins
    first = int(bins.min())
    seen = np.bincount((bins - first).ravel()) > 0
    groups = (np.cumsum(seen) - 1)[bins - first]
    centres = (np.flatnonzero(seen) + first + 0.5) / bins_per_rad
    forward, left, up = (axis.astype(np.float32) for axis in base)
    reach = np.hypot(forward, left)
    return Rays(
        stride,
        forward,
        left,
        up,
        reach,
        float(reach.max()),
        groups.astype(np.int32),
        centres.astype(np.float32),
    )


@dataclass(frozen=True)
class GridFrame:
    """Where a grid lies: cell (row, col) covers [x0 + col * r, y0 + row * r] and r further. A part
    of a grid counts its cells from `first_row`, `first_col` of the whole: the same numbers come
    out, to the last bit."""

    x0_m: float
    y0_m: float
    resolution_m: float
    rows: int
    cols: int
    first_row: int = 0
    first_col: int = 0

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""
        return self.rows, self.cols

    @property
    def place(self) -> tuple[float, float, float, int, int]:
        """As kernels take it: all but the shape."""
        return self.x0_m, self.y0_m, self.resolution_m, self.first_row, self.first_col

    def cells(self, xy: F64) -> I32:
        """(..., 2) m in the map frame -> (..., 2) row, col; may lie outside."""
        scaled = (np.asarray(xy) - (self.x0_m, self.y0_m)) / self.resolution_m
        first = np.array([self.first_row, self.first_col], np.int32)
        return np.floor(scaled[..., ::-1]).astype(np.int32) - first

    def cell(self, x_m: float, y_m: float) -> tuple[int, int]:
        """One point, m -> (row, col)."""
        return (
            math.floor((y_m - self.y0_m) / self.resolution_m) - self.first_row,
            math.floor((x_m - self.x0_m) / self.resolution_m) - self.first_col,
        )

    def centres(self, cells: I32) -> F64:
        """(..., 2) row, col -> (..., 2) m, the cells' centres in the map frame."""
        origin = np.array([self.x0_m, self.y0_m])
        ahead = np.array([self.first_col + 0.5, self.first_row + 0.5])
        xy: F64 = (np.asarray(cells, np.float64)[..., ::-1] + ahead) * self.resolution_m + origin
        return xy

    def contains(self, row: int, col: int) -> bool:
        """Whether the cell is inside the grid."""
        return 0 <= row < self.rows and 0 <= col < self.cols


def camera_at(pose: Pose, mount: Mount) -> tuple[tuple[float, float], tuple[float, float]]:
    """Where the camera is in the map frame, m, and cosine and sine of the base's yaw."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    x_m = pose.x_m + c * mount.x_m - s * mount.y_m
    return (x_m, pose.y_m + s * mount.x_m + c * mount.y_m), (c, s)
