"""The paper's Algorithm 2: perceive, decide, act. The loop calls the three; nothing here waits.

perceive: map, objects, rooms, frontiers.  decide: experts (DEFA) and consensus (CDM).
act: the target once it is believed, else the elected frontier; fast marching; one action.
"""

import functools
import math
from dataclasses import replace
from typing import Protocol, TypeVar

from runtime.core import progress
from runtime.core.distances import planner
from runtime.core.mapping import coverage, frontiers, grid, keyframes
from runtime.core.motion.control import Spin, Toward
from runtime.core.objects import semantic_map
from runtime.core.objects import standpoints as target
from runtime.core.settings import NavigateConfig as NavigateConfig
from runtime.core.types import (
    Action,
    Ballot,
    Brief,
    Decision,
    Detections,
    Mount,
    Observation,
)
from runtime.core.voting import brief, consensus, information_gain
from runtime.core.world import (
    RESORTS,
    Command,
    Snapshot,
    World,
    toward,
    with_distances,
)

Deadline = TypeVar("Deadline", contravariant=True)


class Experts(Protocol[Deadline]):
    """Whoever answers a brief by a deadline; late and broken experts come back as missing."""

    def ask(self, brief: Brief, by: Deadline) -> Ballot: ...


def perceive(
    world: World, obs: Observation, detections: Detections, mount: Mount, cfg: NavigateConfig
) -> World:
    """Add one observation: navigation map, semantic map, frontiers with stable ids."""
    progress.advance(world, obs, cfg)
    world.lens = obs.intrinsics, mount
    world.visited_xy.append((obs.pose.x_m, obs.pose.y_m))
    world.grow(cfg.map.max_depth_m + 1.0)
    outline = grid.integrate(world.map, obs, mount, cfg.robot.radius_m, cfg.map)
    coverage.look(world.looked, world.map.frame, outline, cfg.coverage)
    semantic_map.place(world.semantic, world.map, obs, detections, outline, mount, cfg.semantics)
    if detections.scene.size or cfg.keyframes.image_width_px:
        frame = keyframes.take(obs, detections, mount, cfg.keyframes)
        keyframes.keep(world.keyframes, frame, cfg.keyframes)
    return with_frontiers(world, cfg)


def with_frontiers(world: World, cfg: NavigateConfig) -> World:
    """The candidates of the map as it is now, and how far they are on foot."""
    frame = world.map.frame
    radius_m = cfg.robot.radius_m
    world.seen = planner.look_around(world.map, world.pose, radius_m, cfg.planner, world.tight)
    edge = frontiers.boundary(world.map, world.given_up, cfg.frontiers)
    parts = frontiers.components(edge, frame, cfg.frontiers.min_cells)
    if world.thorough:
        dim = coverage.overlooked(world.map, world.looked, world.given_up) & ~edge
        parts += frontiers.components(dim, frame, cfg.coverage.min_cells)
    named = frontiers.identify(world.memory, parts, frame, cfg.frontiers)
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
    if cfg.control.mode == "velocity":
        rested = world.elapsed_s - world.decided_s >= cfg.explore.decide_every_s
    return "new evidence" if rested and _evidence(world, cfg) != world.evidence else ""


def snapshot(world: World, why: str, cfg: NavigateConfig) -> Snapshot:
    """What the decision will be made on, taken from the world and independent of it."""
    frames = world.keyframes
    candidates = tuple(f for f in world.frontiers if math.isfinite(f.distance_m))
    views = {
        f.id: keyframes.best_view(frames, f.cells_xy, world.map, cfg.keyframes) for f in candidates
    }
    told = brief.compose(
        world.goal, world.stamp_ns, world.map, world.semantic, candidates, views, cfg.brief
    )
    told = brief.worthwhile(told, cfg.explore.worth_m2)
    unknown_m2 = {f.id: f.unknown_m2 for f in told.frontiers}
    order: tuple[int, ...] = ()
    if cfg.consensus.fallback == "geometry":
        standing = world.decision.frontier if world.decision else None
        order = information_gain.ranked(
            candidates, unknown_m2, standing, world.terrain, world.pose, cfg.gain
        )
    candidates = tuple(f for f in candidates if f.id in unknown_m2)
    return Snapshot(replace(told, order=order), candidates, world.stamp_ns, why)


def decide(snap: Snapshot, panel: Experts[Deadline], by: Deadline, cfg: NavigateConfig) -> Decision:
    """DEFA and CDM: ask the experts, elect a frontier, else the fallback's."""
    ballot = panel.ask(snap.brief, by)
    return consensus.elect(
        ballot, snap.frontiers, cfg.consensus, snap.stamp_ns, snap.why, snap.brief.order
    )


def adopt(world: World, decision: Decision, cfg: NavigateConfig) -> None:
    """Make the decision the standing one."""
    world.decision, world.decided_at, world.decided_s = decision, world.step, world.elapsed_s
    world.evidence = _evidence(world, cfg)


def act(world: World, cfg: NavigateConfig) -> Command:
    """One action, and in velocity mode the course behind it: finish the first look, else go to the
    target, else to the elected frontier."""
    command = (
        _look_around(world, cfg)
        or _approach_target(world, cfg)
        or _explore(world, cfg)
        or _finish(world, cfg)
    )
    if cfg.control.mode == "velocity":
        command = progress.driven(world, command, cfg)
    world.step += 1
    world.last, world.asked_mps = command, command.twist.v_mps
    return command


def _look_around(world: World, cfg: NavigateConfig) -> Command | None:
    if world.looks_left <= 0:
        return None
    world.looks_left -= 1
    if cfg.control.mode == "velocity":
        whole = cfg.explore.first_looks * cfg.control.turn_rad
        late = world.elapsed_s > 3 * whole / cfg.control.look_radps
        world.looks_left = 0 if late or world.turned_rad >= whole else cfg.explore.first_looks
        if not world.looks_left:
            return None
    why = "look around before the first decision"
    return Command(Action.TURN_LEFT, "look", None, why, course=Spin(cfg.control.look_radps))


def _approach_target(
    world: World, cfg: NavigateConfig, least: float | None = None
) -> Command | None:
    """Drive to where the target can be faced, face it, then stop if it is believed; else look from
    another side, then stop or reject it."""
    away = functools.partial(target.on_foot_m, world.reach, cfg.target)
    standing = world.aim[1] if world.aim[0] in ("target", "side", "face") else None
    for instance in target.ranked(world.semantic, world.goal, away, cfg.target, least, standing):
        alone = target.apart(instance, world.semantic, cfg.target)
        place = world.map, world.terrain, world.reach, alone, world.goal, cfg.target
        stands = target.standpoints(*place, world.seen_from_m(instance.high_m))
        if stands.any():
            break
    else:
        return None  # none, or not reachable as far as the map goes: explore on
    again = target.wants_other_side(instance, world.goal, cfg.target)
    if again:
        stands = target.other_sides(*place)
        if not stands.any():
            target.no_other_side(instance, world.goal, world.pose, cfg.target)
            return _approach_target(world, cfg, least)
    what = f"{world.goal} {instance.id} (p {instance.confidence_of(world.goal):.2f})"
    field = planner.approach(world.terrain, stands, world.reach, world.pose)
    if progress.arrived(world, field, cfg):
        turn = progress.turn(world, instance.xy, cfg)
        if turn is not None and not progress.dithers(world, ("face", instance.id), turn, cfg):
            facing = Toward(instance.xy)
            return Command(turn, "face", instance.xy, f"face {what}", course=facing)
        if target.judge(instance, world.goal, world.pose, cfg.target):
            return Command(Action.STOP, "stop", instance.xy, f"found {what}")
        return _approach_target(world, cfg, least)
    if progress.stalled(world, ("side" if again else "target", instance.id), field, cfg):
        if again:
            target.no_other_side(instance, world.goal, world.pose, cfg.target)
        else:
            target.reject(instance, world.goal, cfg.target)
        return _approach_target(world, cfg, least)
    verb = "approach" if target.confirmed(instance, world.goal, cfg.target) else "inspect"
    action, course = progress.drive(world, field, cfg)
    why = f"{verb} {what}{' from another side' if again else ''}"
    command = Command(action, "target", instance.xy, why, course=course)
    return toward(field, world.pose, command)


def _explore(world: World, cfg: NavigateConfig) -> Command | None:
    """Drive to the elected frontier; on arrival face it, and give up what shows nothing new."""
    while world.decision is not None:
        id = consensus.successor(world.decision, world.frontiers, cfg.consensus.rank)
        aim = world.frontier(id)
        if aim is None:
            return None
        label = f"frontier {aim.id}"
        if aim.distance_m <= cfg.explore.arrived_m:
            turn = progress.turn(world, aim.centre_xy, cfg)
            if turn is not None and not progress.stalled(world, ("frontier", aim.id), None, cfg):
                facing = Toward(aim.centre_xy)
                return Command(turn, "frontier", aim.goal_xy, f"face {label}", course=facing)
            world.give_up(aim.cells_xy, cfg.explore.seen_range_m)
            with_frontiers(world, cfg)
            continue
        goal = planner.cells_at(world.terrain, aim.goal_xy)
        field = planner.approach(world.terrain, goal, world.reach, world.pose)
        if progress.stalled(world, ("frontier", aim.id), field, cfg):
            world.give_up(aim.cells_xy)
            with_frontiers(world, cfg)
            continue
        action, along = progress.drive(world, field, cfg)
        command = Command(action, "frontier", aim.goal_xy, f"drive to {label}", course=along)
        return toward(field, world.pose, command)
    return None


def _finish(world: World, cfg: NavigateConfig) -> Command:
    """No frontier is left: look at weak candidates, then take the next of the last resorts; after
    them stop."""
    least = cfg.explore.faint_log_odds if world.desperate else cfg.explore.weak_log_odds
    weak = _approach_target(world, cfg, least)
    if weak is not None:
        return weak
    if world.resorts == len(RESORTS):
        return Command(
            Action.STOP, "stop", None, f"no {world.goal} found and nothing left to explore"
        )
    what = RESORTS[world.resorts]
    world.resorts += 1
    if world.resorts == 1:
        world.given_up[:], world.map.dead_end[:] = False, False
    with_frontiers(world, cfg)
    return Command(Action.TURN_LEFT, "look", None, what, course=Spin(cfg.control.look_radps))


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
