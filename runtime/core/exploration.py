"""Going to a frontier: which there are, the steps to the elected one, and when it is given up."""

import numpy as np

from runtime.core import progress
from runtime.core.distances import planner
from runtime.core.local_policy import local_policy
from runtime.core.mapping import coverage, frontiers
from runtime.core.motion.courses import Toward
from runtime.core.settings import NavigateConfig
from runtime.core.types import Frontier
from runtime.core.voting import consensus
from runtime.core.world import Aim, AimKind, Command, Mode, Resort, World, toward, with_distances

ARRIVED_M = 0.25  # from a frontier's goal point
SEEN_RANGE_M = 2.0  # frontier cells this close were looked at once the robot faced them


def with_frontiers(world: World, cfg: NavigateConfig) -> World:
    """The candidates of the map as it is now, and how far they are on foot."""
    frame, explored = world.map.frame, world.explored
    tight = explored.resort >= Resort.TIGHT
    world.seen = planner.look_around(world.map, world.pose, cfg.robot.radius_m, tight, world.survey)
    parts = explored.boundary.update(world.map, explored.given_up)
    if explored.resort >= Resort.AFAR:
        edge = explored.boundary.edge
        out = explored.given_up | world.map.zones.barred(frame)
        dim = coverage.overlooked(world.map, explored.looked, out) & ~edge
        parts += frontiers.components(dim, frame, coverage.MIN_CELLS)
    named = frontiers.identify(explored.memory, parts, frame)
    with_distances(world, named)
    return world


def explore(world: World, cfg: NavigateConfig) -> Command | None:
    """Drive to the elected frontier; on arrival face it, and give up what shows nothing new."""
    while world.standing.decision is not None:
        decision, rank = world.standing.decision, cfg.consensus.rank
        frontier = world.frontier(consensus.successor(decision, world.frontiers, rank))
        if frontier is None:
            return None
        command = _to_frontier(world, frontier, cfg)
        if command is not None:
            return command
        with_frontiers(world, cfg)
    return None


def _to_frontier(world: World, frontier: Frontier, cfg: NavigateConfig) -> Command | None:
    """The step toward a frontier; None when it was given up instead."""
    policy, aim = local_policy(cfg), Aim(AimKind.FRONTIER, frontier.id)
    goal_xy, label = frontier.goal_xy, f"frontier {frontier.id}"
    if frontier.distance_m <= ARRIVED_M:
        turn = policy.turn(world, frontier.centre_xy)
        if turn is None or progress.stalled(world, aim, None, cfg):
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
