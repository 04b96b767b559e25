"""What is known of a home at one moment, as `rfnav/map`, `rfnav/things` and `rfnav/where` tell it:
a copy that nobody changes any more, and what those who ask are answered of it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from runtime.core.belief import Expected
from runtime.core.mapping.grid import RESOLUTION_M, MapCopy
from runtime.core.objects.instances import Instance, shares, size_m
from runtime.core.types import F32, F64, U8, Decision, Frontier, Pose
from runtime.core.voting.names import who
from runtime.core.world import World
from runtime.perception.goal_words import ARTICLE, LONGEST, spelling
from runtime.service.told_map import packed

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
NO_ROOM: Final = 255
THINGS: Final = 500  # the surest are told
SURE: Final = 0.2  # of a thing that is told
NAMES: Final = 5  # of one thing
POINTS: Final = 500  # of a path; a longer one is told coarser
CELLS: Final = 60  # of a frontier, likewise
FRONTIERS: Final = 200
EXPECTED: Final = 8
ASK: Final = {"things": "{}", "where": '{"name": NAME}', "map": "{}"}
Told = dict[str, object]


class KnownThing(NamedTuple):
    """Of an object on the map, frame of the map, m; `names`: with what probability it is each."""

    id: int
    xy: tuple[float, float]
    size_m: tuple[float, float, float]
    confidence: float
    names: Mapping[str, float]
    views: int  # from so many places it was seen


@dataclass(frozen=True)
class Atlas:
    """`rooms`: (R, rows, cols) evidence for `room_names` over the map's window; `classes`: names of
    the same thing, the first of which stands on the map. Told in odometry's `frame`, in which the
    map begins at `origin_xy`."""

    stamp_ns: int
    goal: str
    map: MapCopy
    rooms: F32
    room_names: tuple[str, ...]
    things: tuple[KnownThing, ...]
    pose: Pose
    visited_xy: F64  # (N, 2) m
    planned_xy: F64
    toward_xy: tuple[float, float] | None
    frontiers: tuple[Frontier, ...]
    decision: Decision | None
    classes: tuple[tuple[str, ...], ...] = ()
    frame: str = "odom"
    origin_xy: tuple[float, float] = (0.0, 0.0)
    _kept: dict[str, Told] = field(default_factory=dict, repr=False)

    def told(self, kind: str, name: str = "") -> Told:
        """The answer to a query on `rfnav/KIND`, of ASK. In one thread."""
        if kind == "where":
            return self._where(name)
        if kind not in self._kept:
            self._kept[kind] = self._all_things() if kind == "things" else self._whole_map()
        return self._kept[kind]

    # -- inside --------------------------------------------------------------------------------

    @cached_property
    def _room_at(self) -> U8:
        """(rows, cols) index of the likeliest type of room, or NO_ROOM."""
        index = np.full(self.map.free.shape, NO_ROOM, np.uint8)
        if self.rooms.size:
            seen = self.rooms.any(axis=0) & ~self.map.unknown
            index[seen] = self.rooms[:, seen].argmax(axis=0)
        return index

    def _all_things(self) -> Told:
        surest = sorted(self.things, key=lambda thing: (-thing.confidence, thing.id))
        told = [self._thing(thing, thing.confidence) for thing in surest[:THINGS]]
        left_off = len(surest) - len(told)
        return {"frame": self.frame, "stamp_ns": self.stamp_ns, "things": told,
                "left_off": left_off}  # fmt: skip

    def _where(self, name: str) -> Told:
        called = self._called(name)
        found = [(thing.confidence * thing.names[called], thing) for thing in self.things
                 if called in thing.names]  # fmt: skip
        found = sorted(found, key=lambda one: (-one[0], one[1].id))[:THINGS]
        return {
            "name": name,
            "called": called,
            "frame": self.frame,
            "stamp_ns": self.stamp_ns,
            "found": [self._thing(thing, p) for p, thing in found if p >= SURE],
            "expected": self._expected() if called == self.goal else [],
        }

    def _called(self, name: str) -> str:
        """As it stands on the map: by any name of its class, in any spelling, one or several."""
        said = spelling(ARTICLE.sub("", name.lower()))
        spelt = {said, said.removesuffix("s"), said.removesuffix("es")}
        for names in (*self.classes, *((each,) for thing in self.things for each in thing.names)):
            if not spelt.isdisjoint(map(spelling, names)):
                return names[0]
        return name

    def _expected(self) -> list[Told]:
        """Where the decision that stands believes the goal, the likeliest first. A frontier that
        has gone since is left out."""
        decision = self.decision
        if decision is None or decision.belief is None:
            return []
        here = {frontier.id for frontier in self.frontiers}
        places = [e for e in decision.belief.places if e.kind != "frontier" or e.id in here]
        return [
            {"kind": e.kind, "id": e.id, "xy": self._placed(e.xy), "p": round(e.p, 3),
             "why": "; ".join((e.why, *_votes_for(decision, e)))}
            for e in places[:EXPECTED]
        ]  # fmt: skip

    def _thing(self, thing: KnownThing, p: float) -> Told:
        likeliest = sorted(thing.names.items(), key=lambda one: (-one[1], one[0]))[:NAMES]
        return {
            "id": thing.id,
            "name": likeliest[0][0],
            "names": {name: round(share, 3) for name, share in likeliest},
            "confidence": round(p, 3),
            "xy": self._placed(thing.xy),
            "size_m": [round(side, 2) for side in thing.size_m],
            "room": self._room_of(thing.xy),
            "views": thing.views,
        }

    def _room_of(self, xy: tuple[float, float]) -> str | None:
        """The type of room on most of the floor within half a metre; None where none was told."""
        row, col = self.map.frame.cell(*xy)
        reach = round(0.5 / self.map.frame.resolution_m)
        rows, cols = (slice(max(0, at - reach), max(0, at + reach + 1)) for at in (row, col))
        near = self._room_at[rows, cols]
        counts = np.bincount(near[near != NO_ROOM], minlength=1)
        return self.room_names[int(counts.argmax())] if counts.any() else None

    def _whole_map(self) -> Told:
        cells: U8 = np.full(self.map.free.shape, UNKNOWN, np.uint8)
        cells[self.map.free] = FREE
        cells[self.map.occupied] = OCCUPIED
        grid = self.map.frame
        corner = (
            grid.x0_m + grid.first_col * grid.resolution_m,
            grid.y0_m + grid.first_row * grid.resolution_m,
        )
        x_m, y_m = self._placed((self.pose.x_m, self.pose.y_m))
        return {
            "frame": self.frame,
            "stamp_ns": self.stamp_ns,
            "resolution_m": grid.resolution_m,
            "origin_xy": self._placed(corner),
            "rows": grid.rows,
            "cols": grid.cols,
            "cells": packed(cells),
            "rooms": packed(self._room_at),
            "room_names": list(self.room_names),
            "goal": self.goal,
            "pose": [x_m, y_m, round(self.pose.yaw_rad, 3)],
            "path_xy": self._way(self.visited_xy),
            "planned_xy": self._way(self.planned_xy),
            "toward_xy": self._placed(self.toward_xy) if self.toward_xy else None,
            "elected": self.decision.frontier if self.decision else None,
            "frontiers": [
                {
                    "id": f.id,
                    "xy": self._placed(f.goal_xy),
                    "cells_xy": self._way(f.cells_xy, CELLS),
                }
                for f in self.frontiers[:FRONTIERS]
            ],
        }

    def _placed(self, xy: tuple[float, float]) -> list[float]:
        return [round(at + start, 3) for at, start in zip(xy, self.origin_xy, strict=True)]

    def _way(self, xy: F64, most: int = POINTS) -> list[list[float]]:
        """Of the points every so-many-th, and the last."""
        if not len(xy):
            return []
        every = math.ceil(len(xy) / most)
        some = np.concatenate([xy[:-1:every], xy[-1:]]) + self.origin_xy
        coarse: list[list[float]] = some.round(3).tolist()
        return coarse


NOTHING: Final[Told] = {"said": "nothing is known yet: no search has seen anything"}


def nothing_told(kind: str, name: str, frame: str) -> Told:
    """The answer while nothing is known."""
    told: Told = {"frame": frame, "stamp_ns": 0, **NOTHING}
    if kind == "things":
        return told | {"things": [], "left_off": 0}
    if kind == "where":
        return told | {"name": name, "called": name, "found": [], "expected": []}
    none = packed(np.zeros((0, 0), np.uint8))
    return told | {
        "resolution_m": RESOLUTION_M, "origin_xy": [0.0, 0.0], "rows": 0, "cols": 0, "cells": none,
        "rooms": none, "room_names": [], "goal": None, "pose": None, "path_xy": [],
        "planned_xy": [], "toward_xy": None, "elected": None, "frontiers": [],
    }  # fmt: skip


def atlas_of(
    world: World,
    classes: Sequence[tuple[str, ...]],
    frame: str,
    origin_xy: tuple[float, float],
) -> Atlas:
    """A copy of what a world knows, by the thread that owns it."""
    window = world.map.known_window()
    cell_m, last = world.map.frame.resolution_m, world.body.last
    semantic = world.semantic
    return Atlas(
        world.stamp_ns,
        world.goal,
        world.map.copied(window),
        semantic.rooms[(slice(None), *window)].copy() if semantic.rooms.size else semantic.rooms,
        semantic.room_names,
        tuple(
            _seen(thing, cell_m)
            for thing in semantic.instances.values()
            if thing.confidence >= SURE
        ),
        world.pose,
        np.array(world.body.visited_xy, np.float64).reshape(-1, 2),
        last.path_xy if last is not None else np.zeros((0, 2)),
        last.toward_xy if last is not None else None,
        world.frontiers,
        world.standing.decision,
        tuple(classes),
        frame,
        origin_xy,
    )


def asked_name(body: Mapping[str, object]) -> str:
    """Of a query on `rfnav/where`; ValueError, in words, for what is none."""
    name = body.get("name")
    if set(body) != {"name"} or not isinstance(name, str) or not name.strip():
        raise ValueError(f"ask {ASK['where']}")
    if len(name) > LONGEST or not name.isprintable():
        raise ValueError(f"a name has at most {LONGEST} printable characters")
    return " ".join(name.split())


def _votes_for(decision: Decision, place: Expected) -> list[str]:
    if place.kind != "frontier":
        return []
    votes = [v for v in decision.ballot.votes if place.id in v.frontiers]
    return [f"{who(v.expert)}: {v.reason_for(int(place.id))}" for v in votes]


def _seen(thing: Instance, cell_m: float) -> KnownThing:
    about = shares(thing), len(thing.views)
    return KnownThing(thing.id, thing.xy, size_m(thing, cell_m), thing.confidence, *about)
