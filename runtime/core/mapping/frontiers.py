"""Frontiers: connected sets of free cells that touch unknown, with ids that outlive map updates."""

import itertools
from dataclasses import dataclass, field

import numpy as np

from runtime.core.geometry import GridFrame
from runtime.core.kernels import mapping as kernels
from runtime.core.mapping.grid import NavigationMap
from runtime.core.mapping.windows import Window, between, ends, inside, joined, widened
from runtime.core.types import F64, I32, Mask

MIN_CELLS = 7  # narrower than the robot's body: nothing to drive into
INHERIT_DILATION_CELLS = 2  # a frontier that moved by no more is the same one
INHERIT_SHARE = 0.3  # of the smaller of two frontiers, to be the same one
_NOWHERE = np.zeros((0, 2))
BESIDE_CELLS = 2  # of a frontier's cell: there it is looked on which side the unknown lies
WALL_GAP_CELLS = 1  # free cells this close to an obstacle are not frontier


@dataclass
class FrontierMemory:
    """What makes ids stable: the last frontiers' cells in metres, and the next unused id."""

    next_id: int = 1
    cells_xy: dict[int, F64] = field(default_factory=dict)  # id -> (N, 2) m
    frame: GridFrame | None = None  # of the next two, by the identity of the arrays of cells
    shapes: dict[int, "_Shape"] = field(default_factory=dict, repr=False)
    shared: dict[tuple[int, int], int] = field(default_factory=dict, repr=False)


def boundary(grid: NavigationMap, given_up: Mask) -> Mask:
    """(R, C) free cells that touch unknown (8-neighbourhood), away from obstacles and from what was
    given up."""
    edge = np.zeros(grid.frame.shape, bool)
    _renew_edge(edge, grid.known_window(margin=2), grid, given_up)
    return edge


def _renew_edge(edge: Mask, window: Window, grid: NavigationMap, given_up: Mask) -> Window | None:
    """The boundary within a window, in place; the window of what changed."""
    if grid.zones.zones:
        return _renew_outside(edge, window, grid, given_up)
    changed = kernels.boundary(
        edge, grid.free, grid.unknown, grid.occupied, given_up, WALL_GAP_CELLS, ends(window)
    )
    return between(changed) if changed else None


def _renew_outside(
    edge: Mask, window: Window, grid: NavigationMap, given_up: Mask
) -> Window | None:
    """The same where there are zones: within one is no frontier, and nothing unknown to go to."""
    part = widened(window, max(1, WALL_GAP_CELLS), grid.frame)
    barred = grid.zones.barred(grid.frame)[part]
    changed = kernels.boundary(
        edge[part],
        grid.free[part],
        grid.unknown[part] & ~barred,
        grid.occupied[part],
        given_up[part] | barred,
        WALL_GAP_CELLS,
        ends(inside(window, part)),
    )
    if not changed:
        return None
    top, left = part[0].start, part[1].start
    return between((changed[0] + top, changed[1] + top, changed[2] + left, changed[3] + left))


def components(edge: Mask, frame: GridFrame, min_cells: int) -> list[F64]:
    """(R, C) -> the 8-connected sets of `min_cells` cells or more, each (N, 2) m, in scan order."""
    parts = kernels.components(edge, 0, 0)
    return [frame.centres(cells) for cells in parts if len(cells) >= min_cells]


def outward(grid: NavigationMap, cells_xy: F64) -> F64:
    """(N, 2) m -> (N, 2) toward what is unknown beside each of these cells, as long as there is
    much of it; 0, 0 where there is none, or as much on both sides."""
    cells = grid.frame.cells(cells_xy)
    total = np.zeros((len(cells), 2))
    for row, col in itertools.product(range(-BESIDE_CELLS, BESIDE_CELLS + 1), repeat=2):
        at = np.clip(cells + np.array([row, col]), 0, np.array(grid.frame.shape) - 1)
        total += grid.unknown[tuple(at.T)][:, None] * np.array([col, row])
    return total


@dataclass(frozen=True)
class _Part:
    """One connected set of the boundary: cells (N, 2) row, col and (N, 2) m, in scan order; no m
    where they are fewer than MIN_CELLS."""

    cells: I32
    cells_xy: F64
    low: tuple[int, int]
    high: tuple[int, int]
    rank: tuple[int, int]  # the first, in scan order, of the blocks of 2 x 2 cells that it lies in

    @classmethod
    def of(cls, cells: I32, frame: GridFrame) -> "_Part":
        top, bottom = int(cells[0, 0]), int(cells[-1, 0])
        left, right = int(cells[:, 1].min()), int(cells[:, 1].max())
        rank = top >> 1, int(cells[cells[:, 0] <= top | 1, 1].min()) >> 1
        cells_xy = frame.centres(cells) if len(cells) >= MIN_CELLS else _NOWHERE
        return cls(cells, cells_xy, (top, left), (bottom, right), rank)

    def meets(self, window: Window) -> bool:
        """Whether its box and the window have a cell in common."""
        (top, left), (bottom, right), (rows, cols) = self.low, self.high, window
        beside = left < cols.stop and cols.start <= right
        return bool(beside and top < rows.stop and rows.start <= bottom)


class Boundary:
    """The boundary of one map and its connected sets, made anew only where the map changes."""

    def __init__(self) -> None:
        self._frame: GridFrame | None = None
        self._revision = 0
        self._edge: Mask = np.zeros((0, 0), bool)
        self._parts: list[_Part] = []

    @property
    def edge(self) -> Mask:
        """(R, C) what `boundary` would be; updated in place."""
        return self._edge

    def update(self, grid: NavigationMap, given_up: Mask) -> list[F64]:
        """The map as it is now -> what `components` would find, of MIN_CELLS or more."""
        revision, window = grid.changed_since(self._revision)
        if self._frame != grid.frame:
            self._frame, self._edge = grid.frame, np.zeros(grid.frame.shape, bool)
            self._parts, window = [], grid.known_window(margin=2)
        if window is not None:
            self._renew(widened(window, max(1, WALL_GAP_CELLS), grid.frame), grid, given_up)
        self._revision = revision
        return [part.cells_xy for part in self._parts if len(part.cells) >= MIN_CELLS]

    def _renew(self, window: Window, grid: NavigationMap, given_up: Mask) -> None:
        touched = _renew_edge(self._edge, window, grid, given_up)
        if touched is None:
            return
        beside = widened(touched, 1, grid.frame)
        stale = [part for part in self._parts if part.meets(beside)]
        held = touched
        for part in stale:
            box = slice(part.low[0], part.high[0] + 1), slice(part.low[1], part.high[1] + 1)
            held = joined(held, box)
        # Other sets that reach into the same box are none of its.
        top, left = held[0].start & ~1, held[1].start & ~1
        mask = np.zeros((held[0].stop - top, held[1].stop - left), bool)
        for part in stale:
            mask[part.cells[:, 0] - top, part.cells[:, 1] - left] = True
        mask[inside(touched, (slice(top, 0), slice(left, 0)))] = self._edge[touched]
        before = {part.cells.tobytes(): part for part in stale}
        made = kernels.components(mask, top, left)
        new = [before.get(cells.tobytes()) or _Part.of(cells, grid.frame) for cells in made]
        gone = {id(part) for part in stale}
        parts = [part for part in self._parts if id(part) not in gone] + new
        self._parts = sorted(parts, key=lambda part: part.rank)


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
    """(part, earlier id, cells of the part within the dilated earlier frontier), only if > 0. What
    two sets share is counted once, as long as both are there."""
    if not parts or not memory.cells_xy:
        return []
    before = memory.shapes if memory.frame == frame else {}
    olds = [_shape(before, cells, frame) for cells in memory.cells_xy.values()]
    news = [_shape(before, cells, frame) for cells in parts]
    known = memory.shared if memory.frame == frame else {}
    memory.frame, memory.shapes = frame, {id(shape.cells_xy): shape for shape in news}
    memory.shared = {}
    ids, found = list(memory.cells_xy), []
    for n, part in _close(olds, news, dilation):
        shape, new = olds[n], news[part]
        pair = id(new.cells_xy), id(shape.cells_xy)
        shared = known[pair] if pair in known else new.within(shape, dilation)
        if pair[1] in memory.shapes:  # it is there the next time, too
            memory.shared[pair] = shared
        if shared:
            found.append((part, ids[n], shared))
    return found


def _close(olds: list["_Shape"], news: list["_Shape"], dilation: int) -> list[tuple[int, int]]:
    """The pairs, as places in the lists, whose boxes are no farther apart than that."""
    boxes = (np.array([shape.box for shape in shapes]) for shapes in (olds, news))
    old, new = (box.reshape(-1, 2, 2) for box in boxes)
    low, high = old[:, None, 0] - dilation, old[:, None, 1] + dilation
    near = (new[:, 0] <= high) & (new[:, 1] >= low)
    return [(n, part) for n, part in np.argwhere(near.all(axis=2)).tolist()]


def _shape(before: dict[int, "_Shape"], cells_xy: F64, frame: GridFrame) -> "_Shape":
    """Of cells (N, 2) m: as it was, where it is the same array."""
    known = before.get(id(cells_xy))
    if known is not None:
        return known
    cells = frame.cells(cells_xy)
    return _Shape(cells_xy, cells, (*cells.min(axis=0).tolist(), *cells.max(axis=0).tolist()))


@dataclass(frozen=True)
class _Shape:
    """A frontier's cells, (N, 2) m and (N, 2) row, col, and the box that holds them: its first row
    and column, and its last."""

    cells_xy: F64
    cells: I32
    box: tuple[int, int, int, int]

    def within(self, other: "_Shape", dilation: int) -> int:
        """How many of the cells lie within the dilated other."""
        if self.cells_xy is other.cells_xy:
            return len(self.cells)
        return kernels.shared(self.cells, other.cells, dilation)
