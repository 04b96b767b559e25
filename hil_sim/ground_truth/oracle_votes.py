"""How an expert would vote who knew one thing perfectly: the rooms round each frontier, what stands
near it, or how far it is from there to the goal. A bound on what such an expert can bring.

    known = OracleKnowledge(truth, "bed", lambda: LiesBeyond.of(truth.space))
    known.evidence("rooms", frontiers)  # by frontier: how much speaks for it, 0..1
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from hil_sim.ground_truth.freespace import Points, distance_to, instances
from hil_sim.ground_truth.lies_beyond import LiesBeyond
from hil_sim.scenes.format import ROOM_TYPES, room_at

if TYPE_CHECKING:  # PyBullet prints when it is imported
    from hil_sim.ground_truth.truth import SceneTruth

Kind = Literal["rooms", "objects", "beyond"]
ROOM_M, OBJECTS_M = 1.5, 3.5
"""How far round a frontier rooms and objects are known: as far as the runtime tells its experts of
them (`runtime.core.voting.brief`)."""
BESIDE_M = 1.0
"""A thing stands by the goal that is so near to it."""
SPARE_M = 1.0
"""Of way more than the best, at which a frontier has lost all but 1/e of what speaks for it."""
ASTRAY_M = 0.5
"""A frontier may be so far from where a body fits."""


@dataclass(frozen=True)
class AskedFrontier:
    """In the scene's frame, m: its cells (N, 2), where the robot would stand, and how far that is
    on its map."""

    id: int
    cells_xy: Points
    goal_xy: tuple[float, float]
    distance_m: float


@dataclass(frozen=True)
class OracleKnowledge:
    """The truth of one home about one goal; `lies` is asked for when it is needed, for it takes
    a while to be made."""

    truth: "SceneTruth"
    goal: str
    lies: Callable[[], LiesBeyond]

    def evidence(self, kind: Kind, frontiers: Sequence[AskedFrontier]) -> Mapping[int, float]:
        """By frontier, what speaks for it. rooms: share of the floor round it that is of a room
        type in which the goal stands in this home; objects: 1 where something near it stands by
        the goal; beyond: e to minus what it costs more than the best, way there and way on."""
        if kind == "beyond":
            return self._by_cost(frontiers)
        told = {}
        for frontier in frontiers:
            near, shares = self.lies().about(frontier.cells_xy, OBJECTS_M, ROOM_M)
            told[frontier.id] = (
                float(shares[self.rooms].sum()) if kind == "rooms" else float(near[self.by].any())
            )
        return told

    def _by_cost(self, frontiers: Sequence[AskedFrontier]) -> dict[int, float]:
        space, onward_m = self.truth.space, self.truth.field(self.goal)
        costs_m = {}
        for frontier in frontiers:
            near = space.nearest_free(*frontier.goal_xy, ASTRAY_M)
            cell = space.cell(*near) if near is not None else None
            left_m = float(onward_m[cell]) if cell is not None else math.inf
            costs_m[frontier.id] = frontier.distance_m + left_m
        least_m = min(costs_m.values())
        if not math.isfinite(least_m):
            return dict.fromkeys(costs_m, 0.0)
        return {id: math.exp((least_m - cost_m) / SPARE_M) for id, cost_m in costs_m.items()}

    @cached_property
    def rooms(self) -> list[int]:
        """Room types in which the goal stands."""
        scene = self.truth.space.scene
        things = (scene.objects[i] for i in instances(scene, self.goal))
        rooms = (room_at(scene, *thing.position_m[:2]) for thing in things)
        found = {ROOM_TYPES.index(r.type) for r in rooms if r is not None and r.type in ROOM_TYPES}
        return sorted(found)

    @cached_property
    def by(self) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
        """(things,) which stand by the goal, and are none themselves."""
        scene, goals = self.truth.space.scene, self.truth.boxes(self.goal)
        away = [distance_to(self.truth.space, footprint) for footprint in goals.values()]
        least = np.minimum.reduce(away)
        found = np.zeros(len(scene.objects), bool)
        for index, thing in enumerate(scene.objects):
            cell = self.truth.space.cell(*thing.position_m[:2])
            beside = cell is not None and float(least[cell]) <= BESIDE_M
            found[index] = beside and index not in goals
        return found
