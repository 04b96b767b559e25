"""Where the robot can stand to face an object, and where to see it from another side."""

import math
from collections.abc import Sequence

import cv2
import numpy as np

from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import SLOWEST, Terrain
from runtime.core.geometry import GridFrame, Standoff
from runtime.core.mapping.grid import NavigationMap
from runtime.core.objects.instances import Instance
from runtime.core.objects.verdict import SECOND_SIDE_RAD
from runtime.core.types import F64, Mask, Pose

STOP_M = 0.70  # from the nearest seen cell of the target
MIDDLE_M = 1.1  # from its middle, if there is a place, and it is not larger itself
LOW_M = 0.90  # the same at most, where the camera looks over what is nearer
OVER_M = 1.0  # from the middle of what is above the camera, at most for it to be in the image
REACH_M = 1.3  # an approach that ends further away is no arrival
HIGH = 1 << 5  # of the heights at which something stood: 0.8 m and more hide what is behind
ROOMY = 0.5  # relative speed: where it is slower the robot gets stuck more easily
VIEW_CONE_RAD = math.radians(80.0)  # stand where it was seen from, not behind its wall
NEAREST_M = 0.08  # farther than the nearest place is as near
BACK_M = 0.15  # from where it was looked at before, to be there again
ANYWHERE = Standoff()
UNSEEN_M = 0.25  # from where it was not in the image, it is not, either
TRIED_RAD = math.radians(45.0)  # of a side on which it was come no nearer to


def standpoints(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    instance: Instance,
    goal: str,
    standoff: Standoff = ANYWHERE,
    reaches_m: float = math.inf,
) -> Mask:
    """(r, c) of the terrain: reachable cells from which the robot can face the target up close, not
    nearer than `standoff`, where it is in the image (or than LOW_M and OVER_M, for what lies on the
    floor or hangs high), nor behind a wall where another place will do. If furniture keeps it
    further away, the nearest reachable cells; none beyond REACH_M. `reaches_m`: how far one may
    reach from its middle; what else was taken for it does not count."""
    distance = _distance_to(terrain, _middle(instance, reaches_m))
    candidates = _within_reach(terrain, reach, instance, distance, standoff)
    candidates &= _seen_side(terrain, instance, instance.views_as(goal), VIEW_CONE_RAD)
    if not candidates.any():
        return candidates
    near = _nearest(candidates, distance, standoff)
    before = _before_walls(grid, terrain, near, instance)
    if not before.any():
        few = candidates.copy()
        few[::2], few[:, ::2] = False, False  # every other one will do to tell how far away
        few = _before_walls(grid, terrain, few, instance)
        farther = candidates & (distance >= distance[few].min(initial=math.inf))
        near = _nearest(farther, distance, standoff) if few.any() else near
        before = _before_walls(grid, terrain, near, instance) if few.any() else near
    clear = _in_sight(grid, terrain, before, instance)
    return _by_middle(terrain, clear, instance, reaches_m)


def any_side(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    instance: Instance,
    tried: Sequence[Pose],
    standoff: Standoff = ANYWHERE,
    reaches_m: float = math.inf,
) -> Mask:
    """(r, c) of the terrain: reachable cells from which the target can be faced up close as it is
    by `standpoints`, whatever side that is, but not one where it was `tried` in vain. Nothing may
    hide it from there."""
    distance = _distance_to(terrain, _middle(instance, reaches_m))
    candidates = _within_reach(terrain, reach, instance, distance, standoff)
    candidates &= ~_seen_side(terrain, instance, tried, TRIED_RAD)
    if not candidates.any():
        return candidates
    return _nearest(_clear_of(grid, terrain, candidates, instance), distance, standoff)


def stands_before(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    instance: Instance,
    pose: Pose,
    reaches_m: float = math.inf,
) -> bool:
    """Whether a robot that cannot come nearer stands before a thing: as near as what is low is
    stood before, and nothing high stands between."""
    row, col = terrain.frame.cell(pose.x_m, pose.y_m)
    here = np.zeros(terrain.frame.shape, bool)
    here[row, col] = True
    away = _distance_to(terrain, _middle(instance, reaches_m))[row, col]
    return bool(away <= LOW_M and _before_walls(grid, terrain, here, instance).any())


def close_to(terrain: Terrain, reach: Field, xy: F64) -> Mask:
    """(r, c) of the terrain: the reachable cells round a place (2,) m where the robot has stood."""
    near = _distance_to(terrain, xy[None]) <= BACK_M
    return np.asarray(near & np.isfinite(reach.arrival_m), bool)


def stepped_back(standoff: Standoff) -> Standoff:
    """As far from a thing that was not in the image as is stood before anything."""
    return Standoff(middle_m=OVER_M) if standoff.middle_m else Standoff(nearest_m=LOW_M)


def elsewhere(terrain: Terrain, stands: Mask, unseen: Sequence[Pose]) -> Mask:
    """(r, c) of the terrain: those of some stands that are not where a thing was `unseen` from; all
    where there are none."""
    beside = _distance_to(terrain, np.array([pose.xy for pose in unseen])) <= UNSEEN_M
    others = stands & ~beside
    return np.asarray(others if others.any() else stands, bool)


def other_sides(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    instance: Instance,
    goal: str,
) -> Mask:
    """(r, c) of the terrain: reachable cells close by, if possible not too close, that look at the
    target from a direction that it was not seen from yet."""
    distance = _distance_to(terrain, instance.cells_xy)
    candidates = np.isfinite(reach.arrival_m) & (distance <= REACH_M)
    views = instance.views_as(goal)
    candidates &= _seen_side(terrain, instance, views, VIEW_CONE_RAD)
    candidates &= ~_seen_side(terrain, instance, [*views, *instance.looks], SECOND_SIDE_RAD)
    if not candidates.any():
        return candidates
    candidates = _fitting(terrain, candidates)
    roomy = candidates & (2 * distance >= STOP_M + REACH_M)  # nearer, it may be out of view
    return _in_sight(grid, terrain, roomy if roomy.any() else candidates, instance)


def views_of(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    cells_xy: F64,
    middle_xy: tuple[float, float],
    range_m: tuple[float, float],
) -> F64:
    """(N, 2) m, reachable cells from which a part of a surface is in sight: of its cells, (M, 2) m,
    the nearest is so far away, and nothing is before its middle that cameras do not look over. Not
    close to obstacles, where there are others."""
    distance = _distance_to(terrain, cells_xy)
    near_m, far_m = range_m
    stands = np.isfinite(reach.arrival_m) & (distance >= near_m) & (distance <= far_m)
    stands[::2], stands[:, ::2] = False, False  # every other one will do
    rows, cols = np.nonzero(stands)
    stands_xy = terrain.frame.centres(np.stack([rows, cols], axis=1).astype(np.int32))
    ends = np.broadcast_to(middle_xy, stands_xy.shape)
    high = grid.occupied & (grid.stood >= HIGH)
    clear = _clear(high, grid.frame, stands_xy, ends, cells_xy)
    roomy = clear & (terrain.speed[rows, cols] >= ROOMY)
    return stands_xy[roomy if roomy.any() else clear]


def look_from(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    instance: Instance,
    standoff: Standoff = ANYWHERE,
) -> tuple[float, float] | None:
    """Where to look at an object from, m in the map frame: of its standpoints the one that is
    nearest on foot; None when it cannot be reached."""
    stands = standpoints(grid, terrain, reach, instance, instance.name, standoff)
    if not stands.any():
        return None
    away = np.where(stands, reach.arrival_m, np.inf)
    row, col = np.unravel_index(int(away.argmin()), away.shape)
    x, y = terrain.frame.centres(np.array([row, col], np.int32))
    return float(x), float(y)


def _in_sight(grid: NavigationMap, terrain: Terrain, cells: Mask, instance: Instance) -> Mask:
    """(r, c) those of the cells that nothing hides the target from. If there are none, all: it
    stands on something that the camera looks over."""
    clear = _clear_of(grid, terrain, cells, instance)
    return clear if clear.any() else cells


def _clear_of(grid: NavigationMap, terrain: Terrain, cells: Mask, instance: Instance) -> Mask:
    """(r, c) those of the cells that nothing hides the target from."""
    rows, cols = np.nonzero(cells)
    clear = _line_of_sight(grid, terrain, np.stack([rows, cols], axis=1), instance)
    found = np.zeros_like(cells)
    found[rows, cols] = clear
    return found


def _before_walls(grid: NavigationMap, terrain: Terrain, cells: Mask, instance: Instance) -> Mask:
    """(r, c) those of the cells between which and the target's middle nothing high stands."""
    rows, cols = np.nonzero(cells)
    stands_xy = terrain.frame.centres(np.stack([rows, cols], axis=1).astype(np.int32))
    middle_xy = np.broadcast_to(instance.xy, stands_xy.shape)
    high = grid.occupied & (grid.stood >= HIGH)
    found = np.zeros_like(cells)
    found[rows, cols] = _clear(high, grid.frame, stands_xy, middle_xy, instance.cells_xy)
    return found


def _within_reach(
    terrain: Terrain, reach: Field, instance: Instance, distance: F64, standoff: Standoff
) -> Mask:
    """(r, c) reachable cells so far from a thing, m, that an approach may end there."""
    near = (distance <= REACH_M) & (distance >= min(standoff.nearest_m, LOW_M))
    near &= np.isfinite(reach.arrival_m)
    if standoff.middle_m > 0:
        near[near] = _from_middle(terrain, near, instance) >= min(standoff.middle_m, OVER_M)
    return _fitting(terrain, near)


def _fitting(terrain: Terrain, cells: Mask) -> Mask:
    """(r, c) those of the cells in which the body has room; all where there are none: what is about
    the robot is passable without, so that it can leave, and nowhere to be."""
    fits = cells.copy()
    fits[cells] = terrain.speed[cells] > SLOWEST
    return fits if fits.any() else cells


def _nearest(cells: Mask, distance: F64, standoff: Standoff) -> Mask:
    """(r, c) of the cells those where a thing is stood before; where furniture keeps the robot
    further away, the nearest."""
    best = float(distance[cells].min(initial=math.inf))
    most_m = max(STOP_M, best + NEAREST_M, min(standoff.nearest_m, LOW_M) + NEAREST_M)
    return np.asarray(cells & (distance <= most_m), bool)


def _by_middle(terrain: Terrain, cells: Mask, instance: Instance, reaches_m: float) -> Mask:
    """(r, c) those of the cells that are near the middle of a thing, or so near as one of them is:
    what stands under it or before it may be taken for its edge."""
    away, kept = _from_middle(terrain, cells, instance), cells.copy()
    best = float(away.min(initial=math.inf))
    kept[cells] = away <= max(MIDDLE_M, reaches_m, best + NEAREST_M)
    return kept


def _from_middle(terrain: Terrain, cells: Mask, instance: Instance) -> F64:
    """(N,) m, how far some cells, (r, c), are from the middle of a thing, in their order."""
    centres = terrain.frame.centres(np.argwhere(cells).astype(np.int32))
    return np.asarray(np.hypot(*(centres - np.array(instance.xy)).T), np.float64)


def _middle(instance: Instance, reaches_m: float) -> F64:
    """(N, 2) m, the cells of it that are so near its middle; all where none are."""
    cells: F64 = instance.cells_xy
    within = np.hypot(*(cells - np.array(instance.xy)).T) <= reaches_m
    return cells[within] if within.any() else cells


def _distance_to(terrain: Terrain, cells_xy: F64) -> np.ndarray:
    """(r, c) metres from each cell's centre to the nearest of the given cells."""
    away = np.ones(terrain.frame.shape, np.uint8)
    cells = terrain.frame.cells(cells_xy)
    inside = ((cells >= 0) & (cells < terrain.frame.shape)).all(axis=1)
    if not inside.any():
        return np.full(terrain.frame.shape, np.inf)
    away[tuple(cells[inside].T)] = 0
    metres: np.ndarray = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_5)
    return metres * terrain.frame.resolution_m


def _seen_side(
    terrain: Terrain, instance: Instance, views: Sequence[Pose], cone_rad: float
) -> Mask:
    """(r, c) cells that see the target from within `cone_rad` of the direction of some view."""
    frame, r = terrain.frame, terrain.frame.resolution_m
    rows, cols = np.ogrid[: frame.rows, : frame.cols]
    x = frame.x0_m + (cols + (frame.first_col + 0.5)) * r - instance.xy[0]
    y = frame.y0_m + (rows + (frame.first_row + 0.5)) * r - instance.xy[1]
    x, y = x.astype(np.float32), y.astype(np.float32)
    least = np.float32(math.cos(cone_rad)) * np.hypot(x, y)
    side = np.zeros(terrain.frame.shape, bool)
    for view in views:
        seen_from = math.atan2(view.y_m - instance.xy[1], view.x_m - instance.xy[0])
        side |= x * np.float32(math.cos(seen_from)) + y * np.float32(math.sin(seen_from)) >= least
    return side


def _line_of_sight(
    grid: NavigationMap, terrain: Terrain, cells: np.ndarray, instance: Instance
) -> Mask:
    """(N,) whether nothing but the target's own surroundings stands between a cell and its nearest
    cell of the target."""
    start = terrain.frame.centres(cells.astype(np.int32))
    gaps = np.linalg.norm(start[:, None] - instance.cells_xy[None], axis=2)
    end = instance.cells_xy[np.argmin(gaps, axis=1)]
    return _clear(grid.occupied, grid.frame, start, end, instance.cells_xy)


def _clear(
    occupied: Mask, frame: GridFrame, start: F64, end: F64, own_xy: F64, samples: int = 24
) -> Mask:
    """(N, 2) m each -> (N,) whether no obstacle is on the line between, but for those at some
    cells of its own, (M, 2) m, and right beside them."""
    t, origin = np.linspace(0.0, 1.0, samples), (frame.x0_m, frame.y0_m)
    from_xy, to_xy = (start - origin) / frame.resolution_m, (end - origin) / frame.resolution_m
    x, y = (a[:, None] + (b - a)[:, None] * t for a, b in zip(from_xy.T, to_xy.T, strict=True))
    rows = np.floor(y).astype(np.int32).ravel() - frame.first_row
    cols = np.floor(x).astype(np.int32).ravel() - frame.first_col
    blocked = occupied[rows, cols]
    hit = np.flatnonzero(blocked)
    if hit.size:
        mine = frame.cells(own_xy)
        low = mine.min(axis=0) - 1
        own = np.zeros(np.ptp(mine, axis=0) + 3, np.uint8)
        own[tuple((mine - low).T)] = 1
        near = cv2.dilate(own, np.ones((3, 3), np.uint8)) > 0  # more would hide a wall behind it
        at = np.stack([rows[hit], cols[hit]], axis=1) - low
        beside = ((at >= 0) & (at < near.shape)).all(axis=1)
        beside[beside] = near[tuple(at[beside].T)]
        blocked[hit[beside]] = False
    return np.asarray(~blocked.reshape(-1, samples).any(axis=1), bool)
