"""Looking again at ways that were closed: doors are opened, and people go on."""

import math
from typing import Final

from runtime.core import progress
from runtime.core.distances.passages import ClosedWay, Passages, TriedWay
from runtime.core.local_policy import local_policy
from runtime.core.motion.courses import Toward
from runtime.core.resorts import Resort
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action
from runtime.core.world import Aim, AimKind, Command, Mode, World, toward

SAME_M: Final = 0.8  # between what is one way, seen twice
LOOKS: Final = 3  # at one, after which it counts as closed for good
WATCH_S: Final = 4.0  # each: what has gone leaves the map meanwhile
AGAIN_S: Final = 20.0  # from one look to the next
WAYS: Final = 8  # of a search; more are none, but a map that flickers


def look_again(world: World, cfg: NavigateConfig, wait: bool = False) -> Command | None:
    """To a way that was open before, and watch it for a while; None where there is none, or none
    that is due. With `wait` it is stayed at until it is due: there is nothing else to do."""
    while (found := _due(world, wait)) is not None:
        command = _look(world, cfg, *found)
        if command is not None:
            return command
    return None


def _due(world: World, wait: bool) -> tuple[ClosedWay, TriedWay] | None:
    """Of those that may be looked at now the least looked at, the nearest of these; the one that is
    being watched before all others."""
    passages, now_s = world.explored.passages, world.body.free_s
    barred = world.map.zones.barred(world.map.frame)
    ways = passages.closed(world.terrain, world.reach, barred)
    before, passages.tried = passages.tried, []
    known = [(way, tried) for way in ways if (tried := _tried(passages, way, before)) is not None]
    watched_before = [tried for tried in before if tried.looks or tried.since_s is not None]
    if any(tried not in passages.tried for tried in watched_before):
        world.explored.resort = Resort.NONE  # one was opened: what it leads to is explored, too
    watched = [pair for pair in known if pair[1].since_s is not None]
    late = [
        pair
        for pair in known
        if pair[1].looks < LOOKS and (wait or now_s - pair[1].last_s >= AGAIN_S)
    ]
    return next(iter((*watched, *sorted(late, key=lambda pair: pair[1].looks))), None)


def _tried(passages: Passages, way: ClosedWay, before: list[TriedWay]) -> TriedWay | None:
    """What is known of a way; a new one is noted, unless there were too many."""
    near = (tried for tried in before if math.dist(tried.xy, way.xy) <= SAME_M)
    tried = next(near, None)
    if tried is None and passages.next_id <= WAYS:
        tried = TriedWay(passages.next_id, way.xy)
        passages.next_id += 1
    if tried is not None and tried not in passages.tried:
        passages.tried.append(tried)
    return tried


def _look(world: World, cfg: NavigateConfig, way: ClosedWay, tried: TriedWay) -> Command | None:
    """The step toward it, or the look at it; None when that was long enough, or not to be had."""
    policy, now_s = local_policy(cfg), world.body.free_s
    field = world.plan.toward(world.terrain, way.stands, world.pose)
    x, y = tried.xy
    where = f"the way at ({x:.1f}, {y:.1f})"
    if tried.since_s is not None or policy.arrived(world, field):
        tried.since_s = now_s if tried.since_s is None else tried.since_s
        if now_s - max(tried.since_s, tried.last_s + AGAIN_S - WATCH_S) >= WATCH_S:
            _done(tried, now_s)
            return None
        turn = policy.turn(world, way.xy) or Action.TURN_LEFT
        why = f"look whether {where} is open again"
        return Command(turn, Mode.FACE, way.xy, why, course=Toward(way.xy))
    if progress.stalled(world, Aim(AimKind.WAY, tried.id), field, cfg):
        _done(tried, now_s)
        return None
    action, course = policy.drive(world, field)
    why = f"go and look whether {where} is open again"
    command = Command(action, Mode.FRONTIER, way.xy, why, course=course)
    return toward(field, world.pose, command)


def _done(tried: TriedWay, now_s: float) -> None:
    tried.looks, tried.last_s, tried.since_s = tried.looks + 1, now_s, None
