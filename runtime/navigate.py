"""The paper's Algorithm 2: perceive, decide, act. The loop calls the three; nothing here waits.

perceive: map, objects, rooms, frontiers.  decide: experts (DEFA) and consensus (CDM).
act: the target once it is believed, else the elected frontier; fast marching; one action.
"""

import math
from dataclasses import replace
from typing import Protocol, TypeVar

from runtime.core import destination, homeward, progress
from runtime.core.approach import approach_target, out_of_reach, settle_for
from runtime.core.destination import Destination
from runtime.core.exploration import explore, try_resort, with_frontiers
from runtime.core.hinted import look_where_said
from runtime.core.leaving import leave
from runtime.core.local_policy import local_policy
from runtime.core.looking_closer import doubts, look_closer, missed_patches
from runtime.core.mapping import coverage, grid, keyframes, scanning
from runtime.core.mapping.zones import Zone
from runtime.core.motion.contact import Met
from runtime.core.motion.courses import Spin
from runtime.core.objects import semantic_map
from runtime.core.outlook import Outlook, around
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig as NavigateConfig
from runtime.core.trying_again import look_again
from runtime.core.types import (
    F64,
    Action,
    Ballot,
    Brief,
    Decision,
    Detections,
    Mount,
    Observation,
    SearchState,
)
from runtime.core.voting import brief, consensus, prior
from runtime.core.voting.brief import SemanticCopy
from runtime.core.world import Command, Mode, NewestImage, Snapshot, StandingDecision, World

ROOM_M = 20.0  # around the robot, frontiers are told to be in its own room or not
WEAK_LOG_ODDS = -1.0  # a target worth a look when nothing is left to explore
FAINT_LOG_ODDS = -3.0  # and at the very last
SHUT_IN_M2 = 1.0  # of free floor in all: no home has less
Deadline = TypeVar("Deadline", contravariant=True)


class Experts(Protocol[Deadline]):
    """Whoever answers a brief by a deadline; late and broken experts come back as missing."""

    def ask(self, brief: Brief, by: Deadline) -> Ballot: ...


def perceive(
    world: World, obs: Observation, detections: Detections, mount: Mount, cfg: NavigateConfig
) -> World:
    """Add one observation: navigation map and frontiers with stable ids, then semantic map. Where
    the detector may be late, the two are called apart."""
    outline = survey(world, obs, mount, cfg)
    return place(world, obs, detections, outline, mount, cfg)


def reach_m(cfg: NavigateConfig) -> float:
    """How far to each side of the robot the map reaches."""
    return cfg.map.max_depth_m + 1.0


def survey(
    world: World, obs: Observation, mount: Mount, cfg: NavigateConfig, led: bool = False
) -> F64:
    """What depth and laser tell: navigation map, frontiers with stable ids. Returns the view's
    outline, (V, 2) m in the map frame, which `place` wants with the same observation. `led`:
    somebody else drives."""
    if led:
        progress.led(world, obs)
    else:
        progress.advance(world, obs, cfg)
    world.lens = obs.intrinsics, mount
    world.body.been(obs.pose)
    world.grow(reach_m(cfg))
    robot = cfg.robot
    outline = grid.integrate(
        world.map, obs, mount, robot.radius_m, robot.height_m, cfg.map.max_depth_m
    )
    if obs.scan is not None:
        scanning.add_scan(world.map, obs.scan, obs.pose, robot.radius_m, cfg.map.max_depth_m)
    coverage.look(world.explored.looked, world.map.frame, outline)
    with_frontiers(world, cfg)
    return outline


def place(
    world: World,
    obs: Observation,
    detections: Detections,
    outline: F64,
    mount: Mount,
    cfg: NavigateConfig,
) -> World:
    """What the detector tells of an observation that was surveyed, now or a while ago: semantic map
    and keyframes."""
    names = semantic_map.place(world.semantic, world.map, obs, detections, outline, mount)
    called = frozenset(id for id, those in names.items() if world.goal in those)
    world.newest = NewestImage(obs, mount, called)
    if cfg.search.last_looks == "closer":
        world.explored.closer.fineness.look(world.map, obs, mount, cfg.map.max_depth_m)
    if detections.scene.size or cfg.keyframes.image_width_px:
        width_px = cfg.keyframes.image_width_px
        keyframes.consider(world.keyframes, obs, detections, mount, width_px)
    return world


def due(world: World, cfg: NavigateConfig) -> str:
    """Why a decision is due now; "" when it is not."""
    decision = world.standing.decision
    if world.explored.looks_left > 0:
        return ""
    if decision is None:
        return "first decision"
    aim = world.frontier(decision.frontier)
    if decision.frontier is not None and aim is None:
        return f"frontier {decision.frontier} is gone"
    if aim is not None and not math.isfinite(aim.distance_m):
        return f"frontier {aim.id} cannot be reached"
    if aim is None and any(math.isfinite(f.distance_m) for f in world.frontiers):
        return "a frontier appeared"
    rested = local_policy(cfg).rested(world)
    return "new evidence" if rested and _evidence(world) != world.standing.evidence else ""


def snapshot(world: World, why: str, cfg: NavigateConfig) -> Snapshot:
    """What the decision will be made on, taken from the world and independent of it."""
    return outlook(world, why, cfg).snapshot


def outlook(world: World, why: str, cfg: NavigateConfig) -> Outlook:
    """The same, still to be worked out, by whoever asks for it first: taking it costs next to
    nothing but for what was not seen finely enough, 2 ms for a flat, where that is kept."""
    candidates = tuple(f for f in world.frontiers if math.isfinite(f.distance_m))
    decision, frame = world.standing.decision, world.map.frame
    window, ranked = around(candidates, frame), cfg.consensus.fallback != "closest"
    copy = world.map.copied(window)
    if world.map.zones.zones:
        barred = world.map.zones.barred(frame)[window]
        copy = replace(copy, free=copy.free & ~barred, unknown=copy.unknown & ~barred)
    return Outlook(
        world.goal,
        world.stamp_ns,
        why,
        candidates,
        copy,
        SemanticCopy.of(world.semantic, world.map, candidates, window),
        tuple(world.keyframes),
        world.pose,
        world.terrain.around(world.pose, ROOM_M) if ranked else None,
        decision,
        cfg.consensus.plans,
        missed_patches(world) if ranked else (),
    )


def decide(
    snap: Snapshot | Outlook, panel: Experts[Deadline], by: Deadline, cfg: NavigateConfig
) -> Decision:
    """DEFA and CDM: ask the experts, elect a frontier, else the fallback's."""
    ballot = panel.ask(snap.brief, by)
    return consensus.elect(
        ballot, snap.frontiers, cfg.consensus, snap.stamp_ns, snap.why, snap.brief.order,
        snap.brief.ahead,
    )  # fmt: skip


def adopt(world: World, decision: Decision) -> None:
    """Make the decision the standing one. What the experts said of other frontiers that are still
    there is remembered with it."""
    body, living = world.body, world.explored.memory.cells_xy
    decision = prior.remembering(decision, world.standing.decision, living)
    world.standing = StandingDecision(decision, body.step, body.elapsed_s, _evidence(world))


def act(world: World, cfg: NavigateConfig) -> Command:
    """What to do now: finish the first look, else leave what is kept out of, else go to the target,
    else to where it was said to be, else to the elected frontier, else look again at ways that were
    closed. Whoever sends the command books what was sent (`steer`, `BaseState.told`)."""
    command = (
        _look_around(world, cfg)
        or leave(world, cfg)
        or approach_target(world, cfg)
        or look_where_said(world, cfg)
        or explore(world, cfg)
        or look_again(world, cfg)
        or _finish(world, cfg)
    )
    world.body.step += 1
    return command


def feel_edges(world: World, felt: bool) -> None:
    """Whether sensors under the body tell where the floor ends: then they decide, not doubt."""
    openings = world.map.openings
    if openings.edges_felt != felt:
        openings.edges_felt = felt
        if world.map.doubtful.any():
            world.map.changed()


def keep_out(world: World, zones: tuple[Zone, ...]) -> None:
    """Have these zones on the map, in place of those before."""
    window = world.map.zones.put(zones, world.map.frame)
    if window is not None:
        world.map.touched(window)


def meet(world: World, met: Met, cfg: NavigateConfig) -> None:
    """Have in the map what the body has met since the observation before."""
    progress.meet(world, met, cfg)


def go_to(world: World, to: Destination, cfg: NavigateConfig) -> Command:
    """In place of `act`: the step to a place, and there its end. Where no way is known the robot
    looks round, and explores toward it."""
    command = (
        leave(world, cfg)
        or destination.known_way(world, to, cfg)
        or _look_around(world, cfg)
        or destination.explore_toward(world, to, cfg)
    )
    world.body.step += 1
    return command


def go_back(world: World, why: str, start_xy: tuple[float, float], cfg: NavigateConfig) -> Command:
    """In place of `act`: the step back to where the search began, and there its end."""
    command = homeward.go_back(world, why, start_xy, cfg)
    world.body.step += 1
    return command


def steer(world: World, command: Command, cfg: NavigateConfig) -> Command:
    """The command as a base that hears one an observation is told it."""
    return world.body.told(local_policy(cfg).steer(world, command))


def _look_around(world: World, cfg: NavigateConfig) -> Command | None:
    if not local_policy(cfg).looks_on(world):
        return None
    why = "look around before the first decision"
    return Command(Action.TURN_LEFT, Mode.LOOK, None, why, course=Spin(cfg.control.look_radps))


def _finish(world: World, cfg: NavigateConfig) -> Command:
    """No frontier is left: look at weak candidates, then take the next of the last resorts; after
    them stop."""
    explored = world.explored
    last = explored.resort is Resort.FAINT
    weak = approach_target(world, cfg, FAINT_LOG_ODDS if last else WEAK_LOG_ODDS)
    if weak is not None:
        return weak
    looks = cfg.search.last_looks
    if looks == "closer" and explored.resort >= Resort.CLOSER:
        closer = look_closer(world, cfg)
        if closer is not None:
            return closer
    resort = explored.resort.next(looks)
    if resort is None:
        waits = look_again(world, cfg, wait=True)
        return waits or settle_for(world, cfg) or _nothing_left(world)
    return try_resort(world, resort, cfg)


def _nothing_left(world: World) -> Command:
    thing = out_of_reach(world)
    if thing is not None:
        x, y = thing.xy
        why = f"{world.goal} {thing.id} was seen at ({x:.1f}, {y:.1f}), and no way leads there"
        return Command(Action.STOP, Mode.STOP, thing.xy, why, ended=SearchState.UNREACHABLE)
    shut_in = _shut_in(world)
    most = "" if shut_in else _in_doubt(world)
    why = f"no {world.goal} found and nothing left to explore{most}{_closed(world)}{shut_in}"
    return Command(Action.STOP, Mode.STOP, None, why, ended=SearchState.NOT_FOUND)


def _in_doubt(world: World) -> str:
    """Where the goal is likeliest to have been missed, as far as that is kept."""
    by = "by the detector's recall at its size it is most likely still"
    return "".join(f"; {by} {doubt}" for doubt in doubts(world)[:1])


def _closed(world: World) -> str:
    """Which ways were open before, and were not when they were looked at again."""
    shut = (way.xy for way in world.explored.passages.still_closed)
    places = ", ".join(f"({x:.1f}, {y:.1f})" for x, y in shut)
    return f"; what is beyond {places} could not be reached any more" if places else ""


def _shut_in(world: World) -> str:
    """What to look at where a search ended with next to no floor: a camera that is on its side sees
    none, and without a floor nothing else tells of that."""
    if world.map.free.sum() * world.map.frame.resolution_m**2 >= SHUT_IN_M2:
        return ""
    return (
        ": hardly any free floor was seen: the robot is shut in, or its camera is not mounted as "
        "[camera] has it (rfnav calibrate, rfnav doctor --turn)"
    )


def _evidence(world: World) -> tuple[object, ...]:
    """What makes a decision worth repeating when it changes: the confirmed objects, and the room
    type around each reachable frontier."""
    rooms = tuple(
        (f.id, world.semantic.room_around(world.map.frame, f.goal_xy, brief.ROOM_RANGE_M))
        for f in world.frontiers
        if math.isfinite(f.distance_m)
    )
    return world.semantic.catalogue.sure, rooms
