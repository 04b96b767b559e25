"""Planning by fast marching: arrival times over free space, and the path down them."""

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import skfmm

from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import NavigationMap, Window, widened
from runtime.core.types import F32, F64, I32, Mask, Pose

_BEYOND_M = 0.75  # of arrival beyond the robot's own, that choosing its next step may look at
_WINDING = 1.25  # arrival for distance, as it mostly is


MARGIN_M = 0.02  # added to the radius: cells are 5 cm wide
COMFORT_M = 0.20  # further clearance that planning pays for, without insisting on it
SLOWEST = 0.25  # relative speed right at an obstacle
ESCAPE_M = 0.35  # around the robot, cells that are free pass as traversable
DEAD_END_M = 0.10  # around a place from which no step led on, closed from outside
POCKET_M2 = 1.5  # a robot that can reach no more than this is wedged
SQUEEZE_M = (0.7, 1.2)  # around a wedged robot, the second where the first does not help:
SQUEEZE_SLACK_M = 0.07  # gaps may be this much too tight: maps err by a cell
RESORT_SLACK_M = 0.04  # the same everywhere, when else nothing is left to go to


@dataclass(frozen=True)
class Terrain:
    """What the planner sees of the map: a window of it, (r, c) cells.

    clearance_m: distance of a cell's centre to the nearest obstacle's edge. traversable: the body
    fits. speed: relative, 0 where not traversable.
    """

    frame: GridFrame
    clearance_m: F32
    traversable: Mask
    speed: F32

    @cached_property
    def parts(self) -> I32:
        """(r, c) the 4-connected parts of what is traversable, numbered from 1; 0 elsewhere."""
        _, labels = cv2.connectedComponents(self.traversable.view(np.uint8), connectivity=4)
        return np.asarray(labels, np.int32)


@dataclass(frozen=True)
class Field:
    """Arrival times from a set of cells: metres of unhurried driving; inf where none leads."""

    frame: GridFrame
    arrival_m: F64

    def at(self, x_m: float, y_m: float) -> float:
        """Arrival time of the cell that holds the point; inf outside."""
        row, col = self.frame.cell(x_m, y_m)
        return float(self.arrival_m[row, col]) if self.frame.contains(row, col) else math.inf


def look_around(
    grid: NavigationMap, pose: Pose, radius_m: float, tight: bool = False
) -> tuple[Terrain, Field]:
    """The terrain, and the geodesic distance from the robot. A wedged robot, to which nearly
    nothing is reachable, is let through gaps close to it that look a little too tight; with `tight`
    through such gaps everywhere."""
    everywhere = math.inf, RESORT_SLACK_M
    terrain = survey(grid, pose, radius_m, *(everywhere if tight else ()))
    reach = march_from(terrain, pose.xy, unhurried=False)
    for squeeze_m in SQUEEZE_M:
        cells = int(np.isfinite(reach.arrival_m).sum())
        small = cells * terrain.frame.resolution_m**2 < POCKET_M2
        if not small or 3 * cells > int(terrain.traversable.sum()):
            break
        terrain = survey(grid, pose, radius_m, squeeze_m, SQUEEZE_SLACK_M)
        reach = march_from(terrain, pose.xy, unhurried=False)
    return terrain, reach


def survey(
    grid: NavigationMap, pose: Pose, radius_m: float,
    squeeze_m: float = 0.0, slack_m: float = 0.0,
) -> Terrain:  # fmt: skip
    """The terrain of the known part of the map. Cells close to the robot stay passable even where
    the body would graze something: it is there already and must be able to leave; so do those of a
    dead end that it stands in, while others are closed. Within
    `squeeze_m` free cells count as clear although they are too tight by `slack_m`."""
    rows, cols = grid.known_window()
    r, f = grid.frame.resolution_m, grid.frame
    frame = GridFrame(
        f.x0_m + cols.start * r,
        f.y0_m + rows.start * r,
        r,
        rows.stop - rows.start,
        cols.stop - cols.start,
    )
    free, occupied = grid.free[rows, cols], grid.occupied[rows, cols]
    distance = cv2.distanceTransform((~occupied).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    clearance = np.minimum(distance * np.float32(r) - np.float32(r / 2), np.float32(10.0))
    hard = radius_m + MARGIN_M
    proven = free & (grid.driven[rows, cols] > 0)
    np.maximum(clearance, np.float32(hard), out=clearance, where=proven)
    if squeeze_m > 0:
        window, near = _near(frame, pose, squeeze_m)
        patch = clearance[window]
        tight = near & free[window] & (patch >= radius_m - slack_m)
        np.maximum(patch, np.float32(hard), out=patch, where=tight)
    passable = free & (clearance >= hard)
    window, near = _near(frame, pose, ESCAPE_M)
    passable[window] |= near & free[window]
    passable &= ~grid.dead_end[rows, cols]
    window, near = _near(frame, pose, DEAD_END_M + frame.resolution_m)
    passable[window] |= near & free[window]
    ease = np.clip((clearance - hard) / COMFORT_M, 0.0, 1.0)
    speed = np.float32(SLOWEST) + np.float32(1 - SLOWEST) * ease
    speed[~passable] = 0
    return Terrain(frame, clearance, passable, speed)


def march(terrain: Terrain, sources: Mask, unhurried: bool = True, limit_m: float = 0.0) -> Field:
    """Arrival times from the source cells, (r, c). With `unhurried` closeness to obstacles costs;
    without, the field is the geodesic distance. What is farther than a `limit_m` is left at inf."""
    arrival = np.full(terrain.frame.shape, np.inf)
    seeds = sources & terrain.traversable
    if not seeds.any():
        return Field(terrain.frame, arrival)
    inside = _connected(terrain.parts, seeds)
    if (inside & ~seeds).any():
        rows, cols = _window(inside)
        # skfmm reads the arrays' memory: a view of a larger array would be misread
        phi = np.ma.MaskedArray(
            np.where(seeds[rows, cols], -1.0, 1.0),
            mask=np.ascontiguousarray(~inside[rows, cols]),
        )
        dx = terrain.frame.resolution_m
        if unhurried:
            times = skfmm.travel_time(
                phi, np.array(terrain.speed[rows, cols], np.float64), dx=dx, narrow=limit_m
            )
        else:
            times = skfmm.distance(phi, dx=dx, narrow=limit_m)
        arrival[rows, cols] = np.where(np.ma.getmaskarray(times), np.inf, np.abs(times.data))
    arrival[seeds] = 0.0
    return Field(terrain.frame, arrival)


def approach(terrain: Terrain, sources: Mask, reach: Field, pose: Pose) -> Field:
    """`march` no further from the sources than the robot is and what it can step to: `reach`, the
    distances from the robot, tell about where to end."""
    there = reach.arrival_m[sources]
    away = float(there.min(initial=math.inf))
    if math.isfinite(away):
        limit_m = _WINDING * away + 2 * _BEYOND_M
        field = march(terrain, sources, limit_m=limit_m)
        if field.at(pose.x_m, pose.y_m) + _BEYOND_M <= limit_m:
            return field
    return march(terrain, sources)


def cells_at(terrain: Terrain, xy: tuple[float, float]) -> Mask:
    """(r, c) the one cell that holds the point; none outside."""
    cells, (row, col) = np.zeros(terrain.frame.shape, bool), terrain.frame.cell(*xy)
    if terrain.frame.contains(row, col):
        cells[row, col] = True
    return cells


def march_from(terrain: Terrain, points_xy: F64, unhurried: bool = True) -> Field:
    """`march` from (N, 2) m points in the map frame; those outside the window are dropped."""
    cells = terrain.frame.cells(np.atleast_2d(points_xy))
    inside = ((cells >= 0) & (cells < terrain.frame.shape)).all(axis=1)
    sources = np.zeros(terrain.frame.shape, bool)
    sources[tuple(cells[inside].T)] = True
    return march(terrain, sources, unhurried)


def descend(field: Field, start_xy: tuple[float, float], limit: int = 4000) -> F64:
    """The path from a point down to the field's sources, (N, 2) m, cell by cell; (0, 2) if none."""
    frame, arrival = field.frame, field.arrival_m
    row, col = frame.cell(*start_xy)
    if not frame.contains(row, col) or not np.isfinite(arrival[row, col]):
        return np.zeros((0, 2))
    path: list[tuple[int, int]] = [(row, col)]
    for _ in range(limit):
        if arrival[row, col] <= 0:
            break
        r0, c0 = max(0, row - 1), max(0, col - 1)
        around = arrival[r0 : row + 2, c0 : col + 2]
        dr, dc = divmod(int(np.argmin(around)), around.shape[1])
        if around[dr, dc] >= arrival[row, col]:
            break
        row, col = r0 + dr, c0 + dc
        path.append((row, col))
    cells: I32 = np.array(path, np.int32)
    return frame.centres(cells)


def _connected(parts: I32, seeds: Mask) -> Mask:
    """Those of the numbered parts that hold a seed."""
    wanted = np.zeros(int(parts.max()) + 1, bool)
    wanted[parts[seeds]] = True
    wanted[0] = False
    part: Mask = wanted[parts]
    return part


def _window(mask: Mask) -> tuple[slice, slice]:
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(cols[0]), int(cols[-1]) + 1)


def _near(frame: GridFrame, pose: Pose, radius_m: float) -> tuple[Window, Mask]:
    """The window around the pose, and the cells of it whose centre is within the radius."""
    n = math.ceil(min(radius_m / frame.resolution_m, sum(frame.shape))) + 1
    row, col = frame.cell(pose.x_m, pose.y_m)
    window = widened((slice(row - n, row + n + 1), slice(col - n, col + n + 1)), 0, frame)
    rows, cols = np.ogrid[window]
    x = frame.x0_m + (cols + 0.5) * frame.resolution_m - pose.x_m
    y = frame.y0_m + (rows + 0.5) * frame.resolution_m - pose.y_m
    near: Mask = np.hypot(x, y) <= radius_m
    return window, near


def clearance_between(terrain: Terrain, points_xy: F64) -> F64:
    """(...) m at (..., 2) m points, bilinear between the cells' centres: steps of a cell would hide
    whether the robot comes closer."""
    frame = terrain.frame
    u = (points_xy - (frame.x0_m, frame.y0_m)) / frame.resolution_m - 0.5
    low = np.floor(u).astype(np.int32)
    part = u - low
    cols, rows, x, y = low[..., 0], low[..., 1], part[..., 0], part[..., 1]
    grid = terrain.clearance_m
    bottom = grid[rows, cols] * (1 - x) + grid[rows, cols + 1] * x
    top = grid[rows + 1, cols] * (1 - x) + grid[rows + 1, cols + 1] * x
    return np.asarray(bottom * (1 - y) + top * y, np.float64)
