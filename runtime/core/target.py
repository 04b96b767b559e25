"""The target: which instance is approached, from where it is looked at, when it is believed."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from runtime.core.map import NavigationMap
from runtime.core.planner import Field, Terrain
from runtime.core.semantics import Instance, SemanticMap
from runtime.core.types import F64, Mask, Pose


@dataclass(frozen=True)
class TargetConfig:
    """[target]"""

    inspect_log_odds: float = 0.8  # worth a detour to look again
    confirm_log_odds: float = 1.6  # believed, when seen from enough views
    confirm_views: int = 2
    rejection_log_odds: float = -1.0  # what is left of the evidence after a look from close by
    stop_m: float = 0.70  # from the nearest seen cell of the target
    seen_m: float = 1.8  # a target is stopped at only when it was seen from as near as this
    reach_m: float = 1.3  # an approach that ends further away is no arrival
    view_cone_rad: float = math.radians(80.0)  # stand where it was seen from, not behind its wall
    distance_cost: float = 0.15  # log-odds that a metre of straight distance costs a candidate
    rival_share: float = 0.5  # footprint shared with a stronger instance of another name


def confirmed(instance: Instance, cfg: TargetConfig) -> bool:
    """Whether the instance is believed to be what it is called."""
    return instance.log_odds >= cfg.confirm_log_odds and len(instance.views) >= cfg.confirm_views


def reject(instance: Instance, cfg: TargetConfig) -> None:
    """It was looked at from close by and not believed: what spoke for it is forgotten, its views
    too. Only new views, more of them after each rejection, bring it back."""
    instance.rejections += 1
    instance.log_odds = min(instance.log_odds, instance.rejections * cfg.rejection_log_odds)
    instance.views.clear()


def choose(
    semantic: SemanticMap, goal: str, pose: Pose, cfg: TargetConfig, least: float | None = None
) -> Instance | None:
    """The instance to go to: confirmed ones first, then by evidence and nearness. `least` lowers
    the evidence asked for when there is nothing else to do."""
    bar = cfg.inspect_log_odds if least is None else least
    candidates = [
        i
        for i in semantic.instances.values()
        if i.name == goal and i.views and i.log_odds >= bar and not _outdone(i, semantic, cfg)
    ]

    def merit(i: Instance) -> tuple[bool, float, int]:
        distance = math.hypot(i.xy[0] - pose.x_m, i.xy[1] - pose.y_m)
        return confirmed(i, cfg), i.log_odds - cfg.distance_cost * distance, -i.id

    return max(candidates, key=merit, default=None)


def _outdone(instance: Instance, semantic: SemanticMap, cfg: TargetConfig) -> bool:
    """Whether the same place is more surely something else."""
    mine = {(round(x, 3), round(y, 3)) for x, y in instance.cells_xy}
    for other in semantic.instances.values():
        if other.name == instance.name or other.log_odds <= instance.log_odds:
            continue
        if math.dist(other.xy, instance.xy) > 1.5:
            continue
        theirs = {(round(x, 3), round(y, 3)) for x, y in other.cells_xy}
        if len(mine & theirs) >= cfg.rival_share * min(len(mine), len(theirs)):
            return True
    return False


def standpoints(
    grid: NavigationMap, terrain: Terrain, reach: Field, instance: Instance, cfg: TargetConfig
) -> Mask:
    """(r, c) of the terrain: reachable cells from which the robot can face the target up close. If
    furniture keeps it further away, the nearest reachable cells; none beyond `reach_m`."""
    distance = _distance_to(terrain, instance.cells_xy)
    candidates = np.isfinite(reach.arrival_m) & (distance <= cfg.reach_m)
    candidates &= _seen_side(terrain, instance, cfg)
    if not candidates.any():
        return candidates
    best = float(distance[candidates].min())
    candidates &= distance <= max(cfg.stop_m, best + 0.08)
    rows, cols = np.nonzero(candidates)
    clear = _line_of_sight(grid, terrain, np.stack([rows, cols], axis=1), instance)
    if clear.any():  # else it stands on something that the camera looks over
        candidates[rows[~clear], cols[~clear]] = False
    return candidates


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


def _seen_side(terrain: Terrain, instance: Instance, cfg: TargetConfig) -> Mask:
    """(r, c) cells in the cone from the target toward a place it was seen from."""
    rows, cols = np.ogrid[: terrain.frame.rows, : terrain.frame.cols]
    r = terrain.frame.resolution_m
    x = (terrain.frame.x0_m + (cols + 0.5) * r - instance.xy[0]).astype(np.float32)
    y = (terrain.frame.y0_m + (rows + 0.5) * r - instance.xy[1]).astype(np.float32)
    least = np.float32(math.cos(cfg.view_cone_rad)) * np.hypot(x, y)
    side = np.zeros(terrain.frame.shape, bool)
    for view in instance.views:
        seen_from = math.atan2(view.y_m - instance.xy[1], view.x_m - instance.xy[0])
        side |= x * np.float32(math.cos(seen_from)) + y * np.float32(math.sin(seen_from)) >= least
    return side


def _line_of_sight(
    grid: NavigationMap, terrain: Terrain, cells: np.ndarray, instance: Instance, samples: int = 24
) -> Mask:
    """(N,) whether nothing but the target's own surroundings stands between a cell and its nearest
    cell of the target."""
    start = terrain.frame.centres(cells.astype(np.int32))
    gaps = np.linalg.norm(start[:, None] - instance.cells_xy[None], axis=2)
    end = instance.cells_xy[np.argmin(gaps, axis=1)]
    t = np.linspace(0.0, 1.0, samples)[None, :, None]
    line = start[:, None] * (1 - t) + end[:, None] * t
    frame = grid.frame
    rc = frame.cells(line)
    own = np.zeros(frame.shape, np.uint8)
    mine = frame.cells(instance.cells_xy)
    own[tuple(mine.T)] = 1
    near = cv2.dilate(own, np.ones((5, 5), np.uint8)) > 0
    blocked = grid.occupied[rc[..., 0], rc[..., 1]] & ~near[rc[..., 0], rc[..., 1]]
    return np.asarray(~blocked.any(axis=1), bool)
