"""Where the instances are, as arrays: which of them may be meant by a place is asked for each
detection, and mostly answered by none."""

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np

from runtime.core.kernels import objects as kernels
from runtime.core.types import F32, F64

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
        self._ids: list[int] = []
        self._row_of: dict[int, int] = {}

    @classmethod
    def of(cls, instances: Mapping[int, Placed]) -> "InstancePlaces":
        """Of all instances."""
        places = cls()
        places.put(instances.values())
        return places

    def __len__(self) -> int:
        return len(self._ids)

    def put(self, instances: Iterable[Placed]) -> None:
        """Add instances, or where they are now."""
        for one in instances:
            row = self._row_of.get(one.id)
            if row is None:
                row = self._row_of[one.id] = len(self._ids)
                self._ids.append(one.id)
                if row == self._rows.shape[1]:
                    self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)], axis=1)
            kernels.put_place(self._rows, row, one.xy, one.z_m, one.cells_xy)

    def near(
        self, xy: tuple[float, float], cells_xy: F64, within_m: float
    ) -> list[tuple[float, int]]:
        """Of a thing at `xy`, the instances that may have their middle, or a cell, so near to it,
        or their middle to one of its cells (N, 2) m: at least how far, and the id, nearest first.
        None is left out, some may be too many."""
        return kernels.near_places(self._rows, self._ids, xy, cells_xy, within_m + SLACK_M)

    def in_plain_view(self, depth_m: F32, lens: tuple[float, ...]) -> list[int]:
        """Ids of the instances whose middle is in the depth image, and not hidden: see the kernel
        of that name."""
        return kernels.in_plain_view(self._rows, self._ids, depth_m, lens)

    def within(self, xy: tuple[float, float], range_m: float) -> tuple[list[int], F64]:
        """Ids of the instances whose middle is so near, and those middles, (N, 3) m."""
        rows = self._rows[:3, : len(self)]
        gap2 = (rows[0] - xy[0]) ** 2 + (rows[1] - xy[1]) ** 2
        near = (gap2 <= (range_m + SLACK_M) ** 2).nonzero()[0]
        return [self._ids[row] for row in near.tolist()], rows[:, near].T
