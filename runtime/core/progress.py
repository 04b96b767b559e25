"""What became of the robot's steps: time, turns, collisions; and when an aim is given up."""

import math

import numpy as np

from runtime.core.distances.planner import Field
from runtime.core.geometry import wrap_angle
from runtime.core.local_policy import local_policy
from runtime.core.motion.contact import Met, Touch
from runtime.core.objects.gone import hidden
from runtime.core.objects.instances import Instance
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Observation, Pose
from runtime.core.world import Aim, Progress, Pursuit, World

BLIND_SHARE = 0.02  # of the depth image; with less of it no velocity leads forward
RETURNS = 8  # so often the robot turns back to an aim in vain before it is given up
NEARER_M = 0.05  # what counts as having come closer
HERE_M, HERE_RAD = 0.15, 0.2  # an image from so near by shows what is seen from here
EDGE_M = (-0.12, 0.0, 0.12)  # beside where the floor was felt to end, it is taken to end as well


def advance(world: World, obs: Observation, cfg: NavigateConfig) -> None:
    """Book what happened since the observation before: time, turn, a collision."""
    body = world.body
    since_s = (obs.stamp_ns - world.stamp_ns) / 1e9 if world.stamp_ns else 0.0
    body.dt_s = min(1.0, max(0.0, since_s))
    body.elapsed_s += body.dt_s
    body.free_s += 0.0 if body.held else body.dt_s
    body.blind = _blind(obs)
    body.turned_rad += wrap_angle(obs.pose.yaw_rad - world.pose.yaw_rad)
    if local_policy(cfg).blocked(world, obs):
        body.collisions += 1
        world.map.bump(obs.pose, cfg.robot.radius_m)
    world.pose, world.stamp_ns = obs.pose, obs.stamp_ns


def led(world: World, obs: Observation) -> None:
    """The same of a robot that somebody else drives: only where it is, for no time of the search
    passes. What it was after counts from here on, and the decision was one from elsewhere."""
    body = world.body
    body.dt_s, body.asked_mps, body.blocked_s, body.blind = 0.0, 0.0, 0.0, _blind(obs)
    world.pursuit = Pursuit()
    world.standing.evidence = ()
    world.pose, world.stamp_ns = obs.pose, obs.stamp_ns


def meet(world: World, met: Met, cfg: NavigateConfig) -> None:
    """Have in the map what the body has met; no look takes it out again."""
    at, ahead_rad = met.pose, met.pose.yaw_rad + met.bearing_rad
    c, s = math.cos(ahead_rad), math.sin(ahead_rad)
    world.body.collisions += met.touch is Touch.BUMPER
    for aside_m in EDGE_M if met.touch is Touch.CLIFF else (0.0,):
        facing = Pose(at.x_m - aside_m * s, at.y_m + aside_m * c, ahead_rad)
        world.map.bump(facing, cfg.robot.radius_m)


def dithers(world: World, aim: Aim, turn: Action, cfg: NavigateConfig) -> bool:
    """Whether turning toward a point does not end: the turn only undoes the one before (where the
    point is taken to be can change with the view), or it has gone on for too long."""
    return local_policy(cfg).undoes(world, turn) or stalled(world, aim, None, cfg)


def stalled(world: World, aim: Aim, field: Field | None, cfg: NavigateConfig) -> bool:
    """Count the effort toward one aim that did not bring the robot closer, and how often it turned
    away and back to it in vain; True when either is too much."""
    policy, pursuit = local_policy(cfg), world.pursuit
    p = pursuit.progress.setdefault(aim, Progress())
    if pursuit.aim != aim:
        pursuit.aim, p.run_m, p.idle, p.returns = aim, math.inf, 0.0, p.returns + 1
        p.plan = ()
    left = field.at(world.pose.x_m, world.pose.y_m) if field else math.inf
    if left < p.best_m - NEARER_M:
        p.best_m, p.returns = left, 0
    if left < p.run_m - NEARER_M:
        p.run_m, p.idle = left, 0.0
    elif not p.plan:
        p.idle += policy.effort(world)
    if p.idle <= policy.patience and p.returns <= RETURNS:
        return False
    del pursuit.progress[aim]  # what is given up may be tried again, from the start
    return True


def looked_from_here(world: World) -> bool:
    """Whether the newest image that the detector has seen was taken about where the robot stands:
    it may be behind, and a verdict is of what is seen from here."""
    if world.newest is None:
        return False
    then, now = world.newest.obs.pose, world.pose
    turned_rad = abs(wrap_angle(now.yaw_rad - then.yaw_rad))
    return turned_rad <= HERE_RAD and float(np.hypot(*(now.xy - then.xy))) <= HERE_M


def hidden_from_here(world: World, thing: Instance) -> bool:
    """Whether that image is of here, calls a thing nothing, and does not show its place."""
    image = world.newest
    if image is None or thing.id in image.called or not looked_from_here(world):
        return False
    return hidden(thing, image.obs, image.mount)


def _blind(obs: Observation) -> bool:
    return int(np.count_nonzero(obs.depth_m > 0)) < BLIND_SHARE * obs.depth_m.size
