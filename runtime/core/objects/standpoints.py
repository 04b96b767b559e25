"""The target: which instance is approached, from where it is looked at, when it is believed."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from runtime.core.distances.planner import Field, Terrain
from runtime.core.geometry import bearing, wrap_angle
from runtime.core.mapping.grid import NavigationMap
from runtime.core.objects import instances
from runtime.core.objects.instances import Instance
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.types import F64, Mask, Pose

BESIDE_M = 1.5  # between the middles of two things that may share a place


@dataclass(frozen=True)
class TargetConfig:
    """[target]"""

    inspect_log_odds: float = 0.8  # worth a detour to look again
    keep_log_odds: float = 0.0  # enough to go on for, once on the way
    confirm_log_odds: float = 1.6  # believed, when seen from enough views
    confirm_views: int = 2  # at least, of which two must differ
    second_side_rad: float = math.radians(20.0)  # in bearing by this,
    second_nearer: float = 1.4  # or in range by this factor
    rejection_log_odds: float = -1.0  # what is left of the evidence after a look from close by
    stop_m: float = 0.70  # from the nearest seen cell of the target
    low_m: float = 0.90  # the same at most, where the camera looks over what is nearer
    seen_m: float = 1.8  # a target is stopped at only when it was seen from as near as this
    reach_m: float = 1.3  # an approach that ends further away is no arrival
    view_cone_rad: float = math.radians(80.0)  # stand where it was seen from, not behind its wall
    detour_m: float = 10.0  # what going to something else costs
    keep_m: float = 1.0  # by so much must another be better to be gone to instead
    rival_share: float = 0.5  # of footprint and height, shared with what is more surely another
    rival_cosine: float = 0.6  # and that alike, or of one size
    rival_size: float = 0.5  # of the longer side, the shorter's share
    apart_confidence: float = 0.9  # from which on something else keeps its cells to itself,
    apart_size: float = 1.2  # unless it is so much larger than the target


def confirmed(instance: Instance, goal: str, cfg: TargetConfig) -> bool:
    """Whether the instance is believed to be the goal: enough evidence, from two directions."""
    return supported(instance, goal, cfg) and from_two_sides(instance, goal, cfg)


def supported(instance: Instance, goal: str, cfg: TargetConfig) -> bool:
    """Whether the evidence would do, wherever it was seen from: some of it is of this search."""
    enough = instance.odds.get(goal, -math.inf) >= cfg.confirm_log_odds
    return enough and bool(instance.backing.get(goal))


def from_two_sides(instance: Instance, goal: str, cfg: TargetConfig) -> bool:
    """Whether two views that spoke for it truly differ: in bearing, or one is much nearer than the
    other. What looks like the goal by chance seldom does so twice."""
    views = instance.backing.get(goal, ())
    if len(views) < cfg.confirm_views:
        return False
    ranges = [math.dist(view.xy, instance.xy) for view in views]
    if min(ranges) * cfg.second_nearer <= max(ranges):
        return True
    bearings = [bearing(instance.xy, (view.x_m, view.y_m)) for view in views]
    widest = max(abs(wrap_angle(a - b)) for a in bearings for b in bearings)
    return widest >= cfg.second_side_rad


def judge(instance: Instance, goal: str, pose: Pose, cfg: TargetConfig) -> bool:
    """The robot stands before it and faces it: whether to stop here. What is not believed at the
    first look is looked at from another side while something speaks for it, and after that
    rejected."""
    sole = len(instance.looks) > 1 and supported(instance, goal, cfg)
    if _from_near(instance, goal, cfg) and (sole or confirmed(instance, goal, cfg)):
        return True
    if instance.looks or instance.odds[goal] < cfg.inspect_log_odds:
        reject(instance, goal, cfg)
    else:
        instance.looks.append(pose)
    return False


def no_other_side(instance: Instance, goal: str, pose: Pose, cfg: TargetConfig) -> None:
    """There is none to stand on: the evidence of this one has to do."""
    instance.looks.append(pose)
    if not supported(instance, goal, cfg):
        reject(instance, goal, cfg)


def wants_other_side(instance: Instance, goal: str, cfg: TargetConfig) -> bool:
    """Whether it was faced once and is neither believed, from near, nor rejected."""
    certain = confirmed(instance, goal, cfg) and _from_near(instance, goal, cfg)
    return len(instance.looks) == 1 and not certain


def _from_near(instance: Instance, goal: str, cfg: TargetConfig) -> bool:
    return instance.near_m.get(goal, math.inf) <= cfg.seen_m


def reject(instance: Instance, goal: str, cfg: TargetConfig) -> None:
    """It was looked at from close by and not believed to be the goal."""
    instances.reject(instance, goal, cfg.rejection_log_odds)


def ranked(
    semantic: SemanticMap, goal: str, away: Callable[[Instance], float], cfg: TargetConfig,
    least: float | None = None, standing: int | None = None,
) -> list[Instance]:  # fmt: skip
    """The instances worth going to, first the one that costs least to go to and, as likely as it is
    none, to come back from. `away` says how far one is, m. `least` lowers the evidence asked for
    when there is nothing else to do; `standing` is the instance that the robot is on its way to,
    for which less will do: one view that misses it does not turn the robot round."""
    bar = cfg.inspect_log_odds if least is None else least
    candidates = [
        i
        for i in semantic.instances.values()
        if i.odds.get(goal, -math.inf) >= (min(bar, cfg.keep_log_odds) if i.id == standing else bar)
        and i.views_as(goal)
        and not _outdone(i, goal, semantic, cfg)
    ]

    def cost_m(i: Instance) -> tuple[float, float, int]:
        detour_m = (1.0 - i.confidence_of(goal)) * cfg.detour_m
        kept_m = cfg.keep_m if i.id == standing else 0.0
        return away(i) + detour_m - kept_m, -i.odds[goal], i.id

    return sorted(candidates, key=cost_m)


def on_foot_m(reach: Field, cfg: TargetConfig, instance: Instance) -> float:
    """How far the robot has to go to come within `reach_m` of it, m; inf when no way is known."""
    frame, n = reach.frame, math.ceil(cfg.reach_m / reach.frame.resolution_m)
    row, col = frame.cell(*instance.xy)
    rows, cols = (slice(max(0, at - n), max(0, at + n + 1)) for at in (row, col))
    around = reach.arrival_m[rows, cols]
    return float(around.min(initial=math.inf))


def _outdone(instance: Instance, goal: str, semantic: SemanticMap, cfg: TargetConfig) -> bool:
    """Whether the same thing, or another in the same place, is more surely something else."""
    if instance.name != goal:
        return True
    rivals = [
        other
        for other in semantic.instances.values()
        if math.dist(other.xy, instance.xy) <= BESIDE_M
        and other.name != goal
        and other.log_odds > instance.log_odds
        and _level(instance, other, cfg.rival_share)
        and _resemble(instance, other, cfg)
    ]
    mine = _places(instance) if rivals else frozenset()
    for other in rivals:
        theirs = _places(other)
        if len(mine & theirs) >= cfg.rival_share * min(len(mine), len(theirs)):
            return True
    return False


def _level(a: Instance, b: Instance, share: float) -> bool:
    """Whether two things are at one height, and not one on top of the other."""
    common = min(a.high_m, b.high_m) - max(a.low_m, b.low_m)
    return common >= share * min(a.high_m - a.low_m, b.high_m - b.low_m)


def _resemble(a: Instance, b: Instance, cfg: TargetConfig) -> bool:
    """Whether two things in one place look as if they were one: a chair at a desk does not. Where
    a detector gives no embeddings, they must at least be of one size: a clock is no nightstand."""
    one, other = a.embedding, b.embedding
    if one.size and one.shape == other.shape:
        return float(one @ other) >= cfg.rival_cosine
    lengths = [float(np.ptp(thing.cells_xy, axis=0).max()) for thing in (a, b)]
    return min(lengths) >= cfg.rival_size * max(lengths)


def apart(instance: Instance, semantic: SemanticMap, cfg: TargetConfig) -> Instance:
    """The instance without the cells of what surely is something else at the same height, and not
    larger: the coffee table in a sofa's box. The instance itself where nothing would be left."""
    largest = cfg.apart_size * len(instance.cells_xy)
    theirs: set[tuple[float, float]] = set()
    for other in semantic.instances.values():
        if (
            other.name != instance.name
            and other.confidence >= cfg.apart_confidence
            and math.dist(other.xy, instance.xy) <= BESIDE_M
            and len(other.cells_xy) <= largest
            and _level(instance, other, cfg.rival_share)
        ):
            theirs |= _places(other)
    own = [cell not in theirs for cell in map(tuple, instance.cells_xy.round(3).tolist())]
    if all(own) or not any(own):
        return instance
    return replace(instance, cells_xy=instance.cells_xy[own])


def _places(instance: Instance) -> frozenset[tuple[float, float]]:
    """The cells under it, as values that compare."""
    return frozenset(map(tuple, instance.cells_xy.round(3).tolist()))


def standpoints(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    instance: Instance,
    goal: str,
    cfg: TargetConfig,
    seen_from_m: float = 0.0,
) -> Mask:
    """(r, c) of the terrain: reachable cells from which the robot can face the target up close, not
    nearer than `seen_from_m`, where it is in the image (or than `low_m`, for what lies on the
    floor). If furniture keeps it further away, the nearest reachable cells; none beyond
    `reach_m`."""
    distance = _distance_to(terrain, instance.cells_xy)
    least_m = min(seen_from_m, cfg.low_m)
    candidates = np.isfinite(reach.arrival_m) & (distance <= cfg.reach_m) & (distance >= least_m)
    candidates &= _seen_side(terrain, instance, instance.views_as(goal), cfg.view_cone_rad)
    if not candidates.any():
        return candidates
    best = float(distance[candidates].min())
    candidates &= distance <= max(cfg.stop_m, best + 0.08, least_m + 0.08)
    return _in_sight(grid, terrain, candidates, instance)


def other_sides(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    instance: Instance,
    goal: str,
    cfg: TargetConfig,
) -> Mask:
    """(r, c) of the terrain: reachable cells close by, if possible not too close, that look at the
    target from a direction that it was not seen from yet."""
    distance = _distance_to(terrain, instance.cells_xy)
    candidates = np.isfinite(reach.arrival_m) & (distance <= cfg.reach_m)
    views = instance.views_as(goal)
    candidates &= _seen_side(terrain, instance, views, cfg.view_cone_rad)
    candidates &= ~_seen_side(terrain, instance, [*views, *instance.looks], cfg.second_side_rad)
    if not candidates.any():
        return candidates
    roomy = candidates & (2 * distance >= cfg.stop_m + cfg.reach_m)  # nearer, it may be out of view
    return _in_sight(grid, terrain, roomy if roomy.any() else candidates, instance)


def look_from(
    grid: NavigationMap,
    terrain: Terrain,
    reach: Field,
    instance: Instance,
    cfg: TargetConfig,
    seen_from_m: float = 0.0,
) -> tuple[float, float] | None:
    """Where to look at an object from, m in the map frame: of its standpoints the one that is
    nearest on foot; None when it cannot be reached."""
    stands = standpoints(grid, terrain, reach, instance, instance.name, cfg, seen_from_m)
    if not stands.any():
        return None
    away = np.where(stands, reach.arrival_m, np.inf)
    row, col = np.unravel_index(int(away.argmin()), away.shape)
    x, y = terrain.frame.centres(np.array([row, col], np.int32))
    return float(x), float(y)


def _in_sight(grid: NavigationMap, terrain: Terrain, cells: Mask, instance: Instance) -> Mask:
    """(r, c) those of the cells that nothing hides the target from. If there are none, all: it
    stands on something that the camera looks over."""
    rows, cols = np.nonzero(cells)
    clear = _line_of_sight(grid, terrain, np.stack([rows, cols], axis=1), instance)
    if clear.any():
        cells[rows[~clear], cols[~clear]] = False
    return cells


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


def _seen_side(terrain: Terrain, instance: Instance, views: list[Pose], cone_rad: float) -> Mask:
    """(r, c) cells that see the target from within `cone_rad` of the direction of some view."""
    rows, cols = np.ogrid[: terrain.frame.rows, : terrain.frame.cols]
    r = terrain.frame.resolution_m
    x = (terrain.frame.x0_m + (cols + 0.5) * r - instance.xy[0]).astype(np.float32)
    y = (terrain.frame.y0_m + (rows + 0.5) * r - instance.xy[1]).astype(np.float32)
    least = np.float32(math.cos(cone_rad)) * np.hypot(x, y)
    side = np.zeros(terrain.frame.shape, bool)
    for view in views:
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
    near = cv2.dilate(own, np.ones((3, 3), np.uint8)) > 0  # more would hide a wall behind it
    blocked = grid.occupied[rc[..., 0], rc[..., 1]] & ~near[rc[..., 0], rc[..., 1]]
    return np.asarray(~blocked.any(axis=1), bool)
