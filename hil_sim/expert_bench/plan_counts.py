"""What stands in which kind of room, counted from the plans of train homes, of which nothing is
drawn; and with it, what who knew for certain which rooms lie behind a frontier could say of it."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.ground_truth.freespace import CELL_M, FreeSpace, build_free_space
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.scenes.format import ROOM_TYPES, Scene, room_at
from hil_sim.scenes.furniture.boxes import box_of
from hil_sim.scenes.open import open_scene
from hil_sim.simulation.shell import Piece, wall_pieces

Values = NDArray[np.float64]

FIRST_SEED = 200_000
"""Of the train homes that are counted, as of those whose views are taught."""
LAPLACE = 0.5
"""Rooms with a thing, and without, that are taken to be counted already."""
LEAST_M2 = 0.5
"""Of a room so much floor must lie behind a frontier for the room to lie there."""
LEAST_P = 1e-6
STRIDE_M = 0.3
"""To either side of a door is another room."""


@dataclass(frozen=True)
class PlanCounts:
    """By room type and category of LABELLED: `share` (R, C) of rooms that have such a thing, and
    `nearby` (R, C) of those that have one or are next to a room, through a door, that has. Of floor
    that a body can stand on `floor_m2` (R,) in the mean room of a type."""

    share: Values
    nearby: Values
    floor_m2: Values

    @classmethod
    def of(cls, scenes: Iterable[Scene]) -> Self:
        """Counted in these homes, whose things all have a size."""
        rooms, floor_m2 = np.zeros(len(ROOM_TYPES)), np.zeros(len(ROOM_TYPES))
        having, near = np.zeros((2, len(ROOM_TYPES), len(LABELLED)))
        for scene in scenes:
            space, found, doors = _space(scene), _found(scene), _doors(scene)
            for room in scene.rooms:
                if room.type in ROOM_TYPES:
                    kind = ROOM_TYPES.index(room.type)
                    rooms[kind] += 1
                    floor_m2[kind] += _floor_m2(space, np.array(room.polygon))
                    own = found[room.name]
                    around = own.union(*(found[other] for other in doors[room.name]))
                    having[kind] += [name in own for name in LABELLED]
                    near[kind] += [name in around for name in LABELLED]
        share, nearby = (
            (count + LAPLACE) / (rooms[:, None] + 2 * LAPLACE) for count in (having, near)
        )
        return cls(share, nearby, floor_m2 / np.maximum(rooms, 1))

    def by_rooms(self, room_m2: Values) -> Values:
        """(N, R) of floor behind each frontier by room type -> (N, C) nats that a thing is there,
        of who is told which types of room lie there, one of each."""
        return self._nats((room_m2 >= LEAST_M2).astype(np.float64))

    def by_floor(self, room_m2: Values) -> Values:
        """The same of who is told how much of their floor does."""
        return self._nats(room_m2 / np.maximum(self.floor_m2, LEAST_M2))

    def _nats(self, rooms: Values) -> Values:
        """(N, R) so many rooms of each type, which need not be whole ones -> (N, C)."""
        none = np.minimum(rooms @ np.log1p(-self.share), 0.0)
        return np.log(np.maximum(-np.expm1(none), LEAST_P))


def count_plans(homes: int) -> PlanCounts:
    """Of so many generated homes of the train split."""
    return PlanCounts.of(open_scene(f"train-{FIRST_SEED + n}") for n in range(homes))


def _found(scene: Scene) -> dict[str, set[str]]:
    """By room the categories that stand in it."""
    found = {room.name: set[str]() for room in scene.rooms}
    for thing in scene.objects:
        room = room_at(scene, *thing.position_m[:2])
        if room is not None:
            found[room.name].add(thing.category)
    return found


def _doors(scene: Scene) -> dict[str, set[str]]:
    """By room those that a door of it leads to."""
    leads = {room.name: set[str]() for room in scene.rooms}
    for door in scene.doors:
        (x0, y0), (x1, y1) = door.start, door.end
        wide_m = math.dist(door.start, door.end)
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        ahead_x, ahead_y = (y0 - y1) / wide_m * STRIDE_M, (x1 - x0) / wide_m * STRIDE_M
        sides = [room_at(scene, x + s * ahead_x, y + s * ahead_y) for s in (-1, 1)]
        if sides[0] is not None and sides[1] is not None:
            leads[sides[0].name].add(sides[1].name)
            leads[sides[1].name].add(sides[0].name)
    return leads


def _space(scene: Scene) -> FreeSpace:
    """Where a body fits beside walls and the boxes of things."""
    boxes = [box_of(thing) for thing in scene.objects]
    solids = [
        *wall_pieces(scene),
        *(Piece((b.x, b.y, (b.z0 + b.z1) / 2), (b.width / 2, b.depth / 2, (b.z1 - b.z0) / 2), b.yaw)
          for b in boxes),
    ]  # fmt: skip
    return build_free_space(scene, np.concatenate([solid.triangles for solid in solids]))


def _floor_m2(space: FreeSpace, polygon: Values) -> float:
    """Of the free cells within a room."""
    cells = (polygon - space.origin_m) / CELL_M - 0.5
    inside = np.zeros(space.free.shape, np.uint8)
    cv2.fillPoly(inside, [np.round(cells).astype(np.int32)], 1)
    return float(np.count_nonzero(space.free & (inside > 0))) * CELL_M**2
