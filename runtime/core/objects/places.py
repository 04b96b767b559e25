"""Where the instances are, as arrays: which of them may be meant by a place is asked for each
detection, and mostly answered by none."""

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np

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
        self._rows = np.zeros((64, 7))
        self._ids = np.zeros(64, np.int64)
        self._row_of: dict[int, int] = {}

    @classmethod
    def of(cls, instances: Mapping[int, Placed]) -> "InstancePlaces":
        """Of all instances."""
        places = cls()
        places.put(instances.values())
        return places

    def __len__(self) -> int:
        return len(self._row_of)

    def put(self, instances: Iterable[Placed]) -> None:
        """Add instances, or where they are now."""
        for one in instances:
            row = self._row_of.setdefault(one.id, len(self._row_of))
            if row == len(self._rows):
                self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
                self._ids = np.concatenate([self._ids, np.zeros_like(self._ids)])
            low, high = one.cells_xy.min(axis=0), one.cells_xy.max(axis=0)
            self._ids[row], self._rows[row] = one.id, (*one.xy, one.z_m, *low, *high)

    def near(
        self, xy: tuple[float, float], cells_xy: F64, within_m: float
    ) -> list[tuple[float, int]]:
        """The instances that may have their middle, or a cell, so near to a thing at `xy`, or
        their middle to one of its cells (N, 2) m: at least how far, and the id, nearest first.
        None is left out, some may be too many."""
        rows = self._rows[: len(self)]
        x, y = xy
        (left, below), (right, above) = cells_xy.min(axis=0).tolist(), cells_xy.max(axis=0).tolist()
        # From the thing's middle to their boxes, and from its box to their middles; a middle need
        # not lie in its own box.
        theirs = _gap2(rows[:, 3], rows[:, 5], x, x) + _gap2(rows[:, 4], rows[:, 6], y, y)
        mine = _gap2(rows[:, 0], rows[:, 0], left, right)
        mine += _gap2(rows[:, 1], rows[:, 1], below, above)
        apart = (rows[:, 0] - x) ** 2 + (rows[:, 1] - y) ** 2
        least = np.minimum(np.minimum(theirs, mine), apart)
        close = np.flatnonzero(least <= (within_m + SLACK_M) ** 2)
        gaps = np.sqrt(least[close]) - SLACK_M
        return sorted(zip(gaps.tolist(), self._ids[close].tolist(), strict=True))

    def within(self, xy: tuple[float, float], range_m: float) -> tuple[list[int], F64]:
        """Ids of the instances whose middle is so near, and those middles, (N, 3) m."""
        rows = self._rows[: len(self)]
        gap = rows[:, :2] - np.array(xy)
        near = np.einsum("ij,ij->i", gap, gap) <= (range_m + SLACK_M) ** 2
        ids: list[int] = self._ids[: len(self)][near].tolist()
        return ids, rows[near, :3]


def _gap2(low: F64, high: F64, from_m: float, to_m: float) -> F64:
    """(N,) the square of how far the intervals (low, high) are from another, m."""
    gap: F64 = np.maximum(np.maximum(low - to_m, from_m - high), 0.0)
    return gap * gap
