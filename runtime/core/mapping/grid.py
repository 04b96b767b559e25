"""The navigation map: free, occupied and unknown cells, updated in place from depth images.

Evidence is clipped log-odds in integer steps. Floor that is seen clears a cell; a ray that merely
passes over a cell only tells unknown from free, since a level camera looks over low furniture.
"""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame, Rays, rays
from runtime.core.keys import key
from runtime.core.types import F32, F64, I32, Mask, Mount, Observation, Pose

_GAP = np.ones((5, 5), np.uint8)  # obstacle cells less than 5 cells apart are one thing
_GAP_REACH = 4  # cells, across which closing such gaps is felt

Window = tuple[slice, slice]  # of rows and of columns


RESOLUTION_M = 0.05  # side of a cell; a camera's depth is good to about as much at 5 m
SIDE_M = 24.0  # of the first grid; it grows when the robot leaves it
STRIDE = 2  # every n-th pixel of the depth image is used
FLOOR_BELOW_M = 0.07  # points under this height are floor
HIT = 4  # evidence of a frame with obstacle points in a cell
MISS = 2  # evidence of a frame that shows floor in a cell
HITS_NEEDED = 2  # obstacle points in a cell that make a hit
OCCUPIED_AT = 4  # evidence from which a cell holds an obstacle: a single hit
EVIDENCE_MAX = 20  # either way, so that what has moved away is unlearned in ten frames


@dataclass(frozen=True)
class MapConfig:
    """[map]"""

    max_depth_m: float = key(5.0, "Depth beyond this is not used.", "m", positive=True)


@dataclass
class NavigationMap:
    """Grids over one frame, rows along y and columns along x; owned by one thread.

    evidence: (R, C) int16, > 0 speaks for an obstacle, < 0 for floor. swept: (R, C) seen through
    or driven over. bumped: (R, C) obstacles met by touch, kept whatever the camera says. driven:
    (R, C) 1 where the body's centre has passed: the way back, however tight it looks later.
    dead_end: (R, C) where no step led on, whatever the clearance says: no way to plan through.
    """

    frame: GridFrame
    occupied_at: int
    evidence: NDArray[np.int16]
    swept: Mask
    bumped: Mask
    driven: NDArray[np.uint8]
    dead_end: Mask
    last_xy: tuple[float, float] | None = None
    _views: dict[str, Mask] = field(default_factory=dict, repr=False)
    _stale: Window | None = field(default=None, repr=False)  # of the views
    _known: Window | None = field(default=None, repr=False)  # that holds all known cells

    @classmethod
    def around(cls, pose: Pose, radius_m: float) -> "NavigationMap":
        """An unknown map centred on the pose, with the body's disc known to be free."""
        n = math.ceil(SIDE_M / RESOLUTION_M)
        frame = GridFrame(pose.x_m - SIDE_M / 2, pose.y_m - SIDE_M / 2, RESOLUTION_M, n, n)
        grid = cls(
            frame,
            OCCUPIED_AT,
            np.zeros((n, n), np.int16),
            np.zeros((n, n), bool),
            np.zeros((n, n), bool),
            np.zeros((n, n), np.uint8),
            np.zeros((n, n), bool),
        )
        grid.drive_over(pose, radius_m)
        return grid

    @property
    def occupied(self) -> Mask:
        """(R, C) cells that hold an obstacle."""
        return self._view("occupied")

    @property
    def free(self) -> Mask:
        """(R, C) cells known to be free."""
        return self._view("free")

    @property
    def unknown(self) -> Mask:
        """(R, C) cells that are neither."""
        return self._view("unknown")

    def _view(self, name: str) -> Mask:
        if not self._views:
            self._views = {n: np.zeros(self.frame.shape, bool) for n in ("occupied", "free")}
            self._views["unknown"] = np.ones(self.frame.shape, bool)
            self._stale, self._known = self._whole(), None
        if self._stale is not None:
            self._refresh(self._stale)
            self._stale = None
        return self._views[name]

    def _refresh(self, window: Window) -> None:
        """Derive the masks anew within a window, in arrays of their own: the earlier ones may be
        in use."""
        target = widened(window, _GAP_REACH, self.frame)
        source = widened(target, _GAP_REACH, self.frame)
        occupied = (self.evidence[source] >= self.occupied_at) | self.bumped[source]
        # What was only swept over, between obstacle cells, is the top of the same furniture.
        closed = cv2.morphologyEx(occupied.view(np.uint8), cv2.MORPH_CLOSE, _GAP) > 0
        inner = tuple(
            slice(t.start - s.start, t.stop - s.start) for t, s in zip(target, source, strict=True)
        )
        occupied, closed = occupied[inner], closed[inner]
        free = ((self.evidence[target] < 0) | (self.swept[target] & ~closed)) & ~occupied
        known = occupied | free
        for name, mask in (("occupied", occupied), ("free", free), ("unknown", ~known)):
            self._views[name] = self._views[name].copy()
            self._views[name][target] = mask
        if known.any():
            self._known = joined(self._known, _bounds(known, target))

    def _whole(self) -> Window:
        return slice(0, self.frame.rows), slice(0, self.frame.cols)

    def changed(self, window: Window | None = None) -> None:
        """The derived masks are out of date: within a window, or everywhere."""
        if window is None:
            self._views = {}
        else:
            self._stale = joined(self._stale, window)

    def known_window(self, margin: int = 4) -> Window:
        """The smallest window that holds all cells that were ever known, and a margin of cells
        around it."""
        self._view("unknown")
        return widened(self._known or self._whole(), margin, self.frame)

    def drive_over(self, pose: Pose, radius_m: float) -> None:
        """The cells under the body are free: it stands there."""
        disc, window = _disc(self.frame, pose.x_m, pose.y_m, radius_m)
        evidence = self.evidence[window]
        evidence[disc] = np.minimum(evidence[disc], -MISS)
        self.bumped[window][disc] = False
        here = self.frame.cell(pose.x_m, pose.y_m)
        near = self.last_xy and math.dist(self.last_xy, (pose.x_m, pose.y_m)) < 0.5
        before = self.frame.cell(*self.last_xy) if near and self.last_xy else here
        cv2.line(self.driven, before[::-1], here[::-1], 1, thickness=3)
        self.last_xy = pose.x_m, pose.y_m
        self.swept[window] |= disc
        self.changed(window)

    def bump(self, pose: Pose, radius_m: float) -> None:
        """A step forward was blocked: something low or thin stands just ahead of the body."""
        reach = radius_m + 1.5 * RESOLUTION_M
        for side in (-0.06, 0.0, 0.06):
            x = pose.x_m + reach * math.cos(pose.yaw_rad) - side * math.sin(pose.yaw_rad)
            y = pose.y_m + reach * math.sin(pose.yaw_rad) + side * math.cos(pose.yaw_rad)
            row, col = self.frame.cell(x, y)
            if self.frame.contains(row, col):
                self.bumped[row, col] = True
                cv2.circle(self.driven, (col, row), 5, 0, -1)  # not a way any more
        self.changed()

    def close(self, x_m: float, y_m: float, radius_m: float) -> None:
        """No step leads on there: nothing is planned through this place any more."""
        disc, window = _disc(self.frame, x_m, y_m, radius_m)
        self.dead_end[window] |= disc

    def grow(self, xy: F64, margin_m: float) -> tuple[int, int, int, int] | None:
        """Enlarge the grid so that (x, y) keeps `margin_m` to each side; existing cells keep their
        place in the map frame. Returns the padding (top, bottom, left, right), or None."""
        f, block = self.frame, 128
        row, col = f.cell(float(xy[0]), float(xy[1]))
        margin = math.ceil(margin_m / f.resolution_m)
        lack = (margin - row, row + margin - f.rows + 1, margin - col, col + margin - f.cols + 1)
        top, bottom, left, right = (math.ceil(max(0, n) / block) * block for n in lack)
        if not (top or bottom or left or right):
            return None
        pad = ((top, bottom), (left, right))
        self.evidence = np.pad(self.evidence, pad)
        self.swept, self.bumped = np.pad(self.swept, pad), np.pad(self.bumped, pad)
        self.driven, self.dead_end = np.pad(self.driven, pad), np.pad(self.dead_end, pad)
        self.frame = GridFrame(
            f.x0_m - left * f.resolution_m,
            f.y0_m - top * f.resolution_m,
            f.resolution_m,
            *self.evidence.shape,
        )
        self.changed()
        return top, bottom, left, right


def integrate(
    grid: NavigationMap,
    obs: Observation,
    mount: Mount,
    radius_m: float,
    height_m: float,
    max_depth_m: float,
) -> F64:
    """Add one depth image, for a body of that radius and height. Returns the view's outline,
    (V, 2) m in the map frame: the camera and the free range along each azimuth. The grid must
    already reach as far as the camera sees."""
    table, half = rays(obs.intrinsics, mount, STRIDE), STRIDE // 2
    depth = np.ascontiguousarray(obs.depth_m[half::STRIDE, half::STRIDE])
    depth = np.where((depth > 0) & (depth <= max_depth_m), depth, np.float32(0))
    height = depth * table.up + np.float32(mount.z_m)
    valid = depth > 0
    floor = valid & (np.abs(height) < FLOOR_BELOW_M)
    obstacle = valid & (height >= FLOOR_BELOW_M) & (height <= height_m)
    outline = _outline(table, depth * table.reach, floor, obstacle, obs.pose, mount)
    cells, window = _cells(grid.frame, depth * table.forward, depth * table.left, obs.pose, mount)
    _count(grid, window, cells.ravel()[floor.ravel()], cells.ravel()[obstacle.ravel()])
    _sweep(grid, outline)
    grid.drive_over(obs.pose, radius_m)
    return outline


def _cells(
    frame: GridFrame, forward: F32, left: F32, pose: Pose, mount: Mount
) -> tuple[I32, Window]:
    """Points in the base frame (without the mount's offset), m -> the window of the grid that holds
    them all, and their flat indices in it."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    ox = pose.x_m + c * mount.x_m - s * mount.y_m - frame.x0_m
    oy = pose.y_m + s * mount.x_m + c * mount.y_m - frame.y0_m
    r = 1.0 / frame.resolution_m
    col = ((np.float32(c) * forward - np.float32(s) * left + np.float32(ox)) * r).astype(np.int32)
    row = ((np.float32(s) * forward + np.float32(c) * left + np.float32(oy)) * r).astype(np.int32)
    low, high = (int(row.min()), int(col.min())), (int(row.max()), int(col.max()))
    if min(low) < 0 or high[0] >= frame.rows or high[1] >= frame.cols:
        row, col = np.clip(row, 0, frame.rows - 1), np.clip(col, 0, frame.cols - 1)
        low, high = (int(row.min()), int(col.min())), (int(row.max()), int(col.max()))
    window = slice(low[0], high[0] + 1), slice(low[1], high[1] + 1)
    width = np.int32(high[1] + 1 - low[1])
    return (row - np.int32(low[0])) * width + (col - np.int32(low[1])), window


def _count(grid: NavigationMap, window: Window, floor: I32, obstacle: I32) -> None:
    """Book what was seen in cells of the window, by their flat indices in it."""
    evidence = grid.evidence[window]
    flat = evidence.ravel()
    hits = np.bincount(obstacle, minlength=flat.size)
    hit = np.flatnonzero(hits >= HITS_NEEDED)
    flat[hit] = np.minimum(flat[hit] + HIT, EVIDENCE_MAX)
    seen = np.zeros(flat.size, bool)
    seen[floor] = True
    seen[obstacle] = False
    miss = np.flatnonzero(seen)
    flat[miss] = np.maximum(flat[miss] - MISS, -EVIDENCE_MAX)
    evidence[:] = flat.reshape(evidence.shape)
    grid.changed(window)


def _outline(
    table: Rays, distance: F32, floor: Mask, obstacle: Mask, pose: Pose, mount: Mount
) -> F64:
    """The free range along each azimuth: up to the first obstacle, and no further than floor was
    seen; as a closed polygon from the camera, (V, 2) m in the map frame."""
    order, starts = table.order, table.starts
    near, far = np.where(obstacle, distance, np.inf), np.where(floor, distance, 0.0)
    by_group = (near.min(axis=0), far.max(axis=0)) if table.level else (near.ravel(), far.ravel())
    wall = np.minimum.reduceat(by_group[0][order], starts)
    ground = np.maximum.reduceat(by_group[1][order], starts)
    reach = np.where(np.isfinite(wall), wall, ground)
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    x0 = pose.x_m + c * mount.x_m - s * mount.y_m
    y0 = pose.y_m + s * mount.x_m + c * mount.y_m
    azimuth = table.azimuths + pose.yaw_rad
    rim = np.stack([x0 + reach * np.cos(azimuth), y0 + reach * np.sin(azimuth)], axis=1)
    return np.concatenate([[[x0, y0]], rim])


def _sweep(grid: NavigationMap, outline: F64) -> None:
    mask, window = polygon_patch(grid.frame, outline)
    grid.swept[window] |= mask
    grid.changed(window)


def polygon_mask(frame: GridFrame, outline: F64) -> Mask:
    """(V, 2) m in the map frame -> (R, C) cells inside the polygon."""
    mask = np.zeros(frame.shape, bool)
    patch, window = polygon_patch(frame, outline)
    mask[window] = patch
    return mask


def polygon_patch(frame: GridFrame, outline: F64) -> tuple[Mask, Window]:
    """(V, 2) m in the map frame -> the window that holds the polygon, and the cells of it that are
    inside the polygon."""
    shift = 4  # sub-cell precision of fillPoly, bits
    scaled = ((outline - (frame.x0_m, frame.y0_m)) / frame.resolution_m - 0.5) * (1 << shift)
    points = np.round(scaled).astype(np.int32)
    (x0, y0), (x1, y1) = points.min(axis=0) >> shift, points.max(axis=0) >> shift
    held = slice(max(0, int(y0) - 1), int(y1) + 3), slice(max(0, int(x0) - 1), int(x1) + 3)
    window = widened(held, 0, frame)
    corner = np.array([window[1].start, window[0].start], np.int32) << shift
    size = (window[0].stop - window[0].start, window[1].stop - window[1].start)
    patch = np.zeros(size, np.uint8)
    if patch.size:
        cv2.fillPoly(patch, [points - corner], 1, shift=shift)
    return patch.view(bool), window


def widened(window: Window, margin: int, frame: GridFrame) -> Window:
    """The window and so many cells around it, as far as the grid reaches."""

    def clipped(part: slice, size: int) -> slice:
        start = min(max(0, part.start - margin), size)
        return slice(start, max(start, min(size, part.stop + margin)))

    return clipped(window[0], frame.rows), clipped(window[1], frame.cols)


def joined(a: Window | None, b: Window) -> Window:
    """The smallest window that holds both."""
    if a is None:
        return b
    rows = slice(min(a[0].start, b[0].start), max(a[0].stop, b[0].stop))
    return rows, slice(min(a[1].start, b[1].start), max(a[1].stop, b[1].stop))


def _bounds(mask: Mask, window: Window) -> Window:
    """The part of the window where the mask (of its size) holds anything."""
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    r, c = window[0].start, window[1].start
    return (
        slice(r + int(rows[0]), r + int(rows[-1]) + 1),
        slice(c + int(cols[0]), c + int(cols[-1]) + 1),
    )


def _disc(frame: GridFrame, x_m: float, y_m: float, radius_m: float) -> tuple[Mask, Window]:
    """The window of the grid around the point, and the cells of it whose centre is within the
    radius."""
    n = math.ceil(radius_m / frame.resolution_m)
    row, col = frame.cell(x_m, y_m)
    window = widened((slice(row - n, row + n + 1), slice(col - n, col + n + 1)), 0, frame)
    r, c = np.mgrid[window]
    xy = frame.centres(np.stack([r, c], axis=-1).astype(np.int32))
    return np.hypot(xy[..., 0] - x_m, xy[..., 1] - y_m) <= radius_m, window
