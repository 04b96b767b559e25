"""The map as pages have it: in square tiles, each with a number of its last change, so that each
page is sent what is new to it and no more."""

import math
import struct
import threading
import zlib
from dataclasses import dataclass
from typing import Final

import numpy as np

from runtime.core.types import U8

SIDE: Final = 64  # cells of a tile
UNKNOWN, FREE, OBSTACLE, NO_ROOM = 0, 1, 2, 255
CELLS, ROOMS = 0, 1  # planes of a tile
TILES_A_MESSAGE: Final = 256
MOST_TILES: Final = 1024  # of a map: 80 m by 80 m of cells of 4 cm
_OFF_GRID: Final = 0.1  # cells that two grids may lie apart and still be one
_HEAD: Final = struct.Struct("<BBHIfddH")
_PLACE: Final = struct.Struct("<ii")
_KIND, _VERSION = 1, 1
_EMPTY: Final = np.array([UNKNOWN, NO_ROOM], np.uint8)[:, None, None]


@dataclass(frozen=True)
class TileGrid:
    """(rows, cols) uint8 over the floor, row 0 at the least y; its corner in m of odometry's frame.
    What is beyond it is not known."""

    cells: U8
    resolution_m: float
    x0_m: float
    y0_m: float


@dataclass(frozen=True)
class TilesHeld:
    """How much of a map somebody has: of which epoch, and up to which change."""

    epoch: int = -1
    change: int = -1


class TileMap:
    """Any thread. Cells and rooms come by themselves, as they are told."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._tiles: dict[tuple[int, int], U8] = {}  # (col, row) -> (2, SIDE, SIDE)
        self._changed: dict[tuple[int, int], int] = {}
        self._grid: tuple[float, float, float] | None = None  # resolution, and where tile 0, 0 is
        self._epoch = self._change = 0

    def put(self, plane: int, grid: TileGrid) -> None:
        """All of one plane as it is now. A grid of more tiles than any home is left out."""
        with self._lock:
            placed = self._placed(grid)
            if placed is None:
                return
            col, row = placed
            rows, cols = grid.cells.shape
            across = range(col // SIDE, -(-(col + cols) // SIDE))
            up = range(row // SIDE, -(-(row + rows) // SIDE))
            if len(across) * len(up) > MOST_TILES:
                return
            empty = int(_EMPTY[plane, 0, 0])
            whole = np.full((len(up) * SIDE, len(across) * SIDE), empty, np.uint8)
            top, left = row - up.start * SIDE, col - across.start * SIDE
            whole[top : top + rows, left : left + cols] = grid.cells
            self._change += 1
            for place in self._tiles.keys() - {(c, r) for c in across for r in up}:
                self._fill(place, plane, None)
            for r in up:
                for c in across:
                    y, x = (r - up.start) * SIDE, (c - across.start) * SIDE
                    part = whole[y : y + SIDE, x : x + SIDE]
                    known = (c, r) in self._tiles or bool((part != empty).any())
                    if known:
                        self._fill((c, r), plane, part)

    def clear(self) -> None:
        """Nothing is known any more."""
        with self._lock:
            if self._grid is not None:
                self._anew(self._grid)

    def since(self, seen: TilesHeld) -> tuple[bytes, TilesHeld] | None:
        """The next message for somebody who has so much, and what he has then; None for nothing."""
        with self._lock:
            if self._grid is None:
                return None
            known = seen.change if seen.epoch == self._epoch else -1
            new = sorted((n, place) for place, n in self._changed.items() if n > known)
            if not new and seen.epoch == self._epoch:
                return None
            # Tiles of one change are not parted: who has a change has all of it.
            last = new[min(len(new), TILES_A_MESSAGE) - 1][0] if new else self._change
            sent = [place for n, place in new if n <= last]
            tiles = [self._tiles[place].copy() for place in sent]
            resolution_m, x0_m, y0_m = self._grid
            epoch = self._epoch
        head = _HEAD.pack(_KIND, _VERSION, SIDE, epoch, resolution_m, x0_m, y0_m, len(sent))
        places = b"".join(_PLACE.pack(*place) for place in sent)
        packed = zlib.compress(b"".join(tile.tobytes() for tile in tiles), 1)
        return head + places + packed, TilesHeld(epoch, last)

    def _placed(self, grid: TileGrid) -> tuple[int, int] | None:
        """The column and row of its corner; None for a grid that is none. One that does not lie on
        the cells of before begins the map anew."""
        told = grid.resolution_m, grid.x0_m, grid.y0_m
        if grid.cells.ndim != 2 or not all(map(math.isfinite, told)) or grid.resolution_m <= 0:
            return None
        if self._grid is None or abs(self._grid[0] - grid.resolution_m) > 1e-6:
            return self._anew(told)
        col = (grid.x0_m - self._grid[1]) / grid.resolution_m
        row = (grid.y0_m - self._grid[2]) / grid.resolution_m
        far = max(abs(col), abs(row)) > MOST_TILES * SIDE
        if far or max(abs(col - round(col)), abs(row - round(row))) > _OFF_GRID:
            return self._anew(told)
        return round(col), round(row)

    def _anew(self, told: tuple[float, float, float]) -> tuple[int, int]:
        self._grid, self._epoch = told, self._epoch + 1
        self._tiles.clear()
        self._changed.clear()
        return 0, 0

    def _fill(self, place: tuple[int, int], plane: int, part: U8 | None) -> None:
        """Holding the lock. None: nothing is known there any more."""
        tile = self._tiles.get(place)
        if tile is None:
            tile = self._tiles[place] = np.broadcast_to(_EMPTY, (2, SIDE, SIDE)).copy()
        wanted = _EMPTY[plane] if part is None else part
        if not np.array_equal(tile[plane], np.broadcast_to(wanted, (SIDE, SIDE))):
            tile[plane] = wanted
            self._changed[place] = self._change
