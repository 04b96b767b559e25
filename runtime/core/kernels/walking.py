"""The compiled part of what is told by walking distance, or by what is in sight."""

import numpy as np

from runtime.core.kernels import _compiled
from runtime.core.types import F32, F64, I32, Mask


def walk(passable: Mask, seeds: Mask, limit: int) -> tuple[F32, int]:
    """(r, c) masks -> steps from the seeds by cells that are passable, inf where more than `limit`
    would be needed; and how many cells were reached, the seeds among them. Odd steps lead to four
    neighbours, even ones to eight; the first that leads nowhere is the last."""
    steps = np.empty(seeds.shape, np.float32)
    reached = _compiled.walk(steps, passable, seeds, limit)
    return steps, reached


def reach_things(away: F32, cells: I32, starts: I32, margin: int) -> F32:
    """(M,) the least of `away` (r, c) in squares of `margin` cells around the cells (N, 2) of M
    things, those of one from `starts` (M,) on; cells outside count for nothing. inf for none."""
    nearest: F32 = np.empty(len(starts), np.float32)
    each, first = np.ascontiguousarray(cells), starts.reshape(1, -1)
    _compiled.reach_things(nearest.reshape(1, -1), away, each, first, margin)
    return nearest


def means(layers: F32, passable: Mask, cells: I32, ends: I32, limit: int) -> F32:
    """For each of M sets of cells, (N, 2) in all, those of one before `ends` (M,): the mean of each
    of `layers` (L, r, c) over what a walk of so many steps reaches, (M, L), summed row by row."""
    found: F32 = np.empty((len(ends), len(layers)), np.float32)
    each, last = np.ascontiguousarray(cells), ends.reshape(1, -1)
    stack = layers.reshape(-1, layers.shape[-1])
    _compiled.means(found, stack, passable, each, last, limit)
    return found


def nearest(
    arrival: F64, cells: I32, ends: I32, snap: int, first: tuple[int, int]
) -> tuple[I32, F64]:
    """For each of M sets of cells, (N, 2) in all, those of one before `ends` (M,): where `arrival`
    (r, c) is least, the first of equals, (M, 2), and how much it is there, (M,). Where it is inf at
    all of them, the same of the squares of `snap` cells round them, but for what lies before the
    row and column `first`. Cells are counted from arrival's; outside it is inf."""
    places, away = np.empty((len(ends), 2), np.int32), np.empty((1, len(ends)))
    each, last = np.ascontiguousarray(cells), ends.reshape(1, -1)
    _compiled.nearest(arrival, each, last, places, away, snap, *first)
    return places, away[0]


def in_sight(
    occupied: Mask,
    place: tuple[float, float, float, int, int],
    start: tuple[float, float],
    ends: F64,
    steps: int,
) -> Mask:
    """Of lines from a point to others, (N, 2) m: whether none of `steps` points of each, the last,
    its end, left out, is in an occupied cell (r, c); what is outside is none. (N,) `place`: the
    whole grid's corner and its cells' length, m, and the first row and column of this part."""
    seen: Mask = np.empty(len(ends), bool)
    lines = np.ascontiguousarray(ends)
    _compiled.in_sight(seen.reshape(1, -1), occupied, lines, *place, *start, steps)
    return seen
