"""The navigation map: free, occupied and unknown cells, updated in place from depth images.

Evidence is clipped log-odds in integer steps. Floor that is seen clears a cell; a ray that merely
passes over a cell only tells unknown from free, since a level camera looks over low furniture.
Where depth is missing below what was seen, something may stand that gave none: no ray passes.
What is seen through at the heights at which it stood has gone: see `seen_through.py`.
What is seen below the floor tells that there is none where its ray crosses it: a drop, which is an
obstacle to a robot, and which no ray through the air clears.
"""

import math
from collections import deque
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame, camera_at, rays
from runtime.core.kernels import mapping as kernels
from runtime.core.keys import key
from runtime.core.mapping import drops
from runtime.core.mapping.drops import Openings
from runtime.core.mapping.laser_layer import LaserLayer
from runtime.core.mapping.seen_through import unlearn
from runtime.core.mapping.windows import (
    Window,
    between,
    disc_window,
    ends,
    fan,
    joined,
    padded,
    part_frame,
    polygon_patch,
    widened,
)
from runtime.core.mapping.zones import ZoneLayer
from runtime.core.types import F64, U8, Mask, Mount, Observation, Pose

_GAP_REACH = 4  # cells, across which it is felt that gaps between obstacles are closed

RESOLUTION_M = 0.05  # side of a cell; a camera's depth is good to about as much at 5 m
SIDE_M = 24.0  # of the first grid; it grows when the robot leaves it
STRIDE = 2  # every n-th pixel of the depth image is used
FLOOR_BELOW_M = 0.07  # points under this height are floor
HOLE_RAD = 0.015  # of unknown depth from low to high that may hide something; less is noise
HIT = 4  # evidence of a frame with obstacle points in a cell
MISS = 2  # evidence of a frame that shows floor in a cell
HITS_NEEDED = 2  # obstacle points in a cell that make a hit
OCCUPIED_AT = 4  # evidence from which a cell holds an obstacle: a single hit
CHANGES_KEPT = 64  # windows; who asks for older ones looks at the whole map
EVIDENCE_MAX = 20  # either way, so that what has moved away is unlearned in ten frames
FOOTING = 0.5  # of the body's radius: what of it certainly stands on floor
_WEIGHTS = kernels.Weights(HITS_NEEDED, HIT, MISS, EVIDENCE_MAX, drops.DROP_MOST)


@dataclass(frozen=True)
class MapConfig:
    """[map]"""

    max_depth_m: float = key(5.0, "Depth beyond this is not used.", "m", within=(0.3, 20.0))


@dataclass(frozen=True)
class MapCopy:
    """The masks of a window of a map as they were at one moment, (r, c)."""

    frame: GridFrame
    occupied: Mask
    free: Mask
    unknown: Mask


@dataclass
class NavigationMap:
    """Grids over one frame, rows along y and columns along x; owned by one thread.

    evidence: (R, C) int16, > 0 speaks for an obstacle, < 0 for floor. swept: (R, C) seen through
    or driven over. bumped: (R, C) obstacles met by touch, kept whatever the camera says. driven:
    (R, C) 1 where the body's centre has passed: the way back, however tight it looks later.
    dead_end: (R, C) where no step led on, whatever the clearance says: no way to plan through.
    drops: (R, C) frames that showed a cell to have no floor, less those that showed some. backed:
    (R, C) swept by rays along whose azimuth floor was seen there or beyond. doubtful: (R, C) where
    sweeping tells nothing, as floor drops close by. stood: (R, C) at which heights something was
    seen where evidence speaks for an obstacle. began_xy: the floor round there may never have been
    in view; None once the robot has left it.
    """

    frame: GridFrame
    occupied_at: int
    evidence: NDArray[np.int16]
    swept: Mask
    bumped: Mask
    driven: NDArray[np.uint8]
    dead_end: Mask
    drops: U8
    backed: Mask
    doubtful: Mask
    stood: U8
    began_xy: tuple[float, float] | None = None
    openings: Openings = field(default_factory=Openings, repr=False)
    last_xy: tuple[float, float] | None = None
    laser: LaserLayer = field(default_factory=LaserLayer, repr=False)
    zones: ZoneLayer = field(default_factory=ZoneLayer, repr=False)  # no part of the masks
    _views: dict[str, Mask] = field(default_factory=dict, repr=False)
    _stale: Window | None = field(default=None, repr=False)  # of the views
    _known: Window | None = field(default=None, repr=False)  # that holds all known cells
    _changes: deque[Window] = field(default_factory=lambda: deque(maxlen=CHANGES_KEPT), repr=False)
    _count: int = 0  # of changes ever

    @classmethod
    def around(cls, pose: Pose, radius_m: float) -> "NavigationMap":
        """An unknown map centred on the pose, with the body's disc known to be free."""
        n = math.ceil(SIDE_M / RESOLUTION_M)
        frame = GridFrame(pose.x_m - SIDE_M / 2, pose.y_m - SIDE_M / 2, RESOLUTION_M, n, n)
        evidence, shape = np.zeros((n, n), np.int16), (n, n)
        swept, bumped, dead_end, backed, doubtful = np.zeros((5, *shape), bool)
        driven, fell, stood = np.zeros((3, *shape), np.uint8)
        began_xy = pose.x_m, pose.y_m
        grid = cls(
            frame, OCCUPIED_AT, evidence, swept, bumped, driven, dead_end, fell, backed, doubtful,
            stood, began_xy,
        )  # fmt: skip
        grid.drive_over(pose, radius_m)
        return grid

    @property
    def occupied(self) -> Mask:
        """(R, C) cells that hold an obstacle, or no floor. This and the next two are updated in
        place: whoever needs them as they are now takes a copy."""
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
            self.touched(self._stale)
        if self._stale is not None:
            self._refresh(self._stale)
            self._stale = None
        return self._views[name]

    def _refresh(self, window: Window) -> None:
        """Derive the masks anew within a window, and book where they changed."""
        felt = widened(window, 2 * _GAP_REACH, self.frame)
        changed, known = kernels.derive(
            self.evidence,
            self.drops,
            self.laser.bar(felt, self.bumped),
            self.swept,
            self.openings.barred(self.doubtful),
            (self._views["occupied"], self._views["free"], self._views["unknown"]),
            self.occupied_at,
            drops.DROP_AT,
            ends(widened(window, _GAP_REACH, self.frame)),
        )
        if known:
            self._known = joined(self._known, between(known))
        if changed:
            self.touched(between(changed))

    def _whole(self) -> Window:
        return slice(0, self.frame.rows), slice(0, self.frame.cols)

    def changed(self, window: Window | None = None) -> None:
        """The derived masks are out of date: within a window, or everywhere."""
        if window is None:
            self._views = {}
        else:
            self._stale = joined(self._stale, window)

    def touched(self, window: Window) -> None:
        """What is derived of the map is out of date within a window, though the masks are not."""
        self._changes.append(window)
        self._count += 1

    def changed_since(self, revision: int) -> tuple[int, Window | None]:
        """The revision of the map as it is now, and the window of what changed since an earlier
        one, None for nothing."""
        self._view("unknown")
        new = self._count - revision
        if new > len(self._changes):
            return self._count, self._whole()
        window: Window | None = None
        for n in range(new):
            window = joined(window, self._changes[-1 - n])
        return self._count, window

    def known_window(self, margin: int = 4) -> Window:
        """The smallest window that holds all cells that were ever known, and a margin of cells
        around it."""
        self._view("unknown")
        return widened(self._known or self._whole(), margin, self.frame)

    def copied(self, window: Window) -> MapCopy:
        """The masks within a window, which nobody changes any more."""
        masks = (self._view(name)[window].copy() for name in ("occupied", "free", "unknown"))
        return MapCopy(part_frame(self.frame, window), *masks)

    def drive_over(self, pose: Pose, radius_m: float) -> None:
        """The cells under the body are free: it stands there. Near a drop those of its feet."""
        disc, window = disc_window(self.frame, pose.x_m, pose.y_m, radius_m)
        if self.drops[window].any() or self.doubtful[window].any():
            disc, window = disc_window(self.frame, pose.x_m, pose.y_m, FOOTING * radius_m)
            self.drops[window][disc] = 0
        evidence = self.evidence[window]
        evidence[disc] = np.minimum(evidence[disc], -MISS)
        self.bumped[window][disc] = False
        self.laser.clear(window, disc)
        here = self.frame.cell(pose.x_m, pose.y_m)
        near = self.last_xy and math.dist(self.last_xy, (pose.x_m, pose.y_m)) < 0.5
        before = self.frame.cell(*self.last_xy) if near and self.last_xy else here
        self._drive(before, here)
        self.last_xy = pose.x_m, pose.y_m
        self.swept[window] |= disc
        self.changed(window)

    def _drive(self, before: tuple[int, int], here: tuple[int, int]) -> None:
        """The way between two cells was driven."""
        rows, cols = (slice(min(ends), max(ends) + 1) for ends in zip(before, here, strict=True))
        window = widened((rows, cols), 3, self.frame)  # the line is three cells thick
        count = np.count_nonzero(self.driven[window])
        cv2.line(self.driven, before[::-1], here[::-1], 1, thickness=3)
        if np.count_nonzero(self.driven[window]) > count:
            self.touched(window)

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
                near = widened((slice(row, row + 1), slice(col, col + 1)), 6, self.frame)
                self.changed(near)
                self.touched(near)

    def close(self, x_m: float, y_m: float, radius_m: float) -> None:
        """No step leads on there: nothing is planned through this place any more."""
        disc, window = disc_window(self.frame, x_m, y_m, radius_m)
        self.dead_end[window] |= disc
        self.touched(window)

    def reopen(self) -> None:
        """Dead ends are tried again."""
        self.dead_end[:] = False
        self.touched(self._whole())

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
        pad = top, bottom, left, right
        self.evidence = padded(self.evidence, pad)
        self.swept, self.bumped = padded(self.swept, pad), padded(self.bumped, pad)
        self.driven, self.dead_end = padded(self.driven, pad), padded(self.dead_end, pad)
        self.drops, self.backed = padded(self.drops, pad), padded(self.backed, pad)
        self.doubtful, self.stood = padded(self.doubtful, pad), padded(self.stood, pad)
        self.laser.grow(pad)
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
    (V, 2) m in the map frame: the camera and the free range along each azimuth, which ends where
    the floor does. The grid must already reach as far as the camera sees."""
    table, frame = rays(obs.intrinsics, mount, STRIDE), grid.frame
    (x0, y0), facing = camera_at(obs.pose, mount)
    view = kernels.DepthView(
        STRIDE, max_depth_m, mount.z_m, FLOOR_BELOW_M, height_m, *facing,
        x0 - frame.x0_m, y0 - frame.y0_m, 1.0 / frame.resolution_m,
        drops.SLACK, drops.LIP_M, drops.DROP_WITHIN_M,
    )  # fmt: skip
    cells_around = math.ceil(max_depth_m * table.farthest / frame.resolution_m) + 2
    (reach, floor, opening), seen, dropped = kernels.integrate(
        grid.evidence,
        grid.drops,
        np.ascontiguousarray(obs.depth_m),
        (table.forward, table.left, table.up, table.reach),
        table.groups,
        len(table.azimuths),
        view,
        _WEIGHTS,
        cells_around,
        max(2, round(HOLE_RAD * obs.intrinsics.fy / STRIDE)),
    )
    gone = unlearn(grid.evidence, grid.stood, frame, obs, mount, max_depth_m, cells_around, MISS)
    for window in filter(None, (seen and between(seen), gone)):
        grid.changed(window)
    azimuth = table.azimuths + obs.pose.yaw_rad
    outline = fan((x0, y0), azimuth, reach)
    _sweep(grid, outline, fan((x0, y0), azimuth, floor))
    if dropped:
        _lose_way(grid, between(dropped), radius_m)
    doubt = grid.openings.doubt(grid.doubtful, frame, (x0, y0), azimuth, opening)
    if doubt:
        drops.disbelieve(grid.evidence[doubt], grid.doubtful[doubt], grid.driven[doubt], MISS)
        grid.changed(doubt)
    grid.drive_over(obs.pose, radius_m)
    return outline


def _sweep(grid: NavigationMap, outline: F64, floor: F64) -> None:
    mask, window = polygon_patch(grid.frame, outline)
    grid.swept[window] |= mask
    grid.changed(window)
    mask, window = polygon_patch(grid.frame, floor)
    grid.backed[window] |= mask


def _lose_way(grid: NavigationMap, window: Window, radius_m: float) -> None:
    near = math.ceil(radius_m / grid.frame.resolution_m) + 1
    window = widened(window, near, grid.frame)
    if drops.lose_way(grid.driven[window], grid.drops[window], near):
        grid.touched(window)
