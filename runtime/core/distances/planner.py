"""Planning by fast marching: arrival times over free space, and the path down them."""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
import skfmm
from numpy.typing import NDArray

from runtime.core.distances.terrain import (
    NO_SQUEEZE,
    Squeeze,
    Terrain,
    TerrainSurvey,
    coarser,
    pooled,
)
from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import Window, inside, joined, widened
from runtime.core.types import F64, I32, Mask, Pose

_FILL = 4 | cv2.FLOODFILL_MASK_ONLY | (1 << 8)  # four neighbours; ones in the mask
_BEYOND_M = 0.75  # of arrival beyond the robot's own, that choosing its next step may look at
_WINDING = 1.25  # arrival for distance, as it mostly is
_FAR_M = 10.0
LARGE_CELLS = 150_000  # that can be reached: more than any home has
COARSE = 5  # cells to a side of a larger one
CORRIDOR_M = 1.0  # to each side of the way
DETOUR, CORNER_M = 1.02, 0.2  # by so much may it be slower than what was guessed
AROUND_M = 3.5  # told beyond what can be reached: more than a course takes along
FIRST_CELLS = 128  # to each side of the robot, where what it can reach is looked for first

POCKET_M2 = 1.5  # a robot that can reach no more than this is wedged
SQUEEZE_M = (0.7, 1.2)  # around a wedged robot, the second where the first does not help:
SQUEEZE_SLACK_M = 0.07  # gaps may be this much too tight: maps err by a cell
RESORT_SLACK_M = 0.04  # the same everywhere, when else nothing is left to go to


@dataclass(frozen=True)
class Field:
    """Arrival times from a set of cells: metres of unhurried driving; inf where none leads."""

    frame: GridFrame
    arrival_m: F64

    def at(self, x_m: float, y_m: float) -> float:
        """Arrival time of the cell that holds the point; inf outside."""
        row, col = self.frame.cell(x_m, y_m)
        return float(self.arrival_m[row, col]) if self.frame.contains(row, col) else math.inf

    def of(self, cells: I32) -> F64:
        """(..., 2) row, col -> (...) arrival times; inf outside."""
        inside = ((cells >= 0) & (cells < self.frame.shape)).all(axis=-1)
        found = np.full(inside.shape, np.inf)
        found[inside] = self.arrival_m[cells[inside, 0], cells[inside, 1]]
        return found

    def part(self, window: Window) -> F64:
        """The arrival times of a window, which may reach beyond; inf there."""
        (rows, cols), known = window, widened(window, 0, self.frame)
        found = np.full((rows.stop - rows.start, cols.stop - cols.start), np.inf)
        found[inside(known, window)] = self.arrival_m[known]
        return found


def look_around(
    grid: NavigationMap, pose: Pose, radius_m: float, tight: bool = False,
    known: TerrainSurvey | None = None,
) -> tuple[Terrain, Field]:  # fmt: skip
    """The terrain as far as the robot can get, and AROUND_M about it, and the geodesic distance
    from the robot. A wedged robot, to which nearly nothing is reachable, is let through gaps close
    to it that look a little too tight; with `tight` through such gaps everywhere. `known` is what
    was surveyed of this map before."""
    survey, everywhere = known or TerrainSurvey(), Squeeze(math.inf, RESORT_SLACK_M)
    terrain = survey.update(grid, pose, radius_m, everywhere if tight else NO_SQUEEZE)
    near, reach = _reach(terrain, pose)
    for squeeze_m in SQUEEZE_M:
        cells = int(np.isfinite(reach.arrival_m).sum())
        small = cells * terrain.frame.resolution_m**2 < POCKET_M2
        if not small or 3 * cells > int(terrain.traversable.sum()):
            break
        terrain = survey.update(grid, pose, radius_m, Squeeze(squeeze_m, SQUEEZE_SLACK_M))
        near, reach = _reach(terrain, pose)
    return near, reach


def _reach(terrain: Terrain, pose: Pose) -> tuple[Terrain, Field]:
    """The part of the terrain that is reachable, and AROUND_M about it, with the distances from the
    robot; all of it where the robot stands on no cell that its body fits."""
    frame, start = terrain.frame, terrain.frame.cell(pose.x_m, pose.y_m)
    if frame.contains(*start) and terrain.traversable[start]:
        held = _reachable(terrain, start)
        terrain = terrain.within(widened(held, round(AROUND_M / frame.resolution_m), frame))
    return terrain, march_from(terrain, pose.xy, unhurried=False)


def _reachable(terrain: Terrain, start: tuple[int, int]) -> Window:
    """The window of all that a traversable cell is connected with. Looked for near by first, in
    ever larger squares: to fill a mask writes along all its edges."""
    (row, col), frame, side = start, terrain.frame, FIRST_CELLS
    here = slice(row, row + 1), slice(col, col + 1)
    while True:
        near = widened(here, side, frame)
        seeds = np.array([[row - near[0].start, col - near[1].start]])
        _, (rows, cols) = _connected(terrain.traversable[near], seeds)
        top, left = near[0].start, near[1].start
        held = (
            slice(rows.start + top, rows.stop + top),
            slice(cols.start + left, cols.stop + left),
        )
        if joined(near, widened(held, 1, frame)) == near:  # it goes on nowhere beyond
            return held
        side *= 2


def march(terrain: Terrain, sources: Mask, unhurried: bool = True, limit_m: float = 0.0) -> Field:
    """Arrival times from the source cells, (r, c). With `unhurried` closeness to obstacles costs;
    without, the field is the geodesic distance. What is farther than a `limit_m` is left at inf."""
    arrival = np.full(terrain.frame.shape, np.inf)
    seeds = sources & terrain.traversable
    if not seeds.any():
        return Field(terrain.frame, arrival)
    inside, (rows, cols) = _connected(terrain.traversable, np.argwhere(seeds))
    if (inside & ~seeds[rows, cols]).any():
        # skfmm reads the arrays' memory: a view of a larger array would be misread
        phi = np.ma.MaskedArray(
            np.where(seeds[rows, cols], -1.0, 1.0),
            mask=~inside,
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
    distances from the robot, tell about where to end. A far way through a hall larger than homes
    are is marched along a corridor alone, where that is surely no detour."""
    there = reach.arrival_m[sources]
    away = float(there.min(initial=math.inf))
    if math.isfinite(away):
        large = away > _FAR_M and np.count_nonzero(np.isfinite(reach.arrival_m)) > LARGE_CELLS
        if large and (along := _along_corridor(terrain, sources, pose)):
            return along
        limit_m = _WINDING * away + 2 * _BEYOND_M
        field = march(terrain, sources, limit_m=limit_m)
        if field.at(pose.x_m, pose.y_m) + _BEYOND_M <= limit_m:
            return field
    return march(terrain, sources)


def _along_corridor(terrain: Terrain, sources: Mask, pose: Pose) -> Field | None:
    """`march` in a corridor around the way that leads to the sources on larger cells, each as fast
    as the fastest in it. Nothing is much faster than that way: None where the corridor's is slower
    by more than DETOUR, as where it leads through what only larger cells let pass."""
    wide = Terrain(
        coarser(terrain.frame, COARSE),
        pooled(terrain.clearance_m, COARSE),
        pooled(terrain.traversable.view(np.uint8), COARSE).view(bool),
        pooled(terrain.speed, COARSE),
    )
    guess = march(wide, pooled((sources & terrain.traversable).view(np.uint8), COARSE).view(bool))
    way = terrain.frame.cells(descend(guess, (pose.x_m, pose.y_m)))[:, ::-1]
    if not len(way):
        return None
    corridor = np.zeros(terrain.frame.shape, np.uint8)
    cv2.polylines(corridor, [way], False, 1, 2 * round(CORRIDOR_M / terrain.frame.resolution_m))
    held = replace(terrain, traversable=terrain.traversable & corridor.view(bool))
    field = march(held, sources)
    here, least = (f.at(pose.x_m, pose.y_m) for f in (field, guess))
    return field if here <= DETOUR * least + CORNER_M else None


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


def _connected(traversable: Mask, left: NDArray[np.intp]) -> tuple[Mask, Window]:
    """The 4-connected parts of what is traversable that hold a seed, of (N, 2) traversable cells:
    the window that holds them, and the cells of it that are theirs. As costly as they are large,
    whatever lies elsewhere."""
    rows, cols = traversable.shape
    filled = np.zeros((rows + 2, cols + 2), np.uint8)
    passable, window = traversable.view(np.uint8), None
    while len(left):
        row, col = left[0].tolist()
        _, _, _, (x, y, w, h) = cv2.floodFill(passable, filled, (col, row), 1, flags=_FILL)
        window = joined(window, (slice(y, y + h), slice(x, x + w)))
        left = left[filled[left[:, 0] + 1, left[:, 1] + 1] == 0]
    assert window is not None
    inner = filled[1:-1, 1:-1][window]
    return inner.view(bool).copy(), window
