"""Frontiers: connected sets of free cells that touch unknown, with ids that outlive map updates."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import NavigationMap
from runtime.core.types import F64, I32, Mask

_EIGHT = np.ones((3, 3), np.uint8)


MIN_CELLS = 7  # narrower than the robot's body: nothing to drive into
INHERIT_DILATION_CELLS = 2  # a frontier that moved by no more is the same one
INHERIT_SHARE = 0.3  # of the smaller of two frontiers, to be the same one
WALL_GAP_CELLS = 1  # free cells this close to an obstacle are not frontier


@dataclass
class FrontierMemory:
    """What makes ids stable: the last frontiers' cells in metres, and the next unused id."""

    next_id: int = 1
    cells_xy: dict[int, F64] = field(default_factory=dict)  # id -> (N, 2) m


def boundary(grid: NavigationMap, given_up: Mask) -> Mask:
    """(R, C) free cells that touch unknown (8-neighbourhood), away from obstacles and from what was
    given up."""
    rows, cols = grid.known_window(margin=2)
    free = grid.free[rows, cols]
    unknown = cv2.dilate(grid.unknown[rows, cols].view(np.uint8), _EIGHT)
    size = 2 * WALL_GAP_CELLS + 1
    walls = cv2.dilate(grid.occupied[rows, cols].view(np.uint8), np.ones((size, size), np.uint8))
    edge = np.zeros(grid.frame.shape, bool)
    edge[rows, cols] = free & (unknown > 0) & (walls == 0) & ~given_up[rows, cols]
    return edge


def components(edge: Mask, frame: GridFrame, min_cells: int) -> list[F64]:
    """(R, C) -> the 8-connected sets of `min_cells` cells or more, each (N, 2) m, in scan order."""
    rows = np.flatnonzero(edge.any(axis=1))
    if not len(rows):
        return []
    top = int(rows[0]) & ~1  # components are numbered by blocks of 2 x 2 cells
    part = edge[top : int(rows[-1]) + 1]
    _, labels = cv2.connectedComponents(part.view(np.uint8), connectivity=8)
    flat = np.flatnonzero(part)
    label = labels.reshape(-1)[flat]
    order = np.argsort(label, kind="stable")
    sizes = np.bincount(label)[1:]
    row, col = np.divmod(flat[order], frame.cols)
    xy = frame.centres(np.stack([row + top, col], axis=1).astype(np.int32))
    ends = np.cumsum(sizes)
    return [xy[end - n : end] for n, end in zip(sizes, ends, strict=True) if n >= min_cells]


def identify(memory: FrontierMemory, parts: list[F64], frame: GridFrame) -> dict[int, F64]:
    """Give each part an id, inherited from the earlier frontier it continues. In a split the larger
    part keeps the id, in a merge the older id wins; an id is never used twice."""
    overlap = _overlaps(memory, parts, frame, INHERIT_DILATION_CELLS)
    keeper: dict[int, tuple[int, int, int]] = {}  # old id -> (overlap, size, -part), the best
    for part, old, shared in overlap:
        if shared < INHERIT_SHARE * min(len(parts[part]), len(memory.cells_xy[old])):
            continue
        claim = (shared, len(parts[part]), -part)
        keeper[old] = max(keeper.get(old, claim), claim)
    inherited: dict[int, int] = {}  # part -> id
    for old in sorted(keeper):  # ids grow with time: the first claim is the oldest
        inherited.setdefault(-keeper[old][2], old)
    named: dict[int, F64] = {}
    for part, cells in enumerate(parts):
        if part not in inherited:
            inherited[part] = memory.next_id
            memory.next_id += 1
        named[inherited[part]] = cells
    memory.cells_xy = dict(sorted(named.items()))
    return memory.cells_xy


def _overlaps(
    memory: FrontierMemory, parts: list[F64], frame: GridFrame, dilation: int
) -> list[tuple[int, int, int]]:
    """(part, earlier id, cells of the part within the dilated earlier frontier), only if > 0."""
    if not parts or not memory.cells_xy:
        return []
    owner = np.full(frame.shape, -1, np.int16)
    cells, starts = _cells(parts, frame)
    owner[cells[:, 0], cells[:, 1]] = np.repeat(np.arange(len(parts)), [len(p) for p in parts])
    size = 2 * dilation + 1
    kernel = np.ones((size, size), np.uint8)
    cells, starts = _cells(memory.cells_xy.values(), frame)
    lows = np.maximum(np.minimum.reduceat(cells, starts) - dilation, 0)
    highs = np.minimum(np.maximum.reduceat(cells, starts) + dilation + 1, frame.shape)
    found = []
    for old, rc, low, high in zip(
        memory.cells_xy, np.split(cells, starts[1:]), lows, highs, strict=True
    ):
        claimed = owner[low[0] : high[0], low[1] : high[1]]
        patch = np.zeros(claimed.shape, np.uint8)
        patch[rc[:, 0] - low[0], rc[:, 1] - low[1]] = 1
        claimed = claimed[cv2.dilate(patch, kernel) > 0]
        shared = np.bincount(claimed[claimed >= 0])
        found += [(int(part), old, int(shared[part])) for part in np.flatnonzero(shared)]
    return found


def _cells(parts: Iterable[F64], frame: GridFrame) -> tuple[I32, NDArray[np.intp]]:
    """Some (N, 2) m -> (M, 2) row, col of all of them, and where each part begins."""
    parts = list(parts)
    starts = np.cumsum([0, *(len(part) for part in parts)])[:-1]
    return frame.cells(np.concatenate(parts)), starts
