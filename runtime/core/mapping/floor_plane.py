"""How high a camera is and how it tilts, by the floor that its depth image shows: for a mount that
changes and that nobody reports."""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from runtime.core.geometry import optical_rays, optical_to_base, wrap_angle
from runtime.core.types import F32, F64, Intrinsics, Mount

STRIDE: Final = 4  # every n-th pixel
RANGE_M: Final = (0.3, 4.0)  # of depth; what is farther is too uncertain
WITHIN_M: Final = 0.03  # of the plane: floor
BELOW_M: Final = 0.06  # under the plane: then it is not the lowest
FLOOR_SHARE: Final = 0.05  # of the image, at least,
SPREAD_M: Final = 0.16  # and so spread out (deviation) both ways, else its tilt is uncertain,
FLAT_M: Final = 0.012  # and as flat as that (deviation): what only crosses the plane is not
SAME_M: Final = 0.005  # from the mount before: the same,
SAME_RAD: Final = math.radians(0.15)  # so that a mount that rests is not one that trembles
TRIPLES: Final = 300  # of points that planes are laid through,
JUDGES: Final = 1500  # points that those are judged by
_LEAST: Final = 50  # points to begin with


@dataclass(frozen=True)
class Slack:
    """That a mount may be off by: up and down, and its pitch and its roll."""

    height_m: float
    tilt_rad: float


CARRIED: Final = Slack(0.15, math.radians(12.0))  # a mount that changes while it drives
MISTAKEN: Final = Slack(0.6, math.radians(35.0))  # one that somebody has measured wrongly


def mount_by_floor(depth_m: F32, intrinsics: Intrinsics, nominal: Mount, last: Mount) -> Mount:
    """(H, W) m along the optical axis, 0 where unknown, the mount as configured and as it was in
    the image before -> the mount in this image: height, pitch and roll by the floor that it shows;
    `last` where too little of one is seen."""
    found = floor_seen(depth_m, intrinsics, nominal, CARRIED, last)
    return last if found is None else _steady(found, last)


def floor_seen(
    depth_m: F32, intrinsics: Intrinsics, nominal: Mount, slack: Slack, last: Mount | None = None
) -> Mount | None:
    """The mount by the lowest large plane that is near enough to the configured mount's floor;
    None where too little of one is seen. `last`: where it may be as well."""
    points = _points(depth_m, intrinsics)
    if len(points) < _LEAST:
        return None
    likely = [_plane_of(mount)[None] for mount in (last, nominal) if mount is not None]
    planes = np.concatenate([_planes(_maybe_floor(points, nominal, slack)), *likely])
    planes = planes[_allowed(planes, nominal, slack)]
    if not len(planes):
        return None
    judges, single = points[:: max(1, len(points) // JUDGES)], planes.astype(np.float32)
    height = 1 - judges.astype(np.float32) @ single.T  # as a share of the camera's
    height /= np.linalg.norm(single, axis=1)
    votes = (np.abs(height) < WITHIN_M).sum(axis=0) - (height < -BELOW_M).sum(axis=0)
    plane = planes[int(votes.argmax())]
    for _ in range(3):
        floor = points[np.abs((1 - points @ plane) / np.linalg.norm(plane)) < WITHIN_M]
        if not _is_floor(floor, depth_m.size / STRIDE**2):
            return None
        # By inverse depth, in which cameras that triangulate err alike wherever the floor is.
        plane = np.linalg.lstsq(floor / floor[:, 2:], 1 / floor[:, 2], rcond=None)[0]
    if not _allowed(plane[None], nominal, slack)[0]:
        return None
    return _mounted(plane, nominal)


def _points(depth_m: F32, intrinsics: Intrinsics) -> F64:
    """(N, 3) m in the optical frame, of what is seen within range."""
    depth = depth_m[STRIDE // 2 :: STRIDE, STRIDE // 2 :: STRIDE]
    near = (depth > RANGE_M[0]) & (depth < RANGE_M[1])
    found: F64 = optical_rays(intrinsics, STRIDE)[near] * depth[near][:, None]
    return found


def _maybe_floor(points: F64, nominal: Mount, slack: Slack) -> F64:
    """What a mount that is off by as much as may be could have seen of the floor."""
    height = nominal.z_m + points @ optical_to_base(nominal)[2]
    most = slack.height_m + math.sin(slack.tilt_rad) * np.linalg.norm(points, axis=1)
    return np.asarray(points[np.abs(height) < most], np.float64)


# A plane is the vector (3,) with points @ plane = 1: away from the camera along the floor's normal,
# as long as one over the camera's height.


def _planes(points: F64) -> F64:
    """(K, 3) planes through three points each, the same for the same image."""
    if not len(points):
        return np.zeros((0, 3))
    chosen = np.random.default_rng(0).integers(len(points), size=(TRIPLES, 3))
    a, b, c = points[chosen].swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    height = np.einsum("ij,ij->i", normal, a)
    sound = np.abs(height) > 1e-9
    return np.asarray(normal[sound] / height[sound, None], np.float64)


def _plane_of(mount: Mount) -> F64:
    return np.asarray(-optical_to_base(mount)[2] / mount.z_m, np.float64)


def _allowed(
    planes: F64, nominal: Mount, slack: Slack
) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """(K, 3) -> (K,) which are near enough to the floor of the configured mount."""
    height, pitch, roll = _angles(planes)
    turned = np.abs(np.remainder(roll - nominal.roll_rad + math.pi, math.tau) - math.pi)
    tilted = np.abs(pitch - nominal.pitch_rad)
    allowed = (np.abs(height - nominal.z_m) < slack.height_m) & (tilted < slack.tilt_rad)
    return np.asarray(allowed & (turned < slack.tilt_rad), bool)


def _angles(planes: F64) -> tuple[F64, F64, F64]:
    """(K, 3) -> the camera's height, m, pitch and roll, rad."""
    height = 1 / np.linalg.norm(planes, axis=1)
    right, down, ahead = -planes.T * height
    return height, np.arcsin(np.clip(-ahead, -1, 1)), np.arctan2(-right, -down)


def _mounted(plane: F64, nominal: Mount) -> Mount:
    height, pitch, roll = (float(v[0]) for v in _angles(plane[None]))
    return replace(nominal, z_m=height, pitch_rad=pitch, roll_rad=roll)


def _is_floor(points: F64, pixels: float) -> bool:
    """Whether these points are enough to say how the floor lies."""
    if len(points) < FLOOR_SHARE * pixels:
        return False
    flat, spread, _ = np.linalg.eigvalsh(np.cov(points.T))
    return bool(spread > SPREAD_M**2 and flat < FLAT_M**2)


def _steady(mount: Mount, last: Mount) -> Mount:
    """The last mount, where the new one is hardly another."""
    turned = max(
        abs(wrap_angle(mount.roll_rad - last.roll_rad)), abs(mount.pitch_rad - last.pitch_rad)
    )
    return last if abs(mount.z_m - last.z_m) < SAME_M and turned < SAME_RAD else mount
