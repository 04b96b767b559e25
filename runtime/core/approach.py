"""Going to the target: from candidates to one that is faced, and believed or rejected."""

import functools
import math
from dataclasses import dataclass

import numpy as np

from runtime.core import progress
from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain
from runtime.core.local_policy import local_policy
from runtime.core.mapping.grid import NavigationMap
from runtime.core.motion.courses import Toward
from runtime.core.objects import candidates, standpoints
from runtime.core.objects.gone import LOOKS
from runtime.core.objects.instances import Instance
from runtime.core.objects.verdict import (
    INSPECT_LOG_ODDS,
    Reached,
    Verdict,
    confirmed,
    settle,
    supported,
    verdict,
)
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Mask, SearchState
from runtime.core.world import Aim, AimKind, Command, Mode, World, toward

TRIES = 3  # in vain, at what is believed and comes no nearer, after which it is left


@dataclass(frozen=True)
class _Candidate:
    """What is gone to as the goal, perhaps, and from where it can be faced."""

    instance: Instance
    stands: Mask  # empty: it was seen from one side, and there is no other to stand on
    again: bool  # it is looked at from another side
    exactly: bool = False  # half a step from there it is out of the image


def approach_target(
    world: World, cfg: NavigateConfig, least: float | None = None
) -> Command | None:
    """Drive to where the target can be faced, face it, then stop if it is believed; else look from
    another side, then stop or reject it. None when no candidate is left, or none that can be
    reached as far as the map goes. With `least` what the way was lost to is tried again, too,
    whatever has been seen since."""
    while (candidate := _candidate(world, least)) is not None:
        thing, goal = candidate.instance, world.goal
        reached, command = _toward(world, candidate, cfg)
        if command is not None:
            return command
        if reached is Reached.HELD_UP and _near_enough(world, candidate):
            world.halted[thing.id] = world.pose
            continue
        held = thing.id in world.halted
        if reached is Reached.FACED and progress.hidden_from_here(world, thing) and not held:
            reached = Reached.UNSEEN
        outcome = verdict(thing, goal, reached)
        if reached in (Reached.FACED, Reached.UNSEEN):
            world.held_up.pop(thing.id, None)
            world.sought.discard(thing.id)
        elif reached is Reached.HELD_UP and (
            thing.id in world.held_up or (outcome is Verdict.REJECT and supported(thing, goal))
        ):
            world.held_up.setdefault(thing.id, []).append(world.pose)
        if outcome is not Verdict.FOUND:
            world.halted.pop(thing.id, None)
        settle(thing, goal, outcome, world.pose)
        world.semantic.learnt((thing,))
        if outcome is Verdict.FOUND:
            what, found = f"found {_named(thing, goal)}", SearchState.FOUND
            return Command(Action.STOP, Mode.STOP, thing.xy, what, ended=found)
    return None


def _near_enough(world: World, candidate: _Candidate) -> bool:
    """Whether what is come no nearer to can be judged from here: it is about as near as what is
    low is stood before, and no wall hides it. Once, until the verdict."""
    thing, reaches_m = candidate.instance, world.explored.closer.wanted.reaches_m
    if candidate.again or thing.id in world.halted:
        return False
    return standpoints.stands_before(*_place(world, thing), world.pose, reaches_m)


def settle_for(world: World, cfg: NavigateConfig) -> Command | None:
    """When nothing else is left to try: go back before what was likest the goal of all that was
    stood before and not believed, and end there as found, saying so. None where nothing was."""
    while (thing := _likest(world)) is not None:
        _, before = world.doubted[thing.id]
        stands = standpoints.close_to(world.terrain, world.reach, before.xy)
        reached, command = _toward(world, _Candidate(thing, stands, False), cfg)
        if command is not None:
            return command
        odds, _ = world.doubted.pop(thing.id)
        if reached is Reached.FACED:
            what = f"{world.goal} {thing.id} (p {1 / (1 + math.exp(-odds)):.2f})"
            why = f"found {what}, the likest of all that was seen"
            return Command(Action.STOP, Mode.STOP, thing.xy, why, ended=SearchState.FOUND)
    return None


def _doubt(world: World, thing: Instance) -> None:
    """Remember what is stood before, if enough speaks for it, and the nearest of its looks: it may
    be left, by what is seen of it next."""
    looks = [*thing.looks, world.pose]
    now = thing.odds_of(world.goal), min(looks, key=lambda pose: math.dist(pose.xy, thing.xy))
    if now[0] >= INSPECT_LOG_ODDS:
        before = world.doubted.get(thing.id, now)
        world.doubted[thing.id] = now if now[0] > before[0] else before


def _likest(world: World) -> Instance | None:
    things = (world.semantic.instances.get(id) for id in world.doubted)
    there = [thing for thing in things if thing is not None and thing.seen_through < LOOKS]
    return max(there, key=lambda thing: (world.doubted[thing.id][0], -thing.id), default=None)


def out_of_reach(world: World) -> Instance | None:
    """What is believed to be the goal and was never stood before, when nothing else is left to try:
    the surest, or None. What has gone since is none."""
    goal = world.goal
    beyond = [
        thing
        for thing in world.semantic.called(goal)
        if (thing.id in world.held_up or supported(thing, goal)) and thing.seen_through < LOOKS
    ]
    return max(beyond, key=lambda thing: (thing.confidence_of(goal), -thing.id), default=None)


def _candidate(world: World, least: float | None) -> _Candidate | None:
    """The candidate that is gone to first, of those that can be faced from somewhere; and books
    which of them can be no more."""
    found = _first(world, least)
    first = found.instance if found is not None else None
    if first is not None and supported(first, world.goal):
        world.sought.add(first.id)
    for id in sorted(world.sought - world.held_up.keys()):
        thing = world.semantic.instances.get(id)
        if thing is None or thing.odds_of(world.goal) < candidates.KEEP_LOG_ODDS:
            world.sought.discard(id)  # by what was seen on the way there
        elif thing is not first and not _stands(world, thing).any():
            world.held_up[id] = []
    return found


def _first(world: World, least: float | None) -> _Candidate | None:
    """Of the candidates, in their order."""
    aim, goal = world.pursuit.aim, world.goal
    after = aim.kind in (AimKind.TARGET, AimKind.SIDE, AimKind.FACE)
    said = candidates.said_places(world.semantic, world.explored.hint.near)
    away = functools.partial(candidates.as_said_m, world.reach, said)
    standing, owed = aim.id if after else None, _owed(world) if least is not None else ()
    last = world.explored.resort is Resort.FAINT
    for thing in candidates.ranked(world.semantic, goal, away, least, standing, owed, last):
        stands = _stands(world, thing)
        if not stands.any():
            continue
        again = verdict(thing, goal, Reached.ON_THE_WAY) is Verdict.OTHER_SIDE
        if again:
            stands = standpoints.other_sides(*_place(world, thing), goal)
        off = max(world.standoff(thing)) > standpoints.STOP_M
        exactly = off and not again and not thing.unseen
        return _Candidate(thing, stands, again, exactly)
    return None


def _stands(world: World, thing: Instance) -> Mask:
    """From where it can be faced; what the way was lost to, from any side but where it was come no
    nearer to; what was not in the image from there, from a little farther or beside."""
    place, tried = _place(world, thing), world.held_up.get(thing.id)
    if thing.id in world.halted:
        return standpoints.close_to(world.terrain, world.reach, world.halted[thing.id].xy)
    standoff = world.standoff(thing)
    if thing.unseen:
        standoff = standpoints.stepped_back(standoff)
    close = standoff, world.explored.closer.wanted.reaches_m
    stands = standpoints.standpoints(*place, world.goal, *close)
    if thing.unseen:
        stands = standpoints.elsewhere(world.terrain, stands, thing.unseen)
    if tried is None or stands.any():
        return stands
    return standpoints.any_side(*place, tried, *close)


def _place(world: World, thing: Instance) -> tuple[NavigationMap, Terrain, Field, Instance]:
    """Where it is, and what of it is its own."""
    alone = candidates.apart(thing, world.semantic)
    return world.map, world.terrain, world.reach, alone


def _owed(world: World) -> set[int]:
    """What the way was lost to, and was not yet tried again so often."""
    tried = {id: len(poses) for id, poses in world.held_up.items()}
    things = (thing for thing in world.semantic.called(world.goal) if thing.seen_through < LOOKS)
    return {thing.id for thing in things if tried.get(thing.id, TRIES) < TRIES}


def _toward(
    world: World, candidate: _Candidate, cfg: NavigateConfig
) -> tuple[Reached, Command | None]:
    """How far the robot has come with a candidate, and the step that brings it on; None when a
    verdict is due first."""
    thing, again, policy = candidate.instance, candidate.again, local_policy(cfg)
    if not candidate.stands.any():
        return Reached.NO_OTHER_SIDE, None
    what = _named(thing, world.goal)
    stands = np.argwhere(candidate.stands).astype(np.int32)
    field = world.plan.toward(world.terrain, stands, world.pose)
    if policy.arrived(world, field, candidate.exactly):
        _doubt(world, thing)
        turn, face = policy.turn(world, thing.xy), Aim(AimKind.FACE, thing.id)
        if turn is None and not progress.looked_from_here(world):
            if progress.stalled(world, face, None, cfg):
                return Reached.FACED, None  # a detector that does not come is not waited for
            why = f"look at {what}"
            wait = Command(Action.TURN_LEFT, Mode.FACE, thing.xy, why, course=Toward(thing.xy))
            return Reached.ON_THE_WAY, wait
        if turn is None or progress.dithers(world, face, turn, cfg):
            return Reached.FACED, None
        facing = Command(turn, Mode.FACE, thing.xy, f"face {what}", course=Toward(thing.xy))
        return Reached.ON_THE_WAY, facing
    aim = Aim(AimKind.SIDE if again else AimKind.TARGET, thing.id)
    if progress.stalled(world, aim, field, cfg):
        return Reached.HELD_UP, None
    verb = "approach" if confirmed(thing, world.goal) else "inspect"
    whence = " from another side" if again else " from where it may be seen" if thing.unseen else ""
    why = f"{verb} {what}{whence}"
    action, course = policy.drive(world, field, candidate.exactly)
    command = Command(action, Mode.TARGET, thing.xy, why, course=course)
    return Reached.ON_THE_WAY, toward(field, world.pose, command)


def _named(thing: Instance, goal: str) -> str:
    return f"{goal} {thing.id} (p {thing.confidence_of(goal):.2f})"
