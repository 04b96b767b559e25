"""How the body is moved and what became of it: courses, turns, stalls, collisions."""

import math
from dataclasses import replace

import numpy as np

from runtime.core.distances import planner
from runtime.core.geometry import bearing, wrap_angle
from runtime.core.motion import control, step_search
from runtime.core.motion.control import STILL, Along, ControlConfig, Course
from runtime.core.settings import NavigateConfig
from runtime.core.types import F64, Action, Observation
from runtime.core.world import Command, Progress, World

NEARER_M = 0.05  # what counts as having come closer
PATIENCE = 8  # steps without coming closer, after which a way of several steps is looked for
BEYOND = 3  # cells


def advance(world: World, obs: Observation, cfg: NavigateConfig) -> None:
    """Book what happened since the observation before: time, turn, a collision."""
    since_s = (obs.stamp_ns - world.stamp_ns) / 1e9 if world.stamp_ns else 0.0
    world.dt_s = min(1.0, max(0.0, since_s))
    world.elapsed_s += world.dt_s
    seen = int(np.count_nonzero(obs.depth_m > 0))
    world.blind = seen < cfg.explore.blind_share * obs.depth_m.size
    world.turned_rad += wrap_angle(obs.pose.yaw_rad - world.pose.yaw_rad)
    if _collided(world, obs, cfg):
        world.collisions += 1
        world.map.bump(obs.pose, cfg.robot.radius_m, cfg.map)
    world.pose, world.stamp_ns = obs.pose, obs.stamp_ns


def _collided(world: World, obs: Observation, cfg: NavigateConfig) -> bool:
    moved = math.hypot(obs.pose.x_m - world.pose.x_m, obs.pose.y_m - world.pose.y_m)
    if cfg.control.mode == "discrete":
        forward = world.last is not None and world.last.action is Action.MOVE_FORWARD
        return forward and moved < cfg.explore.blocked_m
    asked_m = world.asked_mps * world.dt_s
    if asked_m <= 0 or moved >= asked_m / 4:
        world.blocked_s = 0.0
        return False
    world.blocked_s += world.dt_s
    if world.blocked_s < cfg.explore.blocked_s:
        return False
    world.blocked_s = 0.0
    return True


def driven(world: World, command: Command, cfg: NavigateConfig) -> Command:
    """The command with the velocity that begins its course, and the action that resembles it."""
    if command.action is Action.STOP:
        return command
    now = world.last.twist if world.last else STILL
    pose, radius_m, limits = world.pose, cfg.robot.radius_m, limited(world, cfg)
    twist = control.steer(command.course, pose, now, world.dt_s, radius_m, limits)
    return replace(command, action=control.nearest_action(twist), twist=twist)


def limited(world: World, cfg: NavigateConfig) -> ControlConfig:
    """How the robot may move now: one that sees nothing may turn, to see again, and no more."""
    return replace(cfg.control, max_speed_mps=0.0) if world.blind else cfg.control


def drive(world: World, field: planner.Field, cfg: NavigateConfig) -> tuple[Action, Course]:
    """The way down a field: an action, chosen only where actions are driven, and a course."""
    course = Along(world.terrain, field)
    if cfg.control.mode == "velocity":
        return Action.MOVE_FORWARD, course
    place = world.terrain, field, world.pose, cfg.robot.radius_m, cfg.control
    action = control.follow(*place)
    p = world.progress.get(world.aim)
    if p is None:
        return action or Action.TURN_LEFT, course
    if not step_search.clear(world.terrain, world.pose, p.plan, cfg.robot.radius_m, cfg.control):
        p.plan = ()
    if not p.plan and p.idle > (PATIENCE if action else 0):
        way = step_search.through(*place, best_m=p.run_m)
        p.plan, p.idle = way.actions, p.idle + (PATIENCE if way.actions else 0)
        if not way.actions and p.idle > math.tau / cfg.control.turn_rad:
            beyond = planner.descend(field, way.nearest_xy, BEYOND)[-1:]
            return _unwedge(world, beyond, action, cfg), course
    if p.plan:
        action, p.plan = p.plan[0], p.plan[1:]
    return action or Action.TURN_LEFT, course


def _unwedge(world: World, beyond_xy: F64, action: Action | None, cfg: NavigateConfig) -> Action:
    """After a whole turn in vain nothing is planned any more through what lies beyond where whole
    steps lead; nor through here, when no heading can be driven: then the robot squeezes out."""
    for x_m, y_m in beyond_xy:
        world.map.close(float(x_m), float(y_m), cfg.planner.dead_end_m)
    if action is not None:
        return action
    world.map.close(world.pose.x_m, world.pose.y_m, cfg.planner.dead_end_m)
    return control.squeeze(world.terrain, world.pose, cfg.control)


def arrived(world: World, field: planner.Field, cfg: NavigateConfig) -> bool:
    """Whether the robot is at a field's sources, or half a step from them and a step ahead would
    lead no nearer: whole steps do not end anywhere."""
    pose, step_m = world.pose, cfg.control.forward_m
    left = field.at(pose.x_m, pose.y_m)
    if cfg.control.mode == "velocity" or not 0 < left <= step_m / 2:
        return left <= 0
    x_m = pose.x_m + step_m * math.cos(pose.yaw_rad)
    return field.at(x_m, pose.y_m + step_m * math.sin(pose.yaw_rad)) >= left


def turn(world: World, xy: tuple[float, float], cfg: NavigateConfig) -> Action | None:
    """The turn that faces a point; None when it is faced."""
    if cfg.control.mode == "velocity":
        rate = control.face_rate(world.pose, xy, cfg.control)
        if rate is None:
            return None
        return Action.TURN_LEFT if rate > 0 else Action.TURN_RIGHT
    return control.face(world.pose, bearing((world.pose.x_m, world.pose.y_m), xy), cfg.control)


def dithers(world: World, aim: tuple[str, int], turn: Action, cfg: NavigateConfig) -> bool:
    """Whether turning toward a point does not end: the turn only undoes the one before (where the
    point is taken to be can change with the view), or it has gone on for too long."""
    undone = {Action.TURN_LEFT: Action.TURN_RIGHT, Action.TURN_RIGHT: Action.TURN_LEFT}.get(turn)
    last = world.last
    back = last is not None and last.mode == aim[0] and last.action is undone
    return (cfg.control.mode != "velocity" and back) or stalled(world, aim, None, cfg)


def stalled(
    world: World, aim: tuple[str, int], field: planner.Field | None, cfg: NavigateConfig
) -> bool:
    """Count steps (seconds, in velocity mode) toward one aim that did not bring the robot closer,
    and how often it turned away and back to it in vain; True when either is too many."""
    p = world.progress.setdefault(aim, Progress())
    if world.aim != aim:
        world.aim, p.run_m, p.idle, p.returns = aim, math.inf, 0.0, p.returns + 1
        p.plan = ()
    left = field.at(world.pose.x_m, world.pose.y_m) if field else math.inf
    if left < p.best_m - NEARER_M:
        p.best_m, p.returns = left, 0
    velocity = cfg.control.mode == "velocity"
    if left < p.run_m - NEARER_M:
        p.run_m, p.idle = left, 0.0
    elif not p.plan:
        p.idle += world.dt_s if velocity else 1
    patience = cfg.explore.patience_s if velocity else cfg.explore.patience
    if p.idle <= patience and p.returns <= cfg.explore.returns:
        return False
    del world.progress[aim]  # what is given up may be tried again, from the start
    return True
