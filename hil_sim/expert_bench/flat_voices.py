"""Experts for searches on plans: what other homes of the kind have where, counted, and how well the
robot recognises what it goes by. No model is asked."""

import math
import random
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.expert_bench.flat_home import CELL_M, FlatHome
from hil_sim.expert_bench.flat_search import FlatSearch
from hil_sim.ground_truth.goals import categories_of
from hil_sim.scenes.format import ROOM_TYPES
from runtime.core.kernels import walking
from runtime.core.mapping.grid import MapCopy
from runtime.core.types import (
    Brief,
    Frontier,
    FrontierBrief,
    Mask,
    Missing,
    NearbyObject,
    Vote,
)
from runtime.core.voting.brief import OBJECT_RANGE_M, ROOM_RANGE_M, UNKNOWN_DEPTH_M, doorway
from runtime.core.voting.likelihood_experts import (
    Doors,
    ExpertConfig,
    spoken_room,
    vote_objects,
    vote_rooms,
    vote_where_known,
)
from runtime.core.voting.prior import PULL

ADDED = 1.0  # rooms, things and doors of each kind that are taken to be counted already
CFG = ExpertConfig()


@dataclass(frozen=True)
class FlatCounts:
    """Nats by which a thing is likelier: by goal and room type; by goal and thing in one room. What
    doors of a room type lead to."""

    by_room: Mapping[str, Mapping[str, float]]
    by_thing: Mapping[str, Mapping[str, float]]
    doors: Doors

    @classmethod
    def of(cls, homes: Sequence[FlatHome], goals: Sequence[str]) -> "FlatCounts":
        """Counted over plans, of rooms as connected floor of one type."""
        rooms: Counter[str] = Counter()
        held: list[frozenset[str]] = []
        kinds: list[str] = []
        doors: dict[str, Counter[str]] = defaultdict(Counter)
        for home in homes:
            for kind, here, beside in _rooms(home):
                rooms[kind] += 1
                held.append(here)
                kinds.append(kind)
                doors[kind].update(beside)
        return cls(
            {goal: _by_room(goal, kinds, held, rooms) for goal in goals},
            {goal: _by_thing(goal, held) for goal in goals},
            {spoken_room(k): _shares(doors[k], k) for k in rooms},
        )


def _rooms(home: FlatHome) -> list[tuple[str, frozenset[str], Counter[str]]]:
    """Of each room its type, the categories in it, and the types that touch it."""
    found = []
    at = np.array([thing.at for thing in home.things]).astype(int).reshape(-1, 2)
    names_at = zip(home.things, at.tolist(), strict=True)
    height, width = home.rooms.shape
    standing = [(t.name, r, c) for t, (r, c) in names_at if 0 <= r < height and 0 <= c < width]
    for index, kind in enumerate(ROOM_TYPES):
        count, names = cv2.connectedComponents((home.rooms == index).astype(np.uint8))
        for n in range(1, count):
            room = names == n
            here = {name for name, row, col in standing if room[row, col]}
            wide = cv2.dilate((room & home.free).view(np.uint8), np.ones((7, 7), np.uint8)) > 0
            others = np.unique(home.rooms[wide & home.free & ~room])
            beside = Counter(ROOM_TYPES[o] for o in others.tolist() if o >= 0)
            found.append((kind, frozenset(here), beside))
    return found


def _by_room(
    goal: str, kinds: list[str], held: list[frozenset[str]], rooms: Counter[str]
) -> dict[str, float]:
    names = {*categories_of(goal)}
    have = Counter(k for k, here in zip(kinds, held, strict=True) if here & names)
    rate = {k: (have[k] + ADDED) / (n + 2 * ADDED) for k, n in rooms.items()}
    mean = math.fsum(rate.values()) / len(rate)
    return {spoken_room(k): math.log(r / mean) for k, r in rate.items()}


def _by_thing(goal: str, held: list[frozenset[str]]) -> dict[str, float]:
    names = {*categories_of(goal)}
    mean = (sum(bool(here & names) for here in held) + ADDED) / (len(held) + 2 * ADDED)
    near, both = Counter[str](), Counter[str]()
    for here in held:
        near.update(here)
        both.update(here if here & names else ())
    return {t: math.log((both[t] + ADDED * mean) / (n + ADDED) / mean) for t, n in near.items()}


def _shares(beside: Counter[str], kind: str) -> dict[str, float]:
    others = {k: beside[k] + ADDED for k in ROOM_TYPES if k != kind}
    total = sum(others.values())
    return {spoken_room(k): n / total for k, n in others.items()}


@dataclass(frozen=True)
class FlatVoices:
    """The experts of searches in one home. `rooms`: (H, W) types as the robot takes them to be,
    `beyond` the same of what it has not seen yet, as who looks ahead takes them to be; `spoilt`:
    who answers at random, "" for nobody."""

    counts: FlatCounts
    rooms: NDArray[np.int8]
    beyond: NDArray[np.int8]
    spoilt: str = ""

    def ask(
        self, search: FlatSearch, frontiers: tuple[Frontier, ...], unknown_m2: Mapping[int, float]
    ) -> list[Vote | Missing]:
        """What each says: by objects near, by rooms, by what lies beyond."""
        goal = search.task.goal
        brief = self._brief(search, frontiers, unknown_m2)
        by_room = self.counts.by_room[goal]
        said = {
            "o2f": vote_objects(brief, self.counts.by_thing[goal], CFG),
            "r2f": vote_rooms(brief, by_room, CFG, self.counts.doors),
            "sle": vote_where_known("sle", brief, self._ahead(search, frontiers, by_room), CFG),
        }
        if self.spoilt:
            said[self.spoilt] = at_random(self.spoilt, search, frontiers)
        return list(said.values())

    def _brief(
        self, search: FlatSearch, frontiers: tuple[Frontier, ...], unknown_m2: Mapping[int, float]
    ) -> Brief:
        occupied = search.known & search.home.hiding
        copy = MapCopy(search.frame, occupied, search.free, ~search.known)
        told = []
        for f in frontiers:
            shares = _near(self.rooms, search.free, search, f, ROOM_RANGE_M)
            rooms = tuple(zip(ROOM_TYPES, shares, strict=True)) if sum(shares) else ()
            near = tuple(_objects(search, f))
            door, area = doorway(f.cells_xy, copy), unknown_m2[f.id]
            told.append(
                FrontierBrief(f.id, f.distance_m, near, rooms, doorway=door, unknown_m2=area)
            )
        return Brief(search.task.goal, 0, tuple(told))

    def _ahead(
        self, search: FlatSearch, frontiers: tuple[Frontier, ...], by_room: Mapping[str, float]
    ) -> dict[int, tuple[float, str]]:
        unknown, found = ~search.known & ~search.home.hiding, {}
        for f in frontiers:
            shares = _near(self.beyond, unknown, search, f, UNKNOWN_DEPTH_M)
            if sum(shares):
                likely = [p * math.exp(by_room.get(spoken_room(k), 0.0))
                          for k, p in zip(ROOM_TYPES, shares, strict=True)]  # fmt: skip
                found[f.id] = math.log(math.fsum(likely)), "what lies beyond"
        return found


def at_random(expert: str, search: FlatSearch, frontiers: tuple[Frontier, ...]) -> Vote:
    """One or two frontiers drawn blindly, and as sure of them as one expert may be."""
    rng = random.Random(f"{expert}/{search.task.goal}/{search.at}/{len(frontiers)}")
    ids = [f.id for f in frontiers]
    named = tuple(sorted(rng.sample(ids, min(len(ids), rng.choice((1, 2))))))
    nats = tuple((id, 2 * PULL * (id in named)) for id in ids)
    return Vote(expert, named, tuple((i, 1 / len(named)) for i in named), "drawn", nats=nats)


def recognised(home: FlatHome, share: float, what: str) -> NDArray[np.int8]:
    """(H, W) the home's room types where each room is taken for what it is with that probability,
    else for any other."""
    rng, taken = random.Random(f"{home.name}/{share}/{what}"), home.rooms.copy()
    for index in range(len(ROOM_TYPES)):
        count, names = cv2.connectedComponents((home.rooms == index).astype(np.uint8))
        for n in range(1, count):
            if rng.random() >= share:
                taken[names == n] = rng.choice([i for i in range(len(ROOM_TYPES)) if i != index])
    return taken


def _near(
    rooms: NDArray[np.int8], where: Mask, search: FlatSearch, frontier: Frontier, range_m: float
) -> list[float]:
    """Shares of room types within so much walking of a frontier, where one may; zeros where none
    is known."""
    cells, reach = search.frame.cells(frontier.cells_xy), round(range_m / CELL_M)
    low = np.maximum(cells.min(axis=0) - reach, 0)
    high = np.minimum(cells.max(axis=0) + reach + 1, rooms.shape)
    seeds = np.zeros(high - low, bool)
    seeds[tuple((cells - low).T)] = True
    part = slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))
    steps, _ = walking.walk(np.ascontiguousarray(where[part] | seeds), seeds, reach)
    kinds = rooms[part][np.isfinite(steps) & where[part]]
    count = np.bincount(kinds[kinds >= 0], minlength=len(ROOM_TYPES))
    shares: list[float] = (count / max(1, int(count.sum()))).tolist()
    return shares


def _objects(search: FlatSearch, frontier: Frontier) -> list[NearbyObject]:
    """Things that were seen and lie open to the frontier, the nearest first."""
    home, here = search.home, np.array(frontier.goal_xy[::-1]) / CELL_M
    seen = np.flatnonzero(search.seen)
    away = home.spots[seen, :2] - here
    away_m = np.hypot(*away.T) * CELL_M - home.spots[seen, 2] * CELL_M
    near, near_m = seen[away_m <= OBJECT_RANGE_M], away_m[away_m <= OBJECT_RANGE_M]
    if not len(near):
        return []
    shown = home.open_to(here, near)
    names = [home.things[i].name for i in near[shown].tolist()]
    found = zip(np.maximum(0.0, near_m[shown]).tolist(), names, strict=True)
    return [NearbyObject(name, 0.9, m) for m, name in sorted(found)]
