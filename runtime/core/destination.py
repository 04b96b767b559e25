"""Going to a place, or into an area: along what is known where a way is, else by exploring toward
it, and when that is given up."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from runtime.core import progress
from runtime.core.distances.planner import RESORT_SLACK_M
from runtime.core.distances.terrain import MARGIN_M
from runtime.core.exploration import to_frontier, try_resort, with_frontiers
from runtime.core.geometry import GridFrame
from runtime.core.local_policy import local_policy
from runtime.core.mapping.grid import RESOLUTION_M
from runtime.core.mapping.windows import disc_window, part_frame
from runtime.core.mapping.zones import Zone, room_within
from runtime.core.motion.courses import Toward
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig
from runtime.core.trying_again import look_again
from runtime.core.types import F64, I32, Action, Frontier, Mask, SearchState
from runtime.core.world import Aim, AimKind, Command, Mode, World, toward

NEAR_M = 0.25  # of a place: the robot is there
ROUND_CELLS = 8  # about what is known, through which a way may lead
AHEAD_M = 10.0  # a point so far on is looked at, to look a way
KEEP_M = 1.0  # another frontier must be so much nearer to the place to turn round for it
LEFT_M = 0.3  # so far outside of its area, the robot has left it


@dataclass(frozen=True)
class Destination:
    """A place, (x, y) m in the map frame; `yaw_rad`: which way to look there, None for any. Of an
    `area` the place is any in it."""

    name: str
    xy: tuple[float, float]
    yaw_rad: float | None = None
    area: Zone | None = None


def into(area: Zone) -> Destination:
    """Anywhere in it."""
    return Destination("the area of the search", area.middle_xy, None, area)


def known_way(world: World, to: Destination, cfg: NavigateConfig) -> Command | None:
    """The step along what is known, a turn or a stop there; None while no way is known."""
    if _is_there(world, to, cfg):
        return _faced(world, to, cfg)
    policy, sources = local_policy(cfg), _sources(world, to, cfg)
    if not len(sources):
        return None
    field = world.plan.toward(world.terrain, sources, world.pose)
    if progress.stalled(world, Aim(AimKind.PLACE, int(to.area is not None)), field, cfg):
        return _given_up(to, "the robot comes no nearer")
    action, course = policy.drive(world, field)
    why = f"drive to {to.name}"
    return toward(field, world.pose, Command(action, Mode.PLACE, to.xy, why, course=course))


def explore_toward(world: World, to: Destination, cfg: NavigateConfig) -> Command:
    """The step to the frontier from which the place is nearest, of those from which a way may lead
    there; where there is none, a stop."""
    hope = _hope(world, to, cfg)
    if not hope.place:
        shut = "something stands there, or it is kept out of"
        return _given_up(to, shut if to.area is None else "the robot fits nowhere in it")
    while (frontier := _nearest(world, to, hope)) is not None:
        command = to_frontier(world, frontier, cfg)
        if command is not None:
            return command
        with_frontiers(world, cfg)
    return _other_resort(world, to, cfg)


def is_within(world: World, area: Zone, cfg: NavigateConfig) -> bool:
    """Whether all of the body is in an area, with what planning wants round it."""
    outside_m = area.outside_m((world.pose.x_m, world.pose.y_m))
    return outside_m <= -_room_m(cfg)


def left_area(world: World, area: Zone) -> Command | None:
    """The end of a search whose robot is out of the area that it was in: by hand, by a push or by
    drift."""
    outside_m = area.outside_m((world.pose.x_m, world.pose.y_m))
    if outside_m <= LEFT_M:
        return None
    why = f"the robot is {outside_m:.1f} m outside of the area of the search"
    return Command(Action.STOP, Mode.STOP, None, why, ended=SearchState.AREA_LEFT)


def _is_there(world: World, to: Destination, cfg: NavigateConfig) -> bool:
    if to.area is not None:
        return is_within(world, to.area, cfg)
    return math.dist((world.pose.x_m, world.pose.y_m), to.xy) <= NEAR_M


def _faced(world: World, to: Destination, cfg: NavigateConfig) -> Command:
    """The turn to look the way that was asked for; a stop where that is done, or does not end."""
    pose, aim = world.pose, Aim(AimKind.FACE, 0)
    if to.yaw_rad is not None:
        x_m = pose.x_m + AHEAD_M * math.cos(to.yaw_rad)
        ahead = x_m, pose.y_m + AHEAD_M * math.sin(to.yaw_rad)
        turn = local_policy(cfg).turn(world, ahead)
        if turn is not None and not progress.dithers(world, aim, turn, cfg):
            why = f"look as asked at {to.name}"
            return Command(turn, Mode.FACE, to.xy, why, course=Toward(ahead))
    why = f"arrived at {to.name}"
    return Command(Action.STOP, Mode.STOP, to.xy, why, ended=SearchState.ARRIVED)


def _sources(world: World, to: Destination, cfg: NavigateConfig) -> I32:
    """(N, 2) cells of the terrain that are the place, of those that the robot can get to."""
    there = _cells_of(to, world.terrain.frame, cfg) & np.isfinite(world.reach.arrival_m)
    return np.argwhere(there).astype(np.int32)


def _cells_of(to: Destination, frame: GridFrame, cfg: NavigateConfig) -> Mask:
    """(r, c) cells that are the place."""
    if to.area is not None:
        return np.asarray(room_within(to.area, frame) >= _room_m(cfg), bool)
    there = np.zeros(frame.shape, bool)
    disc, window = disc_window(frame, *to.xy, NEAR_M - frame.resolution_m)
    there[window] = disc
    return there


def _room_m(cfg: NavigateConfig) -> float:
    """What the body wants to the edge of an area, to be in it."""
    return cfg.robot.radius_m + MARGIN_M + RESOLUTION_M


@dataclass(frozen=True)
class _Hope:
    """Whatever is not known to be shut may be a way. parts: (r, c) of a window of the map, by
    connected part of that its number; place: those that the place has a share in."""

    frame: GridFrame
    parts: I32
    place: frozenset[int]

    def of(self, cells_xy: F64) -> bool:
        """Whether a way may lead from any of these cells (N, 2) m to the place."""
        return not self.place.isdisjoint(self.parts[tuple(self.frame.cells(cells_xy).T)].tolist())


def _hope(world: World, to: Destination, cfg: NavigateConfig) -> _Hope:
    """All that the body may fit, the unknown included; round the window of what is known all is
    open, and one."""
    grid, body_m = world.map, cfg.robot.radius_m - RESORT_SLACK_M
    window = grid.known_window(ROUND_CELLS)
    frame = part_frame(grid.frame, window)
    bare = (~grid.occupied[window]).view(np.uint8)
    away_m = cv2.distanceTransform(bare, cv2.DIST_L2, cv2.DIST_MASK_5) * frame.resolution_m
    zone_m, _ = grid.zones.clearance(grid.frame, window)
    fits = (away_m - frame.resolution_m / 2 >= body_m) & (zone_m >= body_m)
    fits[[0, -1], :] = fits[:, [0, -1]] = True
    _, parts = cv2.connectedComponents(fits.view(np.uint8), connectivity=4)
    there = _cells_of(to, frame, cfg)
    known = set(parts[there].tolist()) if there.any() else {int(parts[0, 0])}
    if _is_kept_out(world, to) or (to.area is not None and not there.any() and _holds(frame, to)):
        known = set()
    return _Hope(frame, np.asarray(parts, np.int32), frozenset(known - {0}))


def _is_kept_out(world: World, to: Destination) -> bool:
    """Whether a zone holds the whole of a place, be it on the map by now or not."""
    if to.area is not None:
        return False
    outside_m = (zone.outside_m(to.xy) * (-1 if zone.area else 1) for zone in world.map.zones.zones)
    return any(away_m <= -NEAR_M for away_m in outside_m)


def _holds(frame: GridFrame, to: Destination) -> bool:
    """Whether all of an area is on a part of the map."""
    assert to.area is not None
    return all(frame.contains(*frame.cell(*corner)) for corner in to.area.corners_xy)


def _nearest(world: World, to: Destination, hope: _Hope) -> Frontier | None:
    """The frontier with the shortest way to the place, as far as anybody knows; the one that is
    gone to is kept unless another is much nearer."""
    aim = world.pursuit.aim
    going = aim.id if aim.kind is AimKind.FRONTIER else None

    def way_m(frontier: Frontier) -> tuple[float, int]:
        kept_m = KEEP_M if frontier.id == going else 0.0
        beyond_m = math.dist(frontier.goal_xy, to.xy)
        return frontier.distance_m + beyond_m - kept_m, frontier.id

    promising = (f for f in world.frontiers if math.isfinite(f.distance_m) and hope.of(f.cells_xy))
    return min(promising, key=way_m, default=None)


def _other_resort(world: World, to: Destination, cfg: NavigateConfig) -> Command:
    """What was given up is tried again, then tight gaps, then ways that were open before; then the
    place is given up."""
    resort = world.explored.resort.next("afar")  # no surface holds a place
    if resort is None or resort > Resort.TIGHT:
        why = "no way leads there, and nothing is left to explore"
        return look_again(world, cfg, wait=True) or _given_up(to, why)
    return try_resort(world, resort, cfg)


def _given_up(to: Destination, why: str) -> Command:
    reason = f"{to.name} cannot be reached: {why}"
    return Command(Action.STOP, Mode.STOP, to.xy, reason, ended=SearchState.UNREACHABLE)
