"""Going to a frontier: which there are, the steps to the elected one, and when it is given up."""

import math

import numpy as np

from runtime.core import progress
from runtime.core.distances import planner
from runtime.core.local_policy import local_policy
from runtime.core.mapping import coverage, frontiers
from runtime.core.motion.courses import Spin, Toward
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig
from runtime.core.types import F64, Action, Frontier
from runtime.core.voting import consensus
from runtime.core.voting.brief import ROOM_RANGE_M
from runtime.core.world import Aim, AimKind, Command, Mode, World, toward, with_distances

ARRIVED_M = 0.25  # from a frontier's goal point
SEEN_M2 = 1.0  # of a room's floor: it was found
SEEN_RANGE_M = 2.0  # frontier cells this close were looked into once the robot faced them,
HERE_M = 0.3  # these, so much farther than the nearest, whatever lies where;
ASIDE_RAD = math.radians(60.0)  # but not what lies so far aside of the line of sight, or more


def with_frontiers(world: World, cfg: NavigateConfig) -> World:
    """The candidates of the map as it is now, and how far they are on foot."""
    frame, explored = world.map.frame, world.explored
    tight = explored.resort >= Resort.TIGHT
    world.seen = planner.look_around(world.map, world.pose, cfg.robot.radius_m, tight, world.survey)
    explored.passages.note(frame, world.reach, tight)
    parts = explored.boundary.update(world.map, explored.given_up)
    if explored.resort >= Resort.AFAR and cfg.search.last_looks == "afar":
        edge = explored.boundary.edge
        out = explored.given_up | world.map.zones.barred(frame)
        dim = coverage.overlooked(world.map, explored.looked, out) & ~edge
        parts += frontiers.components(dim, frame, coverage.MIN_CELLS)
    named = frontiers.identify(explored.memory, parts, frame)
    with_distances(world, named)
    if explored.only_room:
        world.frontiers = _in_room(world, explored.only_room)
    return world


def _in_room(world: World, room: str) -> tuple[Frontier, ...]:
    """The frontiers that are not in a room of another type. While none of them can be reached, and
    none of that room was seen yet, all of them: it has to be found first."""
    semantic, frame = world.semantic, world.map.frame
    kept = tuple(
        f
        for f in world.frontiers
        if semantic.room_around(frame, f.goal_xy, ROOM_RANGE_M) in ("", room)
    )
    if any(math.isfinite(f.distance_m) for f in kept):
        return kept
    rooms = semantic.rooms
    mine = rooms[semantic.room_names.index(room)]
    cells = np.count_nonzero((mine > 0) & (mine >= rooms.max(axis=0)) & world.map.free)
    return kept if cells * frame.resolution_m**2 >= SEEN_M2 else world.frontiers


def try_resort(world: World, resort: Resort, cfg: NavigateConfig) -> Command:
    """Take one of the last resorts, and look round for what it brings."""
    world.explored.resort = resort
    if resort is Resort.RETRY:
        world.explored.given_up[:] = False
        world.map.reopen()
    with_frontiers(world, cfg)
    course = Spin(cfg.control.look_radps)
    return Command(Action.TURN_LEFT, Mode.LOOK, None, resort.reason, course=course)


def explore(world: World, cfg: NavigateConfig) -> Command | None:
    """Drive to the elected frontier; on arrival face it, and give up what shows nothing new."""
    while world.standing.decision is not None:
        decision, rank = world.standing.decision, cfg.consensus.rank
        frontier = world.frontier(consensus.successor(decision, world.frontiers, rank))
        if frontier is None:
            return None
        command = to_frontier(world, frontier, cfg)
        if command is not None:
            return command
        with_frontiers(world, cfg)
    return None


def to_frontier(world: World, frontier: Frontier, cfg: NavigateConfig) -> Command | None:
    """The step toward a frontier; None when it was given up instead."""
    policy, aim = local_policy(cfg), Aim(AimKind.FRONTIER, frontier.id)
    goal_xy, label = frontier.goal_xy, f"frontier {frontier.id}"
    if frontier.distance_m <= ARRIVED_M:
        turn = policy.turn(world, frontier.centre_xy)
        if turn is None:
            world.give_up(_looked_into(world, frontier.cells_xy))
            return None
        if progress.stalled(world, aim, None, cfg):
            world.give_up(frontier.cells_xy, SEEN_RANGE_M)
            return None
        facing = Toward(frontier.centre_xy)
        return Command(turn, Mode.FRONTIER, goal_xy, f"face {label}", course=facing)
    goal = world.terrain.frame.cells(np.array([goal_xy]))
    field = world.plan.toward(world.terrain, goal, world.pose)
    if progress.stalled(world, aim, field, cfg):
        world.give_up(frontier.cells_xy)
        return None
    action, course = policy.drive(world, field)
    command = Command(action, Mode.FRONTIER, goal_xy, f"drive to {label}", course=course)
    return toward(field, world.pose, command)


def _looked_into(world: World, cells_xy: F64) -> F64:
    """(N, 2) m -> (M, 2) m, those of a frontier's cells behind which the robot has looked from
    where it is. Of a frontier that goes past the end of a wall beside the robot the unknown lies
    aside: it comes in view from farther along."""
    sight = cells_xy - world.pose.xy
    away = np.hypot(*sight.T)
    unknown = frontiers.outward(world.map, cells_xy)
    behind = (sight * unknown).sum(axis=1) > math.cos(ASIDE_RAD) * away * np.hypot(*unknown.T)
    nowhere = ~unknown.any(axis=1)
    here = away <= float(away.min()) + HERE_M
    looked: F64 = cells_xy[here | (away <= SEEN_RANGE_M) & (behind | nowhere)]
    return looked
