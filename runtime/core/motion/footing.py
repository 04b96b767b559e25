"""What the robot may stand on: floor that was seen, and not merely air that was looked through."""

import math
from dataclasses import dataclass

import numpy as np

from runtime.core.geometry import GridFrame, rays
from runtime.core.mapping.drops import DROP_AT, SAME_M
from runtime.core.mapping.grid import RESOLUTION_M, STRIDE, NavigationMap
from runtime.core.mapping.windows import part_frame, widened
from runtime.core.types import F64, Intrinsics, Mask, Mount, Pose

MOST_BLIND_M = 2.0  # of a camera that never sees the floor
NEAR_M = 0.6  # of a path that is told to lead over floor that was never seen


@dataclass(frozen=True)
class Footing:
    """Cells (r, c) around the robot. floor: known to be free, and seen to be floor, driven over, or
    swept by a ray along whose azimuth floor was seen there or beyond. blind: free as far as is
    known, but not that, round where the map began and nothing of the floor near by was in view.
    seen: of the floor what was not merely swept; None where that is all of it."""

    frame: GridFrame
    floor: Mask
    blind: Mask
    seen: Mask | None = None

    def bears(self, points_xy: F64, unseen: bool = False) -> bool:
        """Whether all of the points (N, 2) m are on floor, or with `unseen` on what is blind."""
        ground = self.floor | self.blind if unseen else self.floor
        return bool(self._at(ground, points_xy).all())

    def was_seen(self, points_xy: F64) -> bool:
        """Whether all of the points (N, 2) m are on floor that was seen or driven over."""
        return bool(self._at(self.floor if self.seen is None else self.seen, points_xy).all())

    def begins_blind(self, path_xy: F64) -> bool:
        """Whether a path (N, 2) m leads over what is blind before long."""
        if not self.blind.any() or not len(path_xy):
            return False
        near = np.hypot(*(path_xy - path_xy[0]).T) <= NEAR_M
        return bool(self._at(self.blind, path_xy[near]).any())

    def _at(self, mask: Mask, points_xy: F64) -> Mask:
        cells = self.frame.cells(points_xy)
        inside = ((cells >= 0) & (cells < self.frame.shape)).all(axis=1)
        found = np.zeros(len(cells), bool)
        found[inside] = mask[tuple(cells[inside].T)]
        return found


def footing(
    grid: NavigationMap, pose: Pose, range_m: float, lens: tuple[Intrinsics, Mount] | None
) -> Footing:
    """The footing that near to the robot: copies, which nobody changes. What is blind round the
    start counts once: a robot that has left it is told of none any more."""
    n = math.ceil(range_m / grid.frame.resolution_m)
    row, col = grid.frame.cell(pose.x_m, pose.y_m)
    window = widened((slice(row - n, row + n + 1), slice(col - n, col + n + 1)), 0, grid.frame)
    free = grid.free[window]
    seen = free & ((grid.evidence[window] < 0) | (grid.driven[window] > 0))
    floor = seen | (free & grid.backed[window])
    frame, blind = part_frame(grid.frame, window), np.zeros(free.shape, bool)
    blind_m = floor_from_m(*lens) if lens else MOST_BLIND_M
    if grid.began_xy and math.dist(grid.began_xy, (pose.x_m, pose.y_m)) > blind_m:
        grid.began_xy = None
    if grid.began_xy:
        seen_from = grid.openings.from_xy
        if seen_from and math.dist(seen_from, grid.began_xy) < SAME_M:  # it began beside an opening
            floor &= seen
        rows, cols = np.indices(free.shape, np.int32)
        away = frame.centres(np.stack([rows, cols], axis=-1)) - grid.began_xy
        blind = free & ~floor & (np.hypot(away[..., 0], away[..., 1]) <= blind_m)
    return Footing(frame, floor, blind, seen)


def floor_from_m(intrinsics: Intrinsics, mount: Mount) -> float:
    """From how far on, m, straight ahead, the camera sees the floor; MOST_BLIND_M at most."""
    table = rays(intrinsics, mount, STRIDE)
    middle = table.up.shape[1] // 2
    up, reach = float(table.up[-1, middle]), float(table.reach[-1, middle])
    if up >= 0:
        return MOST_BLIND_M
    return min(MOST_BLIND_M, mount.z_m / -up * reach + RESOLUTION_M)


def no_floor(grid: NavigationMap, points_xy: F64) -> Mask:
    """(..., 2) m -> (...) where the floor is known to drop, or may and was not seen."""
    cells = np.clip(grid.frame.cells(points_xy), 0, np.array(grid.frame.shape) - 1)
    at = cells[..., 0], cells[..., 1]
    doubtful = grid.doubtful[at] & (grid.evidence[at] >= 0)
    return np.asarray((grid.drops[at] >= DROP_AT) | doubtful, bool)
