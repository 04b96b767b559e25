"""What stands in which room, and what near what, counted over homes: evidence without any model.

A count tells what it has seen. For a name that was never counted, names that mean nearly the same
stand in, and what they say is believed as far as they are alike (`CountTable.standing_in`).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean

from runtime.core.types import Brief
from runtime.core.voting.likelihood_experts import Doors, Evidence, object_evidence

Table = Mapping[str, Mapping[str, float]]
SURENESS = 0.5
"""Of a nat that was counted, what is believed of a frontier: what is round it was seen, and the
goal was not there."""
HERE, IN_PASSING = 0.8, 0.2
"""Of what is expected behind a frontier, what is of the room it is in, and of a hallway it is in;
the rest is of the rooms that doors of such a room lead to."""
PASSAGES = frozenset({"hallway"})
PSEUDO_ROOMS = 1.0
"""Rooms with, and as many without, the thing that are taken to be counted already."""
PSEUDO_THINGS = 5.0
"""Things, with as many of another near as things have on the average, taken to be counted."""
LIKE = 0.05
"""Cosine of two names by which one that is less alike stands in e times less."""
STRANGE, SAME = 0.35, 0.75
"""Cosine to the likest counted name at which nothing of it is believed, and all."""


@dataclass(frozen=True)
class Count:
    """What was counted in one set of homes. `rooms`: how many there are of each type; `holding`: by
    thing, in how many of each type there is one; `things`: how many there are of each; `beside`: by
    thing, how many have each other thing near; `doors`: by room type, how many of its doors lead to
    each other one."""

    rooms: Mapping[str, int]
    holding: Mapping[str, Mapping[str, int]]
    things: Mapping[str, int]
    beside: Mapping[str, Mapping[str, int]]
    doors: Mapping[str, Mapping[str, int]]


@dataclass(frozen=True)
class CountTable:
    """Counts made likelihoods. `rates`: by thing, the share of the rooms of each type that have
    one. `lifts`: by goal, how many times likelier one is near each thing than near any. `doors`: by
    room type, what a door of it leads to."""

    rates: Table
    lifts: Table
    doors: Doors

    @classmethod
    def of(cls, counts: Sequence[Count]) -> "CountTable":
        """All counts with equal weight, each for the rooms and things that it has."""
        return cls(
            _levelled([_rates(count) for count in counts]),
            _mean([_lifts(count) for count in counts]),
            _mean([_shares(count.doors) for count in counts if count.doors]),
        )

    def in_room(self, goal: str) -> Mapping[str, float]:
        """Of the rooms of each type, the share that has one; {} of what was never counted."""
        return self.rates.get(goal, {})

    def near(self, goal: str) -> Mapping[str, float]:
        """How many times likelier one is near each thing than near any; {} of what was never
        counted."""
        return self.lifts.get(goal, {})

    def standing_in(self, name: str, likeness: Mapping[str, float]) -> "CountTable":
        """With what the names alike have for a name, as goal and as a thing that is near; as it is
        where none is alike. `likeness`: cosine by name that was counted."""
        weights, trust = _stand_ins({n: c for n, c in likeness.items() if n in self.rates})
        if trust <= 0:
            return self
        rates = _blend([(self.rates[other], w) for other, w in weights.items()])
        mean = fmean(rates.values())
        believed = {room: mean + trust * (rate - mean) for room, rate in rates.items()}
        lifts = _blend([(self.lifts.get(other, {}), w) for other, w in weights.items()])
        beside = {goal: {**row, **_known(row, name, weights, trust)}
                  for goal, row in self.lifts.items()}  # fmt: skip
        return replace(
            self,
            rates={**self.rates, name: believed},
            lifts={**beside, name: _believed(lifts, trust)},
        )

    def without(self, name: str) -> "CountTable":
        """As if a name had never been counted."""
        return replace(
            self,
            rates={thing: row for thing, row in self.rates.items() if thing != name},
            lifts={
                goal: {thing: lift for thing, lift in row.items() if thing != name}
                for goal, row in self.lifts.items()
                if goal != name
            },
        )

    def beyond(self, goal: str) -> dict[str, float]:
        """How many times likelier one is behind a frontier in a room of each type than behind any:
        in that room, or in those that its doors lead to; {} of what was never counted."""
        rates = self.in_room(goal)
        if not rates:
            return {}
        mean = fmean(rates.values())
        found = {}
        for room, rate in rates.items():
            here = IN_PASSING if room in PASSAGES else HERE
            behind = self.doors.get(room, {room: 1.0})
            led_to = math.fsum(p * rates.get(other, mean) for other, p in behind.items())
            found[room] = (here * rate + (1.0 - here) * led_to) / mean
        return found


def object_nats(brief: Brief, lifts: Mapping[str, float]) -> Evidence:
    """O2F's evidence by counts; `lifts`: `CountTable.near` of the goal."""
    nats = {thing: math.log(lift) for thing, lift in lifts.items()}
    return _sobered(object_evidence(brief, nats))


def room_nats(brief: Brief, lifts: Mapping[str, float]) -> Evidence:
    """R2F's: the mean over what rooms a frontier may be in; `lifts`: `CountTable.beyond` of the
    goal."""
    evidence: Evidence = {}
    for frontier in brief.frontiers:
        known = [(p, name) for name, p in frontier.rooms if name in lifts]
        total = math.fsum(p for p, _ in known)
        if total > 0:
            likely = math.fsum(p * lifts[name] for p, name in known) / total
            evidence[frontier.id] = math.log(likely), max(known)[1]
    return _sobered(evidence)


def _sobered(evidence: Evidence) -> Evidence:
    return {id: (SURENESS * nats, told) for id, (nats, told) in evidence.items()}


def _rates(count: Count) -> Table:
    return {
        thing: {
            room: (row.get(room, 0) + PSEUDO_ROOMS) / (total + 2 * PSEUDO_ROOMS)
            for room, total in count.rooms.items()
        }
        for thing, row in count.holding.items()
    }


def _lifts(count: Count) -> Table:
    """By goal and thing: of these things, how many have the goal near, for how many of all have."""
    everything = sum(count.things.values())
    found: dict[str, dict[str, float]] = {}
    for goal in count.things:
        near = {thing: row.get(goal, 0) for thing, row in count.beside.items()}
        base = sum(near.values()) / everything
        if base > 0:
            found[goal] = {
                thing: (n + PSEUDO_THINGS * base) / (count.things[thing] + PSEUDO_THINGS) / base
                for thing, n in near.items()
            }
    return found


def _shares(rows: Mapping[str, Mapping[str, int]]) -> Table:
    return {
        name: {other: n / total for other, n in row.items()}
        for name, row in rows.items()
        if (total := sum(row.values()))
    }


def _levelled(tables: Sequence[Table]) -> Table:
    """Their mean, each thing brought to one level first, over the rooms that all have: a set that
    lacks some types of rooms must not lift or lower those that it has."""
    found: dict[str, Mapping[str, float]] = {}
    for name in dict.fromkeys(name for table in tables for name in table):
        rows = [table[name] for table in tables if name in table]
        shared = [room for room in rows[0] if all(room in row for row in rows)]
        levels = [fmean(row[room] for room in shared or row) for row in rows]
        level = fmean(levels)
        even = [({room: rate * level / own for room, rate in row.items()}, 1.0)
                for row, own in zip(rows, levels, strict=True)]  # fmt: skip
        found[name] = {room: min(1.0, rate) for room, rate in _blend(even).items()}
    return found


def _mean(tables: Sequence[Table]) -> Table:
    """Cell by cell, of those tables that have it."""
    names = dict.fromkeys(name for table in tables for name in table)
    return {name: _blend([(t[name], 1.0) for t in tables if name in t]) for name in names}


def _blend(rows: Sequence[tuple[Mapping[str, float], float]]) -> dict[str, float]:
    """Weighted means, cell by cell, of those rows that have it."""
    sums: dict[str, tuple[float, float]] = {}
    for row, weight in rows:
        for key, value in row.items():
            total, weights = sums.get(key, (0.0, 0.0))
            sums[key] = total + weight * value, weights + weight
    return {key: total / weights for key, (total, weights) in sums.items()}


def _known(
    row: Mapping[str, float], name: str, weights: Mapping[str, float], trust: float
) -> dict[str, float]:
    """What a row has of the names that stand in for one, as that one's; {} where it has none."""
    found = [({name: row[other]}, w) for other, w in weights.items() if other in row]
    return _believed(_blend(found), trust)


def _believed(lifts: Mapping[str, float], trust: float) -> dict[str, float]:
    return {thing: 1.0 + trust * (lift - 1.0) for thing, lift in lifts.items()}


def _stand_ins(likeness: Mapping[str, float]) -> tuple[dict[str, float], float]:
    """Weights of the names alike, their sum 1, and how far they are believed, 0..1."""
    if not likeness:
        return {}, 0.0
    best = max(likeness.values())
    raw = {name: math.exp((cosine - best) / LIKE) for name, cosine in likeness.items()}
    kept = {name: weight for name, weight in raw.items() if weight > 0.01}
    total = math.fsum(kept.values())
    trust = min(1.0, max(0.0, (best - STRANGE) / (SAME - STRANGE)))
    return {name: weight / total for name, weight in kept.items()}, trust
