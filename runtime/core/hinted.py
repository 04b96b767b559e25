"""Where the goal was said to be: near a thing, or in a room. What is mapped of that is visited
first, each place once; then the search is as ever."""

from typing import Final

import numpy as np

from runtime.core import progress
from runtime.core.local_policy import local_policy
from runtime.core.mapping import coverage, frontiers
from runtime.core.motion.courses import Toward
from runtime.core.objects import standpoints
from runtime.core.objects.candidates import on_foot_m
from runtime.core.objects.instances import Instance
from runtime.core.settings import NavigateConfig
from runtime.core.types import F64, I32
from runtime.core.world import Aim, AimKind, Command, Mode, World, toward

FAR_M: Final = 10.0  # on foot: what is farther away is come to as ever
SEEN_M: Final = 1.3  # a thing that this search saw from so near has been looked at
THINGS: Final = 6  # that are visited at most
PLACES: Final = 4  # in rooms
ASK_EVERY_S: Final = 1.0  # for another place in a room


def look_where_said(world: World, cfg: NavigateConfig) -> Command | None:
    """The step to the nearest hinted place that was not looked at yet, or the look at it; None
    where there is none."""
    hint = world.explored.hint
    if world.explored.only_room or not (hint.near or hint.rooms):
        return None
    while (thing := _next_thing(world)) is not None:
        command = _visit(world, thing, cfg)
        if command is not None:
            return command
        hint.visited.add(thing.id)
    return _through_room(world, cfg)


def _next_thing(world: World) -> Instance | None:
    """A sure one of a hinted name; the nearest, but the one that is gone to is gone on to."""
    hint, semantic = world.explored.hint, world.semantic
    if len(hint.visited) >= THINGS:
        return None
    found = []
    for name in hint.near:
        for thing in semantic.called(name):
            if thing.name != name or not semantic.catalogue.is_sure(thing.id):
                continue
            away_m = on_foot_m(world.reach, thing)
            new = thing.range_m > SEEN_M or thing.id in hint.before
            if new and thing.id not in hint.visited and away_m <= FAR_M:
                found.append((world.pursuit.aim != (AimKind.NEAR, thing.id), away_m, thing.id))
    return semantic.instances[min(found)[2]] if found else None


def _visit(world: World, thing: Instance, cfg: NavigateConfig) -> Command | None:
    """The step to before it, or the turn to it; None when it is faced or cannot be."""
    policy, aim = local_policy(cfg), Aim(AimKind.NEAR, thing.id)
    place = world.map, world.terrain, world.reach, thing, thing.name
    stands = standpoints.standpoints(*place, world.standoff(thing))
    if not stands.any():
        return None
    what = f"near {thing.name} {thing.id}, as was said"
    field = world.plan.toward(world.terrain, np.argwhere(stands).astype(np.int32), world.pose)
    if policy.arrived(world, field):
        turn = policy.turn(world, thing.xy)
        if turn is None or progress.dithers(world, aim, turn, cfg):
            return None
        return Command(turn, Mode.FACE, thing.xy, f"look {what}", course=Toward(thing.xy))
    if progress.stalled(world, aim, field, cfg):
        return None
    action, course = policy.drive(world, field)
    command = Command(action, Mode.FRONTIER, thing.xy, f"go and look {what}", course=course)
    return toward(field, world.pose, command)


def _through_room(world: World, cfg: NavigateConfig) -> Command | None:
    """The step to what of a hinted room was seen only from afar; None where there is no such."""
    hint, now_s = world.explored.hint, world.body.elapsed_s
    if not hint.rooms:
        return None
    if hint.place_xy is None and hint.places < PLACES and now_s >= hint.asked_s + ASK_EVERY_S:
        hint.asked_s, hint.place_xy = now_s, _dim_place(world)
        hint.places += hint.place_xy is not None
    if hint.place_xy is None:
        return None
    policy, xy = local_policy(cfg), hint.place_xy
    goal: I32 = world.terrain.frame.cells(np.array([xy]))
    field = world.plan.toward(world.terrain, goal, world.pose)
    seen = world.explored.looked[world.map.frame.cell(*xy)]
    aim = Aim(AimKind.NEAR, -hint.places)
    if seen or policy.arrived(world, field) or progress.stalled(world, aim, field, cfg):
        hint.place_xy = None
        return None
    action, course = policy.drive(world, field)
    why = f"go and look through the {' or '.join(hint.rooms)}, as was said"
    return toward(field, world.pose, Command(action, Mode.FRONTIER, xy, why, course=course))


def _dim_place(world: World) -> tuple[float, float] | None:
    """The middle of the nearest part of a hinted room that was never seen from near."""
    semantic, frame, explored = world.semantic, world.map.frame, world.explored
    window = world.map.known_window()
    rooms = semantic.rooms[:, *window]
    kinds = [n for n, name in enumerate(semantic.room_names) if name in explored.hint.rooms]
    if not kinds or not rooms.size:
        return None
    told = np.isin(rooms.argmax(axis=0), kinds) & rooms.any(axis=0)
    dim = np.zeros(frame.shape, bool)
    out = explored.given_up | world.map.zones.barred(frame)
    dim[window] = coverage.overlooked(world.map, explored.looked, out)[window] & told
    parts = frontiers.components(dim, frame, coverage.MIN_CELLS)
    found = [(float(_away_m(world, part).min()), n) for n, part in enumerate(parts)]
    if not found or min(found)[0] > FAR_M:
        return None
    part = parts[min(found)[1]]
    off = np.hypot(*(part - part.mean(axis=0)).T)
    off[np.isinf(_away_m(world, part))] = np.inf
    x, y = part[int(off.argmin())].tolist()
    return x, y


def _away_m(world: World, cells_xy: F64) -> F64:
    """(N, 2) m -> (N,) m on foot."""
    return world.reach.of(world.reach.frame.cells(cells_xy))
