"""What the planner sees of the map: how far obstacles are, and where the body fits."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.kernels import mapping as kernels
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import Window, inside, joined, part_frame, widened
from runtime.core.mapping.zones import TooNear
from runtime.core.types import F32, F64, Mask, Pose

MARGIN_M = 0.02  # added to the radius: cells are 5 cm wide
COMFORT_M = 0.20  # further clearance that planning pays for, without insisting on it
BEYOND_M = 0.30  # clearance beyond that is told as no more than that: nobody asks for it
SLOWEST = 0.25  # relative speed right at an obstacle
ESCAPE_M = 0.35  # around the robot, cells that are free pass as traversable
DEAD_END_M = 0.10  # around a place from which no step led on, closed from outside


@dataclass(frozen=True)
class Squeeze:
    """How far around the robot, m, free cells count as clear although they are too tight by the
    slack, m."""

    within_m: float = 0.0
    slack_m: float = 0.0


NO_SQUEEZE = Squeeze()


@dataclass(frozen=True)
class Terrain:
    """What the planner sees of the map: a window of it, (r, c) cells.

    clearance_m: distance of a cell's centre to the nearest obstacle's edge, or a zone's, up to what
    planning pays for and BEYOND_M; within a zone less than 0. traversable: the body fits. speed:
    relative, 0 where not traversable.
    """

    frame: GridFrame
    clearance_m: F32
    traversable: Mask
    speed: F32

    def around(self, pose: Pose, range_m: float) -> "Terrain":
        """A copy of what is so near: for whoever drives by it while the map goes on."""
        n = math.ceil(range_m / self.frame.resolution_m)
        row, col = self.frame.cell(pose.x_m, pose.y_m)
        held = slice(row - n, row + n + 1), slice(col - n, col + n + 1)
        window = widened(held, 0, self.frame)
        return Terrain(
            part_of(self.frame, window),
            self.clearance_m[window].copy(),
            self.traversable[window].copy(),
            self.speed[window].copy(),
        )

    def within(self, window: Window) -> "Terrain":
        """A view of a window of it, in the numbers of the whole."""
        return Terrain(
            part_frame(self.frame, window),
            self.clearance_m[window],
            self.traversable[window],
            self.speed[window],
        )


def survey(
    grid: NavigationMap, pose: Pose, radius_m: float, squeeze: Squeeze = NO_SQUEEZE
) -> Terrain:
    """The terrain of the known part of the map. Cells close to the robot stay passable even where
    the body would graze something: it is there already and must be able to leave; so do those of a
    dead end that it stands in, while others are closed."""
    return TerrainSurvey().update(grid, pose, radius_m, squeeze)


class TerrainSurvey:
    """The terrain of one map, made anew only where the map changes and where the robot is."""

    def __init__(self) -> None:
        self._frame: GridFrame | None = None
        self._revision = 0
        self._body: tuple[float, bool] = 0.0, False
        self._special: Window | None = None  # around the robot, at the last update
        self._open: tuple[TooNear, ...] = ()  # of the zones, then
        self._clearance_m: F32 = np.zeros((0, 0), np.float32)
        self._traversable: Mask = np.zeros((0, 0), bool)
        self._speed: F32 = np.zeros((0, 0), np.float32)

    def update(
        self, grid: NavigationMap, pose: Pose, radius_m: float, squeeze: Squeeze = NO_SQUEEZE
    ) -> Terrain:
        """The terrain as it is now: views of arrays that change at the next update."""
        revision, window = grid.changed_since(self._revision)
        body = radius_m, math.isinf(squeeze.within_m)
        if self._frame != grid.frame or self._body != body:
            self._frame, self._body, shape = grid.frame, body, grid.frame.shape
            self._clearance_m = np.full(shape, most_m(radius_m), np.float32)
            self._traversable, self._speed = np.zeros(shape, bool), np.zeros(shape, np.float32)
            self._special, window = None, grid.known_window()
            zones = grid.zones.about(grid.zones.zones, grid.frame)
            window = joined(zones, window)
        if window is not None:
            window = widened(window, _reach(grid.frame, radius_m), grid.frame)
        special = _near(grid.frame, pose, _special_m(grid.frame, squeeze))
        for stale in (self._special, special, self._opened(grid, pose, radius_m)):
            window = joined(window, stale) if stale is not None else window
        assert window is not None
        self._revision, self._special = revision, special
        self._derive(grid, window, pose, radius_m, squeeze)
        if grid.zones.zones:
            self._keep_out(grid, window, radius_m)
        known = grid.known_window()
        frame = part_of(grid.frame, known)
        arrays = self._clearance_m[known], self._traversable[known], self._speed[known]
        return Terrain(frame, *arrays)

    def _derive(
        self, grid: NavigationMap, window: Window, pose: Pose, radius_m: float, squeeze: Squeeze
    ) -> None:
        frame = grid.frame
        kernels.survey(
            _distance(grid, window, radius_m),
            grid.free[window],
            grid.driven[window],
            grid.dead_end[window],
            (self._clearance_m[window], self._traversable[window], self._speed[window]),
            kernels.Rules(
                frame.resolution_m,
                frame.x0_m,
                frame.y0_m,
                window[0].start,
                window[1].start,
                pose.x_m,
                pose.y_m,
                most_m(radius_m),
                radius_m + MARGIN_M,
                COMFORT_M,
                SLOWEST,
                squeeze.within_m,
                radius_m - squeeze.slack_m,
                ESCAPE_M,
                DEAD_END_M + frame.resolution_m,
            ),
        )

    def _opened(self, grid: NavigationMap, pose: Pose, radius_m: float) -> Window | None:
        """Where zones are open now, and were before: there the terrain is out of date."""
        before = self._open
        self._open = grid.zones.openings(grid.frame, pose, radius_m + MARGIN_M)
        return grid.zones.about([one.zone for one in (*before, *self._open)], grid.frame)

    def _keep_out(self, grid: NavigationMap, window: Window, radius_m: float) -> None:
        """Zones are walls; squeezing, driven ways and what is near the robot change nothing of
        that."""
        true_m, told_m = grid.zones.clearance(grid.frame, window, self._open)
        spare_m = told_m - np.float32(radius_m + MARGIN_M)
        pace = SLOWEST + (1 - SLOWEST) * np.clip(spare_m / np.float32(COMFORT_M), 0.0, 1.0)
        fits = spare_m >= 0
        for mine, zone in (
            (self._clearance_m[window], true_m),
            (self._speed[window], np.where(fits, pace, 0.0)),
        ):
            np.minimum(mine, zone, out=mine, casting="same_kind")
        self._traversable[window] &= fits


def _distance(grid: NavigationMap, window: Window, radius_m: float) -> F32:
    """(r, c) of the window: how far the middle of the nearest obstacle cell is, in cells. What is
    farther than is asked for cannot be felt in it."""
    source = widened(window, _reach(grid.frame, radius_m), grid.frame)
    bare = (~grid.occupied[source]).view(np.uint8)
    distance = cv2.distanceTransform(bare, cv2.DIST_L2, cv2.DIST_MASK_5)
    return np.asarray(distance[inside(window, source)], np.float32)


def _reach(frame: GridFrame, radius_m: float) -> int:
    """How many cells away an obstacle is felt."""
    return math.ceil(most_m(radius_m) / frame.resolution_m) + 1


def most_m(radius_m: float) -> float:
    """The most clearance that is told of."""
    return radius_m + MARGIN_M + COMFORT_M + BEYOND_M


def _special_m(frame: GridFrame, squeeze: Squeeze) -> float:
    """How far around the robot the terrain depends on where it is."""
    near_m = squeeze.within_m if math.isfinite(squeeze.within_m) else 0.0
    return max(ESCAPE_M, DEAD_END_M + frame.resolution_m, near_m)


def part_of(frame: GridFrame, window: Window) -> GridFrame:
    """The frame of a window of a grid."""
    (rows, cols), r = window, frame.resolution_m
    return GridFrame(
        frame.x0_m + (frame.first_col + cols.start) * r,
        frame.y0_m + (frame.first_row + rows.start) * r,
        r,
        rows.stop - rows.start,
        cols.stop - cols.start,
    )


def _near(frame: GridFrame, pose: Pose, radius_m: float) -> Window:
    """The window that holds the cells whose middle is within the radius of the pose."""
    n = math.ceil(min(radius_m / frame.resolution_m, sum(frame.shape))) + 1
    row, col = frame.cell(pose.x_m, pose.y_m)
    return widened((slice(row - n, row + n + 1), slice(col - n, col + n + 1)), 0, frame)


def clearance_between(terrain: Terrain, points_xy: F64) -> F64:
    """(...) m at (..., 2) m points, bilinear between the cells' centres: steps of a cell would hide
    whether the robot comes closer."""
    frame = terrain.frame
    u = (points_xy - (frame.x0_m, frame.y0_m)) / frame.resolution_m - 0.5
    low = np.floor(u).astype(np.int32)
    part = u - low
    x, y = part[..., 0], part[..., 1]
    cols, rows = low[..., 0] - frame.first_col, low[..., 1] - frame.first_row
    grid = terrain.clearance_m
    bottom = grid[rows, cols] * (1 - x) + grid[rows, cols + 1] * x
    top = grid[rows + 1, cols] * (1 - x) + grid[rows + 1, cols + 1] * x
    return np.asarray(bottom * (1 - y) + top * y, np.float64)
