"""Where the instances are, as arrays: which of them may be meant by a place is asked for each
detection, and mostly answered by none."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from runtime.core.types import F64

SLACK_M = 1e-6  # bounds are computed otherwise than what they bound


class Placed(Protocol):
    """What has a place on the map, as an `Instance` has."""

    @property
    def id(self) -> int: ...

    @property
    def xy(self) -> tuple[float, float]: ...

    @property
    def z_m(self) -> float: ...

    @property
    def cells_xy(self) -> F64: ...


class InstancePlaces:
    """By id: x, y, z of the middle, and the box of the footprint's cells, m in the map frame."""

    def __init__(self) -> None:
        self._rows = np.zeros((7, 64))
        self._ids = np.zeros(64, np.int64)
        self._row_of: dict[int, int] = {}
        self._held: list[tuple[F64, tuple[float, float]]] = []  # cells and middles of the rows

    @classmethod
    def of(cls, instances: Mapping[int, Placed]) -> "InstancePlaces":
        """Of all instances."""
        places = cls()
        places.put(instances.values())
        return places

    def __len__(self) -> int:
        return len(self._row_of)

    def put(self, instances: Iterable[Placed]) -> bool:
        """Add instances, or where they are now; whether one is new or has other cells, or has
        moved along the floor."""
        moved = False
        for one in instances:
            row = self._row_of.setdefault(one.id, len(self._row_of))
            if row == len(self._ids):
                self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)], axis=1)
                self._ids = np.concatenate([self._ids, np.zeros_like(self._ids)])
            if row == len(self._held):
                self._held.append((one.cells_xy[:0], one.xy))
            cells, xy = self._held[row]
            self._ids[row], self._rows[:3, row] = one.id, (*one.xy, one.z_m)
            if cells is not one.cells_xy:
                self._rows[3:, row] = _box(one.cells_xy)
            elif xy == one.xy:
                continue
            self._held[row], moved = (one.cells_xy, one.xy), True
        return moved

    def near(
        self, xy: Sequence[tuple[float, float]], cells_xy: Sequence[F64], within_m: float
    ) -> list[list[tuple[float, int]]]:
        """Of each of some things at `xy`, the instances that may have their middle, or a cell, so
        near to it, or their middle to one of its cells (N, 2) m: at least how far, and the id,
        nearest first. None is left out, some may be too many."""
        if not xy:
            return []
        at, box = np.array(xy).T[:, :, None], np.array([_box(cells) for cells in cells_xy]).T
        first, last = box[:2, :, None], box[2:, :, None]
        near = self._reaching(first, last, at, within_m + SLACK_M)
        ids, rows = self._ids[near].tolist(), self._rows[:, None, near]
        middle, low, high = rows[:2], rows[3:5], rows[5:]
        # From the thing's middle to their boxes, and from its box to their middles; a middle need
        # not lie in its own box.
        gap = np.empty((3, 2, len(xy), len(ids)))
        np.maximum(low - at, at - high, out=gap[0])
        np.maximum(middle - last, first - middle, out=gap[1])
        np.maximum(gap[:2], 0.0, out=gap[:2])
        np.subtract(middle, at, out=gap[2])
        gap *= gap
        least = (gap[:, 0] + gap[:, 1]).min(axis=0)
        found: list[list[tuple[float, int]]] = [[] for _ in xy]
        things, close = (least <= (within_m + SLACK_M) ** 2).nonzero()
        gaps = (np.sqrt(least[things, close]) - SLACK_M).tolist()
        for thing, n, gap_m in zip(things.tolist(), close.tolist(), gaps, strict=True):
            found[thing].append((gap_m, ids[n]))
        return [sorted(one) for one in found]

    def _reaching(self, first: F64, last: F64, at: F64, range_m: float) -> NDArray[np.intp]:
        """Rows of the instances that reach so near to the box round all things (2, N, 1)."""
        rows = self._rows[:, : len(self)]
        middle, low, high = rows[:2], rows[3:5], rows[5:]
        least = np.minimum(first, at).min(axis=1) - range_m
        most = np.maximum(last, at).max(axis=1) + range_m
        near = (np.minimum(low, middle) <= most) & (np.maximum(high, middle) >= least)
        return np.flatnonzero(near.all(axis=0))

    def box(self, id: int) -> list[float]:
        """The left, lower, right and upper end of an instance, its middle included, m."""
        x, y, _, left, below, right, above = self._rows[:, self._row_of[id]].tolist()
        return [min(left, x), min(below, y), max(right, x), max(above, y)]

    def within(self, xy: tuple[float, float], range_m: float) -> tuple[list[int], F64]:
        """Ids of the instances whose middle is so near, and those middles, (N, 3) m."""
        rows = self._rows[:3, : len(self)]
        gap2 = (rows[0] - xy[0]) ** 2 + (rows[1] - xy[1]) ** 2
        near = (gap2 <= (range_m + SLACK_M) ** 2).nonzero()[0]
        ids: list[int] = self._ids[near].tolist()
        return ids, rows[:, near].T


class Nearby:
    """Which instances may be meant by each of some things, asked for one thing after the other
    while each of them changes an instance."""

    def __init__(
        self,
        places: InstancePlaces,
        xy: Sequence[tuple[float, float]],
        cells_xy: Sequence[F64],
        within_m: float,
    ) -> None:
        self._places, self._within_m = places, within_m + SLACK_M
        self._things = [(*one, *_box(cells)) for one, cells in zip(xy, cells_xy, strict=True)]
        self._before = places.near(xy, cells_xy, within_m)
        self._moved: dict[int, list[float]] = {}

    def put(self, instance: Placed) -> None:
        """It is new, or may be somewhere else than before."""
        if self._places.put([instance]):
            self._moved[instance.id] = self._places.box(instance.id)

    def of(self, thing: int) -> list[tuple[float, int]]:
        """As `InstancePlaces.near`."""
        x, y, left, below, right, above = self._things[thing]
        reach_m, moved = self._within_m, self._moved
        low_x, high_x = min(left, x) - reach_m, max(right, x) + reach_m
        low_y, high_y = min(below, y) - reach_m, max(above, y) + reach_m
        return [one for one in self._before[thing] if one[1] not in moved] + [
            (0.0, id)
            for id, (x0, y0, x1, y1) in moved.items()
            if x0 <= high_x and x1 >= low_x and y0 <= high_y and y1 >= low_y
        ]


def _box(cells_xy: F64) -> list[float]:
    """(N, 2) -> the left, lower, right and upper end."""
    ends: list[float] = [*cells_xy.min(axis=0).tolist(), *cells_xy.max(axis=0).tolist()]
    return ends
