"""Planning by fast marching: arrival times over free space, and the path down them."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from runtime.core.distances.terrain import NO_SQUEEZE, Squeeze, Terrain, TerrainSurvey
from runtime.core.geometry import GridFrame
from runtime.core.kernels import marching
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import Window, inside, joined, widened
from runtime.core.types import F64, I32, Mask, Pose

_FILL = 4 | cv2.FLOODFILL_MASK_ONLY | (1 << 8)  # four neighbours; ones in the mask
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
        top, left = near[0].start, near[1].start
        passable = terrain.traversable[near].view(np.uint8)
        filled = np.zeros((passable.shape[0] + 2, passable.shape[1] + 2), np.uint8)
        seed = col - left, row - top
        _, _, _, (x, y, w, h) = cv2.floodFill(passable, filled, seed, 1, flags=_FILL)
        held = slice(y + top, y + h + top), slice(x + left, x + w + left)
        if joined(near, widened(held, 1, frame)) == near:  # it goes on nowhere beyond
            return held
        side *= 2


def march(terrain: Terrain, sources: Mask, unhurried: bool = True) -> Field:
    """Arrival times from the source cells, (r, c). With `unhurried` closeness to obstacles costs;
    without, the field is the geodesic distance."""
    arrival = np.full(terrain.frame.shape, np.inf)
    arrival[sources & terrain.traversable] = 0.0
    speed = terrain.speed if unhurried else terrain.traversable
    marching.march(arrival, speed, terrain.frame.resolution_m)
    return Field(terrain.frame, arrival)


def march_from(terrain: Terrain, points_xy: F64, unhurried: bool = True) -> Field:
    """`march` from (N, 2) m points in the map frame; those outside the window are dropped."""
    cells = terrain.frame.cells(np.atleast_2d(points_xy))
    inside = ((cells >= 0) & (cells < terrain.frame.shape)).all(axis=1)
    sources = np.zeros(terrain.frame.shape, bool)
    sources[tuple(cells[inside].T)] = True
    return march(terrain, sources, unhurried)


def descend(field: Field, start_xy: tuple[float, float], limit: int = 4000) -> F64:
    """The path from a point down to the field's sources, (N, 2) m, cell by cell; (0, 2) if none."""
    frame = field.frame
    return frame.centres(marching.descend(field.arrival_m, frame.cell(*start_xy), limit))
