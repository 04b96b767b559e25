"""The paper's Algorithm 2: perceive, decide, act. The loop calls the three; nothing here waits.

perceive: map, objects, rooms, frontiers.  decide: experts (DEFA) and consensus (CDM).
act: the target once it is believed, else the elected frontier; fast marching; one action.
"""

import math
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

import numpy as np

from runtime.core import (
    brief,
    consensus,
    control,
    frontiers,
    map,
    planner,
    semantics,
    target,
)
from runtime.core.brief import BriefConfig
from runtime.core.consensus import ConsensusConfig
from runtime.core.control import ControlConfig
from runtime.core.frontiers import FrontierConfig
from runtime.core.geometry import bearing
from runtime.core.map import MapConfig
from runtime.core.planner import PlannerConfig
from runtime.core.semantics import SemanticsConfig
from runtime.core.target import TargetConfig
from runtime.core.types import (
    Action,
    Ballot,
    Brief,
    Decision,
    Detections,
    Mount,
    Observation,
)
from runtime.core.world import (
    Command,
    Progress,
    Snapshot,
    World,
    toward,
    with_distances,
)

Deadline = TypeVar("Deadline", contravariant=True)
UNWEDGE = Action.TURN_LEFT  # when no heading can be driven: turn until one can, or patience ends


@dataclass(frozen=True)
class ExploreConfig:
    """[explore]"""

    first_looks: int = 12  # turns of the look around at the start
    decide_every: int = 5  # steps between decisions that only new evidence asks for
    arrived_m: float = 0.25  # from a frontier's goal point
    seen_range_m: float = 2.0  # frontier cells this close were looked at once the robot faced them
    patience: int = 24  # steps without coming closer to an aim before it is given up
    blocked_m: float = 0.08  # a step forward that moved less than this was a collision
    weak_log_odds: float = -1.0  # a target worth a look when nothing is left to explore


@dataclass(frozen=True)
class RobotConfig:
    """[robot]"""

    radius_m: float = 0.18


@dataclass(frozen=True)
class NavigateConfig:
    """The core's part of the configuration."""

    robot: RobotConfig = field(default_factory=RobotConfig)
    map: MapConfig = field(default_factory=MapConfig)
    semantics: SemanticsConfig = field(default_factory=SemanticsConfig)
    frontiers: FrontierConfig = field(default_factory=FrontierConfig)
    brief: BriefConfig = field(default_factory=BriefConfig)
    consensus: ConsensusConfig = field(default_factory=ConsensusConfig)
    planner: PlannerConfig = field(default_factory=PlannerConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    target: TargetConfig = field(default_factory=TargetConfig)
    explore: ExploreConfig = field(default_factory=ExploreConfig)


class Panel(Protocol[Deadline]):
    """Whoever answers a brief by a deadline; late and broken experts come back as missing."""

    def ask(self, brief: Brief, by: Deadline) -> Ballot: ...


def perceive(
    world: World, obs: Observation, detections: Detections, mount: Mount, cfg: NavigateConfig
) -> World:
    """Add one observation: navigation map, semantic map, frontiers with stable ids."""
    _notice_collision(world, obs, cfg)
    world.pose, world.stamp_ns = obs.pose, obs.stamp_ns
    world.visited_xy.append((obs.pose.x_m, obs.pose.y_m))
    world.grow(cfg.map.max_depth_m + 1.0)
    outline = map.integrate(world.map, obs, mount, cfg.robot.radius_m, cfg.map)
    semantics.place(world.semantic, world.map, obs, detections, outline, mount, cfg.semantics)
    return with_frontiers(world, cfg)


def with_frontiers(world: World, cfg: NavigateConfig) -> World:
    """The candidates of the map as it is now, and how far they are on foot."""
    terrain = planner.survey(world.map, world.pose, cfg.robot.radius_m, cfg.planner)
    world.seen = terrain, planner.march_from(terrain, world.pose.xy, unhurried=False)
    edge = frontiers.boundary(world.map, world.given_up, cfg.frontiers)
    parts = frontiers.components(edge, world.map.frame, cfg.frontiers.min_cells)
    named = frontiers.identify(world.memory, parts, world.map.frame, cfg.frontiers)
    with_distances(world, named)
    return world


def due(world: World, cfg: NavigateConfig) -> str:
    """Why a decision is due now; "" when it is not."""
    if world.looks_left > 0:
        return ""
    if world.decision is None:
        return "first decision"
    aim = world.frontier(world.decision.frontier)
    if world.decision.frontier is not None and aim is None:
        return f"frontier {world.decision.frontier} is gone"
    if aim is not None and not math.isfinite(aim.distance_m):
        return f"frontier {aim.id} cannot be reached"
    if aim is None and any(math.isfinite(f.distance_m) for f in world.frontiers):
        return "a frontier appeared"
    rested = world.step - world.decided_at >= cfg.explore.decide_every
    return "new evidence" if rested and _evidence(world, cfg) != world.evidence else ""


def snapshot(world: World, why: str, cfg: NavigateConfig) -> Snapshot:
    """What the decision will be made on, taken from the world and independent of it."""
    told = brief.compose(
        world.goal, world.stamp_ns, world.map, world.semantic, world.frontiers, cfg.brief
    )
    return Snapshot(told, world.frontiers, world.stamp_ns, why)


def decide(snap: Snapshot, panel: Panel[Deadline], by: Deadline, cfg: NavigateConfig) -> Decision:
    """DEFA and CDM: ask the experts, elect a frontier, else the closest."""
    ballot = panel.ask(snap.brief, by)
    return consensus.elect(ballot, snap.frontiers, cfg.consensus, snap.stamp_ns, snap.why)


def adopt(world: World, decision: Decision, cfg: NavigateConfig) -> None:
    """Make the decision the standing one."""
    world.decision, world.decided_at = decision, world.step
    world.evidence = _evidence(world, cfg)


def act(world: World, cfg: NavigateConfig) -> Command:
    """One action: finish the first look, else go to the target, else to the elected frontier."""
    command = (
        _look_around(world)
        or _approach_target(world, cfg)
        or _explore(world, cfg)
        or _finish(world, cfg)
    )
    world.step += 1
    world.last = command
    return command


def _look_around(world: World) -> Command | None:
    if world.looks_left <= 0:
        return None
    world.looks_left -= 1
    return Command(Action.TURN_LEFT, "look", None, "look around before the first decision")


def _approach_target(
    world: World, cfg: NavigateConfig, least: float | None = None
) -> Command | None:
    """Drive to where the target can be faced, face it, then stop if it is believed."""
    terrain, reach = world.terrain, world.reach
    instance = target.choose(world.semantic, world.goal, world.pose, cfg.target, least)
    if instance is None:
        return None
    stands = target.standpoints(world.map, terrain, reach, instance, cfg.target)
    if not stands.any():
        return None  # not reachable as far as the map goes: explore on
    believed = target.confirmed(instance, cfg.target)
    what = f"{instance.name} {instance.id} (p {instance.confidence:.2f})"
    row, col = terrain.frame.cell(world.pose.x_m, world.pose.y_m)
    if stands[row, col]:
        turn = control.face(
            world.pose, bearing((world.pose.x_m, world.pose.y_m), instance.xy), cfg.control
        )
        if turn is not None:
            return Command(turn, "face", instance.xy, f"face {what}")
        if believed:
            return Command(Action.STOP, "stop", instance.xy, f"found {what}")
        target.reject(instance, cfg.target)
        return _approach_target(world, cfg, least)
    field = planner.march(terrain, stands)
    if _stalled(world, ("target", instance.id), field, cfg):
        target.reject(instance, cfg.target)
        return _approach_target(world, cfg, least)
    action = control.follow(terrain, field, world.pose, cfg.robot.radius_m, cfg.control)
    verb = "approach" if believed else "inspect"
    command = Command(action or UNWEDGE, "target", instance.xy, f"{verb} {what}")
    return toward(field, world.pose, command)


def _explore(world: World, cfg: NavigateConfig) -> Command | None:
    """Drive to the elected frontier; on arrival face it, and give up what shows nothing new."""
    while world.decision is not None:
        id = consensus.successor(world.decision, world.frontiers)
        aim = world.frontier(id)
        if aim is None:
            return None
        here = (world.pose.x_m, world.pose.y_m)
        label = f"frontier {aim.id}"
        if aim.distance_m <= cfg.explore.arrived_m:
            turn = control.face(world.pose, bearing(here, aim.centre_xy), cfg.control)
            if turn is not None and not _stalled(world, ("frontier", aim.id), None, cfg):
                return Command(turn, "frontier", aim.goal_xy, f"face {label}")
            world.give_up(aim.cells_xy, cfg.explore.seen_range_m)
            with_frontiers(world, cfg)
            continue
        field = planner.march_from(world.terrain, np.array(aim.goal_xy))
        if _stalled(world, ("frontier", aim.id), field, cfg):
            world.give_up(aim.cells_xy)
            with_frontiers(world, cfg)
            continue
        action = control.follow(world.terrain, field, world.pose, cfg.robot.radius_m, cfg.control)
        command = Command(action or UNWEDGE, "frontier", aim.goal_xy, f"drive to {label}")
        return toward(field, world.pose, command)
    return None


def _finish(world: World, cfg: NavigateConfig) -> Command:
    """Nothing is left to explore: look at weak candidates, retry what was given up once, stop."""
    weak = _approach_target(world, cfg, cfg.explore.weak_log_odds)
    if weak is not None:
        return weak
    if not world.retried:
        world.retried = True
        world.given_up[:] = False
        with_frontiers(world, cfg)
        return Command(Action.TURN_LEFT, "look", None, "retry frontiers given up before")
    return Command(Action.STOP, "stop", None, f"no {world.goal} found and nothing left to explore")


def _stalled(
    world: World, aim: tuple[str, int], field: planner.Field | None, cfg: NavigateConfig
) -> bool:
    """Count steps toward one aim that did not bring the robot closer; True when it is too many."""
    p = world.progress
    if p.aim != aim:
        world.progress = p = Progress(aim)
    left = field.at(world.pose.x_m, world.pose.y_m) if field else math.inf
    if left < p.best_m - 0.05:
        p.best_m, p.idle = left, 0
    else:
        p.idle += 1
    return p.idle > cfg.explore.patience


def _notice_collision(world: World, obs: Observation, cfg: NavigateConfig) -> None:
    if world.last is None or world.last.action is not Action.MOVE_FORWARD:
        return
    moved = math.hypot(obs.pose.x_m - world.pose.x_m, obs.pose.y_m - world.pose.y_m)
    if moved < cfg.explore.blocked_m:
        world.collisions += 1
        world.map.bump(obs.pose, cfg.robot.radius_m, cfg.map)


def _evidence(world: World, cfg: NavigateConfig) -> tuple[object, ...]:
    """What makes a decision worth repeating when it changes: the confirmed objects, and the room
    type around each reachable frontier."""
    objects = tuple(
        i.id
        for i in world.semantic.instances.values()
        if i.confidence >= cfg.brief.object_confidence
    )
    rooms = tuple(
        (f.id, world.semantic.room_around(world.map.frame, f.goal_xy, cfg.brief.room_range_m))
        for f in world.frontiers
        if math.isfinite(f.distance_m)
    )
    return objects, rooms
