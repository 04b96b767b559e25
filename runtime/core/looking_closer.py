"""Looking closer: surfaces on which the goal could stand and that were never seen finely enough for
its size, when no frontier is left. And which of them are still in doubt when the search ends."""

import math
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np

from runtime.core import progress
from runtime.core.local_policy import local_policy
from runtime.core.mapping.fineness import WIDER, px_m_from, sides_of
from runtime.core.mapping.patches import Patch, Surfaces, Visit
from runtime.core.motion.courses import Toward
from runtime.core.objects import standpoints
from runtime.core.objects.instances import Instance
from runtime.core.settings import NavigateConfig
from runtime.core.types import F32, F64, Action, Intrinsics, Mask
from runtime.core.world import Aim, AimKind, Command, Mode, World, toward

NEAR_M: Final = 1.2  # a look from so near is as fine as looks are made
LEAST_M: Final = 0.45  # from what is looked at: nearer, it is not in the image
FAR_M: Final = (1.1, 1.8)  # at most; the second where nothing is nearer
FINE: Final = 0.8  # of the pixels of a look from there, that are as fine
WORTH: Final = 0.01  # least chance of finding the goal that a look is worth,
LAST_WORTH: Final = 0.005  # when nothing else is left to try
TURN_M: Final = 2.0  # of way, that a look costs beside the way to it
DOUBT: Final = 0.02  # chance that the goal is still there, from which on that is told
DOUBTS: Final = 5  # places that are told
ASIDE: Final = 9  # cells of the layers across which what a room is told of reaches
AROUND_M: Final = 1.5  # of a patch, the middle of a thing that it is on,
BESIDE_M: Final = 0.4  # and some of it so near
_LENS: Final = Intrinsics(320.0, 320.0, 320.0, 240.0, 640, 480)  # before the first image


def look_closer(world: World, cfg: NavigateConfig) -> Command | None:
    """The step to where the patch is seen finely that is most worth its way, or the look at it;
    None where no look is worth it any more."""
    closer = world.explored.closer
    last = world.explored.resort.next("closer") is None
    while (visit := _next(world, LAST_WORTH if last else WORTH)) is not None:
        closer.visit = visit
        command = _toward(world, visit, cfg)
        if command is not None:
            return command
        closer.done.add(visit.patch.id)
        closer.visit = None
    return None


def missed_patches(world: World) -> tuple[Patch, ...]:
    """Where the goal may have been missed, of all that was seen; none where how finely that was
    seen is not kept."""
    if world.explored.closer.fineness.frame is None:
        return ()
    return _surfaces(world).patches(lambda likely, gain: likely >= DOUBT / 10)


def _surfaces(world: World) -> Surfaces:
    """Of the map as it is now."""
    near_px_m = _px_m(world, NEAR_M)
    return Surfaces.of(world.map, world.explored.closer, near_px_m, _weights(world))


def _weights(world: World) -> F32 | None:
    """(2, R, C) of the layers: where one type of room is searched, only what is told to be of that,
    or is right beside it and not of another. None where all are."""
    rooms, only = world.semantic.rooms[:, ::WIDER, ::WIDER], world.explored.only_room
    if not only or not rooms.size:
        return None
    told, kinds = rooms.any(axis=0), rooms.argmax(axis=0)
    mine = told & (kinds == world.semantic.room_names.index(only))
    beside = cv2.dilate(mine.astype(np.uint8), np.ones((ASIDE, ASIDE), np.uint8)) > 0
    weights = (mine | (beside & ~told)).astype(np.float32)
    return np.broadcast_to(weights, (2, *weights.shape))


def _px_m(world: World, away_m: float) -> float:
    lens = world.lens[0] if world.lens else _LENS
    return px_m_from(lens.fx, lens.width, away_m)


def _next(world: World, least: float) -> Visit | None:
    """The patch that is gone to, while a look at it is worth so much; else the next."""
    closer, found = world.explored.closer, _surfaces(world)

    def worth(likely: F64, gain: F64) -> Mask:
        return np.asarray(gain >= least)

    if closer.visit is not None and found.patches(worth, only=closer.visit.patch.id):
        return closer.visit
    left = [patch for patch in found.patches(worth) if patch.id not in closer.done]
    return _most_worth(world, left)


def _most_worth(world: World, left: list[Patch]) -> Visit | None:
    """Of these the one whose look is most worth its way; those that nothing sees are done with."""
    about = [(_worth(patch, _near_m(world, patch)), patch) for patch in left]
    best: tuple[float, Visit] | None = None
    for at_most, patch in sorted(about, key=lambda one: (-one[0], one[1].id)):
        if at_most <= (best[0] if best else 0.0):
            break
        stands = _stands(world, patch)
        if not len(stands):
            world.explored.closer.done.add(patch.id)
            continue
        frame = world.reach.frame
        worth = _worth(patch, float(world.reach.of(frame.cells(stands)).min()))
        if best is None or worth > best[0]:
            best = worth, Visit(patch, stands)
    return best[1] if best else None


def _worth(patch: Patch, way_m: float) -> float:
    return patch.gain / (way_m + TURN_M)


def _near_m(world: World, patch: Patch) -> float:
    """The way to the place nearest on foot that is near it, whatever may be between; inf where none
    is known."""
    frame = world.reach.frame
    row, col = frame.cell(*patch.xy)
    n = round(FAR_M[-1] / frame.resolution_m)
    rows, cols = (slice(max(0, at - n), max(0, at + n + 1)) for at in (row, col))
    return float(world.reach.arrival_m[rows, cols].min(initial=math.inf))


def _stands(world: World, patch: Patch) -> F64:
    """(N, 2) m from where it can be seen from near, or a little farther off; of what was seen as
    finely before, from another side. None where there is no such place."""
    place = world.map, world.terrain, world.reach, patch.cells_xy, patch.xy
    for far_m in FAR_M:
        stands = standpoints.views_of(*place, (LEAST_M, far_m))
        if patch.px_m >= FINE * _px_m(world, far_m):
            side = sides_of(*(stands - patch.xy).T)
            stands = stands[(side & patch.sides) == 0]
        if len(stands):
            return stands
    return stands


def _toward(world: World, visit: Visit, cfg: NavigateConfig) -> Command | None:
    """The step to before it, or the turn to it; None when it is faced or cannot be."""
    patch, policy = visit.patch, local_policy(cfg)
    aim, place = Aim(AimKind.CLOSER, patch.id), _place(world, patch)
    stands = world.terrain.frame.cells(visit.stands_xy)
    if not np.isfinite(world.reach.of(stands)).any():
        return None  # the way there was lost
    field = world.plan.toward(world.terrain, stands, world.pose)
    if policy.arrived(world, field) or _near_enough(world, visit, aim, cfg):
        turn = policy.turn(world, patch.xy)
        if turn is None and progress.looked_from_here(world):
            return None
        if progress.stalled(world, aim, None, cfg):
            return None
        facing = Toward(patch.xy)
        why = f"look closer at {place}"
        return Command(turn or Action.TURN_LEFT, Mode.CLOSER, patch.xy, why, course=facing)
    if progress.stalled(world, aim, field, cfg):
        return None
    action, course = policy.drive(world, field)
    chance = f"about {100 * patch.likely:.0f} %, by the detector's recall at its size"
    why = f"go and look closer at {place}: {world.goal} may have been missed there ({chance})"
    command = Command(action, Mode.CLOSER, patch.xy, why, course=course)
    return toward(field, world.pose, command)


def _near_enough(world: World, visit: Visit, aim: Aim, cfg: NavigateConfig) -> bool:
    """Whether it may as well look from here: for a while it came no nearer, and it is near."""
    held_up = world.pursuit.progress.get(aim)
    near = math.dist(world.pose.xy, visit.patch.xy) <= FAR_M[-1]
    return near and held_up is not None and held_up.idle > local_policy(cfg).patience / 3


def _place(world: World, patch: Patch) -> str:
    thing = _on(world, patch)
    what = f"{thing.name} {thing.id}" if thing is not None else "the surface"
    x, y = patch.xy
    return f"{what} at ({x:.1f}, {y:.1f})"


def _on(world: World, patch: Patch) -> Instance | None:
    """The largest thing that the patch is on, or beside."""
    ids, _ = world.semantic.places.within(patch.xy, AROUND_M)
    things = (world.semantic.instances[id] for id in ids)
    near = [
        thing
        for thing in things
        if np.hypot(*(thing.cells_xy - patch.xy).T).min(initial=math.inf) <= BESIDE_M
    ]
    return max(near, key=lambda thing: (len(thing.cells_xy), -thing.id), default=None)


@dataclass(frozen=True)
class Doubt:
    """Where the goal may still be: on what thing, "" for none that has a name; about `xy`, m; with
    what chance; from how near that was seen, m, inf for never."""

    on: str
    xy: tuple[float, float]
    likely: float
    seen_m: float

    def __str__(self) -> str:
        what = f"on the {self.on}" if self.on else "on what stands"
        seen = (
            f"seen from no nearer than {self.seen_m:.1f} m"
            if math.isfinite(self.seen_m)
            else "never looked at"
        )
        x, y = self.xy
        return f"{what} at ({x:.1f}, {y:.1f}), about {100 * self.likely:.0f} %, {seen}"


def doubts(world: World) -> tuple[Doubt, ...]:
    """Where the goal most likely still is, of what was seen, the likeliest first; patches of one
    thing are one."""
    found: dict[tuple[str, int], Doubt] = {}
    one_m = _px_m(world, 1.0)
    for patch in missed_patches(world):
        thing = _on(world, patch)
        key = (thing.name, thing.id) if thing is not None else ("", patch.id)
        seen_m = one_m / patch.px_m if patch.px_m else math.inf
        one = Doubt(key[0], patch.xy, patch.likely, seen_m)
        before = found.get(key)
        if before is not None:
            likelier = max(before, one, key=lambda doubt: doubt.likely)
            both = before.likely + one.likely
            one = replace(likelier, likely=both, seen_m=min(before.seen_m, one.seen_m))
        found[key] = one
    told = [doubt for doubt in found.values() if doubt.likely >= DOUBT]
    return tuple(sorted(told, key=lambda doubt: -doubt.likely)[:DOUBTS])
