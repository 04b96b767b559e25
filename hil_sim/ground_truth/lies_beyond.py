"""What truly lies behind a frontier, where the robot has not looked yet: things and rooms by
walking distance."""

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.ground_truth.freespace import CELL_M, FreeSpace, Points, distance_to
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.scenes.format import ROOM_TYPES, room_at
from hil_sim.scenes.furniture.boxes import box_of
from runtime.core.kernels import walking

BESIDE_M = 1.0
"""A thing is walked up to so near, or not at all."""
ABOUT_M = 0.08
"""Places that are so much farther from a thing than the nearest are as good."""
WITHIN_M = 5.0
"""What counts as lying beyond is reached by so much walking."""
NEAR_M, FAR_M = 8.0, 40.0
"""How far things are looked for: through what is unknown, and by any way."""
SEEDED_M = 0.3
"""A frontier's cells may be so far from where a body fits."""


@dataclass(frozen=True)
class Beyond:
    """Of one frontier. By category of LABELLED, metres of walking to the nearest thing that nobody
    has seen, inf where there is none: `beyond_m` through the unknown alone, `onward_m` by any way,
    (C,) each. `area_m2` of floor is reached through the unknown within WITHIN_M, `room_m2` (R,) of
    it by ROOM_TYPES."""

    beyond_m: NDArray[np.float32]
    onward_m: NDArray[np.float32]
    area_m2: float
    room_m2: NDArray[np.float32]


@dataclass(frozen=True)
class LiesBeyond:
    """A home, ready to be asked: `places` by thing, flat indices of the cells that it is walked up
    to from, `labels` (N,) each one's category or -1; `rooms` (H, W) index of the room's type or
    -1."""

    space: FreeSpace
    places: tuple[NDArray[np.intp], ...]
    labels: NDArray[np.int32]
    rooms: NDArray[np.int8]

    @classmethod
    def of(cls, space: FreeSpace) -> Self:
        """All that does not change in a home."""
        index = {name: i for i, name in enumerate(LABELLED)}
        labels = np.array([index.get(o.category, -1) for o in space.scene.objects], np.int32)
        places = []
        for thing, label in zip(space.scene.objects, labels, strict=True):
            away = distance_to(space, box_of(thing).corners()) if label >= 0 else None
            places.append(_beside(away, space.free) if away is not None else np.zeros(0, np.intp))
        rooms = np.full(space.free.shape, -1, np.int8)
        cells = np.argwhere(space.free)
        for (row, col), (x, y) in zip(cells, space.points(cells), strict=True):
            room = room_at(space.scene, x, y)
            if room is not None and room.type in ROOM_TYPES:
                rooms[row, col] = ROOM_TYPES.index(room.type)
        return cls(space, tuple(places), labels, rooms)

    def behind(
        self, frontier_xy: Points, unknown: NDArray[np.bool_], unseen: NDArray[np.bool_]
    ) -> Beyond:
        """Of a frontier, its cells (N, 2) m in the scene's frame; `unknown` (H, W) free cells that
        the map does not know, `unseen` (things,) those that were never in view."""
        free = self.space.free
        seeds = self._seeds(frontier_xy)
        inside = free & unknown
        through = _walk(inside | seeds, seeds, NEAR_M)
        anyway = _walk(free | seeds, seeds, FAR_M)
        reached = inside & (through <= WITHIN_M)
        rooms = self.rooms[reached]
        each_m2 = np.bincount(rooms[rooms >= 0], minlength=len(ROOM_TYPES)) * CELL_M**2
        return Beyond(
            self._nearest(through, unseen),
            self._nearest(anyway, unseen),
            float(np.count_nonzero(reached)) * CELL_M**2,
            each_m2.astype(np.float32),
        )

    def about(
        self, frontier_xy: Points, near_m: float, room_m: float
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """Round a frontier, its cells (N, 2) m in the scene's frame, by any way, seen or not:
        (things,) which are walked up to within `near_m`, (R,) shares of the floor within `room_m`
        by ROOM_TYPES, all 0 where there is none."""
        free = self.space.free
        seeds = self._seeds(frontier_xy)
        walked = _walk(free | seeds, seeds, max(near_m, room_m))
        flat = walked.ravel()
        near = [bool(at.size) and float(flat[at].min()) <= near_m for at in self.places]
        rooms = self.rooms[free & (walked <= room_m)]
        each = np.bincount(rooms[rooms >= 0], minlength=len(ROOM_TYPES)).astype(np.float64)
        return np.array(near, bool), each / max(each.sum(), 1.0)

    def _seeds(self, frontier_xy: Points) -> NDArray[np.bool_]:
        """(H, W) the cells within SEEDED_M of a frontier's."""
        marked = np.zeros(self.space.free.shape, np.uint8)
        for x, y in frontier_xy:
            cell = self.space.cell(float(x), float(y))
            if cell is not None:
                marked[cell] = 1
        side = 2 * round(SEEDED_M / CELL_M) + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
        return np.asarray(cv2.dilate(marked, disc) > 0, np.bool_)

    def _nearest(
        self, walked_m: NDArray[np.float32], unseen: NDArray[np.bool_]
    ) -> NDArray[np.float32]:
        """(H, W) m -> (C,) to the nearest unseen thing of each category."""
        found = np.full(len(LABELLED), np.inf, np.float32)
        flat = walked_m.ravel()
        for thing in np.flatnonzero(unseen & (self.labels >= 0)).tolist():
            if self.places[thing].size:
                label = self.labels[thing]
                found[label] = min(found[label], flat[self.places[thing]].min())
        return found


def _walk(
    passable: NDArray[np.bool_], seeds: NDArray[np.bool_], most_m: float
) -> NDArray[np.float32]:
    steps = walking.walk(passable, seeds, round(most_m / CELL_M))[0]
    return (steps * CELL_M).astype(np.float32)


def _beside(away: NDArray[np.float64], free: NDArray[np.bool_]) -> NDArray[np.intp]:
    near = np.where(free, away, np.inf).ravel()
    least = near.min()
    if least > BESIDE_M:
        return np.zeros(0, np.intp)
    return np.flatnonzero(near <= least + ABOUT_M)
