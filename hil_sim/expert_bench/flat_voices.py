"""Experts for searches on plans: what the runtime has counted in homes, and how well the robot
recognises what it goes by. No model is asked."""

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import fmean

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.expert_bench.flat_home import CELL_M, FlatHome
from hil_sim.expert_bench.flat_search import FlatSearch
from hil_sim.ground_truth.goals import categories_of
from hil_sim.scenes.format import ROOM_TYPES
from runtime.core.kernels import walking
from runtime.core.types import (
    Brief,
    Frontier,
    FrontierBrief,
    Mask,
    Missing,
    NearbyObject,
    Vote,
)
from runtime.core.voting.brief import OBJECT_RANGE_M, ROOM_RANGE_M, UNKNOWN_DEPTH_M
from runtime.core.voting.counts import SURENESS, CountTable, object_nats, room_nats
from runtime.core.voting.likelihood_experts import Evidence, ExpertConfig, vote_where_known
from runtime.core.voting.prior import PULL

CFG = ExpertConfig()


@dataclass(frozen=True)
class FlatVoices:
    """The experts of searches in one home. `rooms`: (H, W) types as the robot takes them to be,
    `beyond` the same of what it has not seen yet, as who looks ahead takes them to be; `spoilt`:
    who answers at random, "" for nobody."""

    counts: CountTable
    rooms: NDArray[np.int8]
    beyond: NDArray[np.int8]
    spoilt: str = ""

    def ask(
        self, search: FlatSearch, frontiers: tuple[Frontier, ...], unknown_m2: Mapping[int, float]
    ) -> list[Vote | Missing]:
        """What each says: by objects near, by rooms, by what lies beyond."""
        goal = categories_of(search.task.goal)[0]
        brief = self._brief(search, frontiers, unknown_m2)
        evidence = {
            "o2f": object_nats(brief, self.counts.near(goal)),
            "r2f": room_nats(brief, self.counts.beyond(goal)),
            "sle": self._ahead(search, frontiers, self.counts.in_room(goal)),
        }
        said = {name: vote_where_known(name, brief, nats, CFG) for name, nats in evidence.items()}
        if self.spoilt:
            said[self.spoilt] = at_random(self.spoilt, search, frontiers)
        return list(said.values())

    def _brief(
        self, search: FlatSearch, frontiers: tuple[Frontier, ...], unknown_m2: Mapping[int, float]
    ) -> Brief:
        told = []
        for f in frontiers:
            shares = _near(self.rooms, search.free, search, f, ROOM_RANGE_M)
            rooms = tuple(zip(ROOM_TYPES, shares, strict=True)) if sum(shares) else ()
            near = tuple(_objects(search, f))
            area = unknown_m2[f.id]
            told.append(FrontierBrief(f.id, f.distance_m, near, rooms, unknown_m2=area))
        return Brief(search.task.goal, 0, tuple(told))

    def _ahead(
        self, search: FlatSearch, frontiers: tuple[Frontier, ...], rates: Mapping[str, float]
    ) -> Evidence:
        unknown, mean = ~search.known & ~search.home.hiding, fmean(rates.values())
        found: Evidence = {}
        for f in frontiers:
            shares = _near(self.beyond, unknown, search, f, UNKNOWN_DEPTH_M)
            if sum(shares):
                likely = (p * rates.get(k, mean) for k, p in zip(ROOM_TYPES, shares, strict=True))
                found[f.id] = SURENESS * math.log(math.fsum(likely) / mean), "what lies beyond"
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
