"""Tiles of the map: who has them all can draw exactly what was told, whatever he missed."""

import struct
import zlib

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.view.tiles import (
    CELLS,
    MOST_TILES,
    NO_ROOM,
    ROOMS,
    SIDE,
    TILES_A_MESSAGE,
    TileGrid,
    TileMap,
    TilesHeld,
)

HEAD = struct.Struct("<BBHIfddH")


class DrawnMap:
    """What a page makes of the messages that it gets."""

    def __init__(self) -> None:
        self.tiles: dict[tuple[int, int], np.ndarray] = {}
        self.seen, self.messages = TilesHeld(), 0
        self.corner = 0.0, 0.0

    def catch_up(self, tiles: TileMap) -> None:
        while (found := tiles.since(self.seen)) is not None:
            message, seen = found
            if seen.epoch != self.seen.epoch:
                self.tiles.clear()
            self.seen, self.messages = seen, self.messages + 1
            *_, x0_m, y0_m, n = HEAD.unpack_from(message)
            self.corner = x0_m, y0_m
            places = [struct.unpack_from("<ii", message, HEAD.size + 8 * k) for k in range(n)]
            packed = zlib.decompress(message[HEAD.size + 8 * n :])
            parts = np.frombuffer(packed, np.uint8).reshape(n, 2, SIDE, SIDE)
            for (col, row), part in zip(places, parts, strict=True):
                self.tiles[col, row] = part

    def known(self, plane: int) -> set[tuple[float, float, int]]:
        """(x, y) m of each known cell's corner, and what is there."""
        found = set()
        for (col, row), part in self.tiles.items():
            empty = 0 if plane == CELLS else NO_ROOM
            for r, c in np.argwhere(part[plane] != empty).tolist():
                x_m = self.corner[0] + (col * SIDE + c) * 0.05
                y_m = self.corner[1] + (row * SIDE + r) * 0.05
                found.add((round(x_m, 3), round(y_m, 3), int(part[plane][r, c])))
        return found


def grid_at(x_m: float, y_m: float, cells: np.ndarray, resolution_m: float = 0.05) -> TileGrid:
    return TileGrid(cells.astype(np.uint8), resolution_m, x_m, y_m)


def told(one: TileGrid, empty: int = 0) -> set[tuple[float, float, int]]:
    return {
        (round(one.x0_m + c * 0.05, 3), round(one.y0_m + r * 0.05, 3), int(one.cells[r, c]))
        for r, c in np.argwhere(one.cells != empty).tolist()
    }


def test_before_anything_is_known_there_is_nothing_to_send():
    assert TileMap().since(TilesHeld()) is None


windows = st.tuples(
    st.integers(-150, 150), st.integers(-150, 150), st.integers(1, 140), st.integers(1, 140)
)


@settings(deadline=None, max_examples=40)
@given(st.lists(windows, min_size=1, max_size=5), st.integers(0, 2**31), st.data())
def test_whoever_catches_up_now_and_then_draws_the_newest_map(
    drawn: list[tuple[int, int, int, int]], seed: int, data: st.DataObject
):
    """The known window moves, grows and shrinks; pages come late, and miss some."""
    tiles, early = TileMap(), DrawnMap()
    rng = np.random.default_rng(seed)
    for col, row, rows, cols in drawn:
        cells = rng.integers(0, 3, (rows, cols)) * (rng.random((rows, cols)) < 0.01)
        newest = grid_at(1.0 + col * 0.05, -2.0 + row * 0.05, cells)
        tiles.put(CELLS, newest)
        if data.draw(st.booleans()):
            early.catch_up(tiles)
    late = DrawnMap()
    late.catch_up(tiles)
    early.catch_up(tiles)
    assert early.known(CELLS) == late.known(CELLS) == told(newest)
    assert tiles.since(late.seen) is None


def test_only_what_changed_is_sent():
    tiles, page = TileMap(), DrawnMap()
    cells = np.ones((4 * SIDE, 4 * SIDE), np.uint8)
    tiles.put(CELLS, grid_at(0.0, 0.0, cells))
    page.catch_up(tiles)
    cells[5, 5] = 2
    tiles.put(CELLS, grid_at(0.0, 0.0, cells))
    message, _ = tiles.since(page.seen) or (b"", page.seen)
    assert HEAD.unpack_from(message)[-1] == 1
    tiles.put(CELLS, grid_at(0.0, 0.0, cells))
    page.catch_up(tiles)
    assert tiles.since(page.seen) is None


def test_cells_and_rooms_come_by_themselves():
    tiles, page = TileMap(), DrawnMap()
    tiles.put(CELLS, grid_at(0.0, 0.0, np.ones((10, 10))))
    rooms = np.full((20, 20), NO_ROOM)
    rooms[15, 15] = 3
    tiles.put(ROOMS, grid_at(-0.5, -0.5, rooms))
    page.catch_up(tiles)
    assert len(page.known(CELLS)) == 100
    assert page.known(ROOMS) == {(0.25, 0.25, 3)}


def test_a_map_that_lies_otherwise_begins_anew():
    """A new search: its cells lie where the robot stood."""
    tiles, page = TileMap(), DrawnMap()
    tiles.put(CELLS, grid_at(0.0, 0.0, np.ones((10, 10))))
    page.catch_up(tiles)
    tiles.put(CELLS, grid_at(0.02, 0.0, np.ones((3, 3))))
    page.catch_up(tiles)
    assert page.seen.epoch == 2
    assert len(page.known(CELLS)) == 9


def test_a_large_map_goes_in_more_messages_than_one():
    tiles, page = TileMap(), DrawnMap()
    for n in range(2):
        cells = np.zeros((SIDE, TILES_A_MESSAGE * SIDE), np.uint8)
        cells[0] = 1
        both = np.vstack([cells, cells]) if n else cells
        tiles.put(CELLS, grid_at(0.0, 0.0, both))
    page.catch_up(tiles)
    assert page.messages == 2
    assert len(page.tiles) == 2 * TILES_A_MESSAGE


def test_a_map_that_is_no_home_is_left_out():
    tiles = TileMap()
    tiles.put(CELLS, grid_at(0.0, 0.0, np.ones((SIDE, SIDE))))
    _, seen = tiles.since(TilesHeld()) or (b"", TilesHeld())
    wide = np.ones((SIDE, (MOST_TILES + 1) * SIDE), np.uint8)
    for nonsense in (
        grid_at(0.0, 0.0, wide),
        grid_at(np.nan, 0.0, np.ones((2, 2))),
        grid_at(0.0, 0.0, np.ones((2, 2)), 0.0),
        grid_at(0.0, 0.0, np.ones(3)),
    ):
        tiles.put(CELLS, nonsense)
        assert tiles.since(seen) is None
