"""What was near the body a moment ago and is not in view any more, as a low thing is that the robot
comes close to: it is kept until the place is seen again."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from runtime.core.geometry import map_to_optical, project
from runtime.core.mapping.near_points import NearPoints
from runtime.core.types import F32, F64, Intrinsics, Mount, Pose, Scan

KEEP_NS: Final = 10_000_000_000  # after which the map has to know
SCAN_NS: Final = 500_000_000
KEEP_M: Final = 2.5  # from the robot
JUMP_M: Final = 0.5  # between two images: odometry lies elsewhere
BEFORE_M: Final = 0.15  # of a place something stands, which hides it
HEIGHTS: Final = (0.0, 0.25, -0.25, 0.5, -0.5)  # of what was seen: from its middle, that is 0, down
KEPT: Final = 800  # points at most, the nearest


@dataclass(frozen=True)
class Nearby:
    """What is near as far as is known, in the map frame, m: obstacles (N, 2), and drops (M, 2),
    places without floor. `stamp_ns`: of the newest image."""

    stamp_ns: int
    obstacles: F32
    drops: F32


class NearMemory:
    """One for a camera."""

    def __init__(self) -> None:
        self._points = np.zeros((0, 3))  # map frame
        self._lowest_m = np.zeros(0)  # that was seen of each
        self._drops = np.zeros(0, bool)
        self._seen_ns = np.zeros(0, np.int64)
        self._pose: Pose | None = None
        self._met = np.zeros((0, 2), np.float32)  # by the newest scan, map frame
        self._met_ns = 0

    def add(
        self,
        seen: NearPoints,
        depth_m: F32,
        pose: Pose,
        intrinsics: Intrinsics,
        mount: Mount,
        stamp_ns: int,
    ) -> Nearby:
        """What an image (H, W) m showed near by, and of what was shown before that which it did not
        look at."""
        last, self._pose = self._pose, pose
        moved = last is not None and float(np.hypot(*(pose.xy - last.xy))) > JUMP_M
        kept = np.zeros(len(self._points), bool)
        if not moved and len(kept):
            kept = ~self._looked_at(depth_m, pose, intrinsics, mount)
            kept &= np.hypot(*(self._points[:, :2] - pose.xy).T) <= KEEP_M
            kept &= np.abs(stamp_ns - self._seen_ns) <= KEEP_NS
        new = np.concatenate([_in_map(seen.obstacles, pose), _in_map(seen.drops, pose)])
        fell = np.arange(len(new)) >= len(seen.obstacles)
        self._points = np.concatenate([new, self._points[kept]])
        lowest_m = np.concatenate([seen.lowest_m, np.zeros(len(seen.drops))])
        self._lowest_m = np.concatenate([lowest_m, self._lowest_m[kept]])
        self._drops = np.concatenate([fell, self._drops[kept]])
        stamps = np.full(len(new), stamp_ns, np.int64)
        self._seen_ns = np.concatenate([stamps, self._seen_ns[kept]])
        if len(self._points) > KEPT:
            self._keep_nearest(pose)
        xy = self._points[:, :2].astype(np.float32)
        return Nearby(stamp_ns, xy[~self._drops], xy[self._drops])

    def with_scan(self, near: Nearby, scan: Scan | None, pose: Pose, radius_m: float) -> Nearby:
        """And what a laser met; what it met within the body is the robot itself. Without a new
        scan what the one before met counts for a while."""
        if scan is not None:
            there = np.isfinite(scan.ranges_m) & (scan.ranges_m > 0)
            ranges, at = scan.ranges_m[there, None], scan.headings_rad[there]
            met = scan.at_xy + ranges * np.stack([np.cos(at), np.sin(at)], axis=1)
            away_m = np.hypot(*(met - pose.xy).T)
            self._met = met[(away_m >= radius_m) & (away_m <= KEEP_M)].astype(np.float32)
            self._met_ns = near.stamp_ns
        if not len(self._met) or abs(near.stamp_ns - self._met_ns) > SCAN_NS:
            return near
        return replace(near, obstacles=np.concatenate([near.obstacles, self._met]))

    def _keep_nearest(self, pose: Pose) -> None:
        """A table's top has as many points as fit; what lies at its foot is nearer."""
        away_m = np.hypot(*(self._points[:, :2] - pose.xy).T)
        nearest = np.sort(np.argpartition(away_m, KEPT)[:KEPT])
        self._points, self._drops = self._points[nearest], self._drops[nearest]
        self._lowest_m, self._seen_ns = self._lowest_m[nearest], self._seen_ns[nearest]

    def _looked_at(
        self, depth_m: F32, pose: Pose, intrinsics: Intrinsics, mount: Mount
    ) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """(N,) whether the image reaches each: what it shows there now stands for it. Not where
        depth ends before it. Where it is unknown, as nearer than a camera can tell, on glass, or in
        a hall that is longer than it sees, a little lower or higher tells."""
        behind_m = np.full(len(self._points), np.nan)
        for share in HEIGHTS:
            points = self._points[unknown := np.isnan(behind_m)]
            points[:, 2] -= share * (points[:, 2] - self._lowest_m[unknown])
            behind_m[unknown] = _behind_m(points, depth_m, pose, intrinsics, mount)
        return behind_m > -BEFORE_M


def _in_map(points: F32, pose: Pose) -> F64:
    """(N, 3) m, base frame -> map frame."""
    c, s = np.cos(pose.yaw_rad), np.sin(pose.yaw_rad)
    x, y, z = points.astype(np.float64).T
    return np.stack([pose.x_m + c * x - s * y, pose.y_m + s * x + c * y, z], axis=1)


def _behind_m(points: F64, depth_m: F32, pose: Pose, intrinsics: Intrinsics, mount: Mount) -> F64:
    """(N, 3) m, map frame -> (N,) how much farther than each an image (H, W) m reads there, m; NaN
    where it reads nothing, -inf where it does not look."""
    behind = np.full(len(points), -np.inf)
    optical = map_to_optical(points, pose, mount)
    at = np.flatnonzero(optical[:, 2] > 0.01)
    col, row = np.rint(project(optical[at], intrinsics)).astype(np.int64).T
    height, width = depth_m.shape
    inside = (col >= 0) & (col < width) & (row >= 0) & (row < height)
    at, row, col = at[inside], row[inside], col[inside]
    read = depth_m[row, col]
    behind[at] = np.where(read > 0, read - optical[at, 2], np.nan)
    return behind
