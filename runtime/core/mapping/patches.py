"""Surfaces cut into patches: what of each may bear what is looked for, how likely it was missed
there, and how likely it is there, after all that was looked at in vain."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.mapping import fineness
from runtime.core.mapping.drops import DROP_AT
from runtime.core.mapping.fineness import FLOOR, RAISED, WIDER, Fineness, GoalSize
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import Window, part_frame
from runtime.core.types import F32, F64, Mask

TILE: Final = 8  # cells of the layers to a patch's side: the grid grows by whole patches
UNLIKELY: Final = 0.1  # share of what never stands on the floor, or always, that does, or not
LARGE_M: Final = 0.35  # what is so large may be the surface itself
OTHER: Final = 0.2  # of a table's, what an obstacle of which no level surface was seen may bear
FLAT: Final = 0.05  # of what stands on the floor, so flat that it is taken for floor, by its area
PRESENT: Final = 0.9  # how likely what is asked for is there at all
HIDDEN_M2: Final = 1.5  # of surfaces, that what no look shows counts as: drawers, behind things
ITS_OWN: Final = 0.5  # of the most of a cell, from which on a patch is about that cell


@dataclass(frozen=True)
class Patch:
    """A part of the surfaces, about `xy` m. `area_m2`: of what may bear the goal, a floor counting
    as little as it may. `missed`: how likely the goal was missed there, were it there. `likely`:
    how likely it is there. `gain`: how likely a look from near would find it there. `px_m`: pixels
    a metre of the finest look at it, 0 for none, and `sides` from which there were looks about so
    fine, by bits. `cells_xy` (N, 2) m: what there is to look at."""

    id: int
    xy: tuple[float, float]
    area_m2: float
    missed: float
    likely: float
    gain: float
    px_m: float
    sides: int
    cells_xy: F64 = field(repr=False)


@dataclass(frozen=True)
class Visit:
    """A patch that is gone to, and from where it is looked at, (N, 2) m."""

    patch: Patch
    stands_xy: F64 = field(repr=False)


@dataclass
class Closer:
    """What is looked for, how finely each place was looked at for it, and which patches, by id,
    were gone to for that."""

    wanted: GoalSize = field(default_factory=GoalSize)
    fineness: Fineness = field(default_factory=Fineness)
    done: set[int] = field(default_factory=set)
    visit: Visit | None = None

    def afresh(self) -> "Closer":
        """For another goal."""
        return Closer(fineness=self.fineness.afresh())


@dataclass(frozen=True)
class Surfaces:
    """Of a map as it is now: over a window of whole patches, by layer, how much of each cell may
    bear the goal (2, r, c) m2, how likely it was missed there, and would be after a look from
    near."""

    frame: GridFrame  # of the window
    fineness: Fineness
    window: Window
    borne_m2: F32
    missed: F32
    least: float

    @classmethod
    def of(
        cls, grid: NavigationMap, closer: Closer, near_px_m: float, weights: F32 | None = None
    ) -> "Surfaces":
        """`near_px_m`: pixels a metre of a look from near; `weights` (2, R, C): how much more
        likely than elsewhere the goal is there, by what else is known."""
        fine, wanted = closer.fineness, closer.wanted
        frame = fine.fit(grid.frame)
        window = _in_tiles(grid.known_window(0), frame)
        things = grid.occupied & (grid.drops < DROP_AT)  # where floor drops nothing stands
        free, occupied = (_wider(mask, window) for mask in (grid.free, things))
        if grid.zones.zones:
            allowed = ~_wider(grid.zones.barred(grid.frame), window)
            free, occupied = free & allowed, occupied & allowed
        level = fine.level[window] & (occupied | free)
        borne = np.zeros((2, *free.shape), np.float32)
        stands = UNLIKELY + (1.0 - 2.0 * UNLIKELY) * wanted.on_floor
        bears = 1.0 if wanted.size_m >= LARGE_M else 1.0 - stands
        borne[RAISED] = np.where(level, bears, np.where(occupied, max(OTHER, stands), 0.0))
        borne[FLOOR] = np.where(free & ~level, FLAT * stands, 0.0)
        if weights is not None:
            borne *= weights[:, *window]
        borne *= np.float32(frame.resolution_m**2)
        least = float(fineness.missed_at(wanted, near_px_m))
        here = part_frame(frame, window)
        return cls(here, fine, window, borne, fine.missed(wanted, window), least)

    @property
    def gains_m2(self) -> F32:
        """(2, r, c) what a look from near would find, from a side from which there was none."""
        once, more = np.float32(self.least), np.float32(self.least**fineness.OTHER_SIDES)
        after = np.minimum(once, self.missed * more)
        return np.asarray(self.borne_m2 * (self.missed - after))

    @property
    def all_m2(self) -> float:
        """What stands for certain: how likely things are is their part of this."""
        borne, missed = float(self.borne_m2.sum()), float((self.borne_m2 * self.missed).sum())
        return missed + HIDDEN_M2 + (borne + HIDDEN_M2) * (1.0 - PRESENT) / PRESENT

    def patches(
        self, worth: Callable[[F64, F64], Mask], only: int | None = None
    ) -> tuple[Patch, ...]:
        """Those of which `worth` holds, of how likely the goal is there and that a look finds it,
        both (R, C) by patch; or of these the one of that id."""
        likely = _by_tile(self.borne_m2 * self.missed) / self.all_m2
        gain = _by_tile(self.gains_m2) / self.all_m2
        tiles = np.argwhere(worth(likely, gain) & (likely > 0.0)).tolist()
        return tuple(
            self._patch(r, c, float(likely[r, c]), float(gain[r, c]))
            for r, c in tiles
            if only in (None, self.number(r, c))
        )

    def number(self, row: int, col: int) -> int:
        """The id of a patch: the same when the map has grown."""
        first = self.fineness.first
        down = (self.window[0].start - first[0]) // TILE + row
        right = (self.window[1].start - first[1]) // TILE + col
        return int((down + _MOST) * 2 * _MOST + right + _MOST)

    def _patch(self, row: int, col: int, likely: float, gain: float) -> Patch:
        rows, cols = slice(row * TILE, (row + 1) * TILE), slice(col * TILE, (col + 1) * TILE)
        borne, missed = self.borne_m2[:, rows, cols], self.missed[:, rows, cols]
        left = (borne * missed).sum(axis=0)
        most = left >= ITS_OWN * left.max()
        r, c = np.nonzero(most)
        cells = np.stack([r + rows.start, c + cols.start], axis=1).astype(np.int32)
        cells_xy = self.frame.centres(cells)
        x, y = (cells_xy * left[most, None]).sum(axis=0) / left[most].sum()
        layer = int((borne * missed).sum(axis=(1, 2)).argmax())
        part = layer, *(inner[most] for inner in np.mgrid[self._in_whole(rows, cols)])
        codes, sides = self.fineness.fine[part], self.fineness.sides[part]
        area_m2, finest = float(borne.sum()), codes.max()
        return Patch(
            self.number(row, col),
            (float(x), float(y)),
            area_m2,
            float(left.sum()) / area_m2,
            likely,
            gain,
            float(fineness.px_m(finest)),
            int(np.bitwise_or.reduce(sides[codes == finest])) if finest else 0,
            cells_xy,
        )

    def _in_whole(self, rows: slice, cols: slice) -> Window:
        """A part of the window, in the layers."""
        (top, left) = (part.start for part in self.window)
        return (
            slice(rows.start + top, rows.stop + top),
            slice(cols.start + left, cols.stop + left),
        )


_MOST = 1 << 12  # patches to each side of the first map's corner


def _in_tiles(window: Window, frame: GridFrame) -> Window:
    """A window of the map as one of whole patches of the layers, as far as those reach."""
    side = WIDER * TILE
    rows, cols = (
        slice(part.start // side * TILE, min(-(-part.stop // side), size // TILE) * TILE)
        for part, size in zip(window, frame.shape, strict=True)
    )
    return rows, cols


def _wider(mask: Mask, window: Window) -> Mask:
    """(R, C) of the map -> (r, c) of a window of the layers: where any cell is."""
    rows, cols = (slice(WIDER * part.start, WIDER * part.stop) for part in window)
    part = mask[rows, cols]
    return np.asarray(
        part.reshape(part.shape[0] // WIDER, WIDER, part.shape[1] // WIDER, WIDER).any(axis=(1, 3))
    )


def _by_tile(layers: F32) -> F64:
    """(2, r, c) -> sums by patch."""
    _, rows, cols = layers.shape
    tiles = layers.reshape(2, rows // TILE, TILE, cols // TILE, TILE)
    return np.asarray(tiles.sum(axis=(0, 2, 4)), np.float64)
