"""Rooms of an apartment whose walls stand free: where one ends, and what kind it is."""

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import Point, Polygon
from hil_sim.scenes.robothor.footprints import Footprint

OPENING_M = 2.0
"""From a wall's end to what is ahead of it or beside it: as wide as a way into a room may be."""
DOORWAY_M = 1.2
LEAST_M2 = 2.0
SAME_M = 0.04
JOIN_M = 0.05
"""Walls nearer than this touch."""
VOTES: dict[str, dict[str, float]] = {
    "Bed": {"bedroom": 4.0},
    "Sofa": {"living room": 3.0},
    "ArmChair": {"living room": 1.0},
    "Television": {"living room": 1.0},
    "TVStand": {"living room": 1.0},
    "CoffeeTable": {"living room": 1.0},
    "DiningTable": {"dining room": 3.0},
    "Desk": {"study": 2.5},
    "Dresser": {"bedroom": 1.0},
    "Pillow": {"bedroom": 0.3, "living room": 0.2},
    "Plate": {"dining room": 0.2},
    "Pot": {"dining room": 0.2},
    "Laptop": {"study": 0.3},
    "AlarmClock": {"bedroom": 0.3},
}
"""What each type of furniture says about the room it stands in; RoboTHOR has no kitchens or
bathrooms."""

Rectangle = tuple[float, float, float, float]
Segment = tuple[Point, Point]


def regions(outer: Rectangle, walls: Sequence[Segment]) -> tuple[Polygon, ...]:
    """Polygons that tile the rectangle (x0, y0, x1, y1), split along the walls and across openings
    between a wall's end and the next wall; parts under 2 m² join a neighbour."""
    x0, y0, x1, y1 = outer
    walls = _snapped(walls, outer)
    edge = [((x0, y0), (x1, y0)), ((x0, y1), (x1, y1)), ((x0, y0), (x0, y1)), ((x1, y0), (x1, y1))]
    lines = [*edge, *walls]
    chains = [-1] * len(edge) + _chains(walls)
    cuts = list(walls)
    for point in (end for wall in walls for end in wall):
        cuts += _openings(point, lines, chains)
    xs = sorted({x0, x1, *(round(x, 3) for cut in cuts for x, _ in cut)})
    ys = sorted({y0, y1, *(round(y, 3) for cut in cuts for _, y in cut)})
    names = _flood(xs, ys, cuts)
    names = _joined(names, xs, ys)
    return tuple(_outline(names == name, xs, ys) for name in sorted(set(names.ravel().tolist())))


def _snapped(walls: Sequence[Segment], outer: Rectangle) -> list[Segment]:
    """Walls on nearly the same line put on the same one, so that no slit is left between."""
    names: list[dict[float, float]] = []
    for axis in (0, 1):
        kept = sorted((outer[axis], outer[axis + 2]))
        table = {}
        for value in sorted({end[axis] for wall in walls for end in wall}):
            near = min(kept, key=lambda other: abs(other - value))
            if abs(near - value) > SAME_M:
                kept.append(near := value)
            table[value] = near
        names.append(table)
    return [((names[0][a], names[1][b]), (names[0][c], names[1][d])) for (a, b), (c, d) in walls]


def _openings(point: Point, lines: Sequence[Segment], chains: Sequence[int]) -> list[Segment]:
    """The cut from a wall's end to what is ahead of it: across the mouth of a niche whose walls
    hang together, or straight on over a doorway; else the shortest. Where walls meet, only
    straight on from one of them."""
    rows = list(zip(lines, chains, strict=True))
    mine = [chain for line, chain in rows if _distance(point, line) < JOIN_M]
    found: list[tuple[bool, float, Segment]] = []
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        ahead, behind = _beside(point, dx, dy, lines), _beside(point, -dx, -dy, lines)
        if ahead or (len(mine) > 1 and not behind):
            continue
        for line, chain in rows:
            hit = _ahead(point, (dx, dy), line)
            if hit is not None and 0.1 < hit <= OPENING_M:
                end = (point[0] + dx * hit, point[1] + dy * hit)
                doorway = behind and hit <= DOORWAY_M
                found.append((chain not in mine and not doorway, hit, (point, end)))
    return [min(found)[2]] if found else []


def _beside(point: Point, dx: int, dy: int, lines: Sequence[Segment]) -> bool:
    """Whether a line runs on from the point in this direction."""
    near = point[0] + dx * JOIN_M, point[1] + dy * JOIN_M
    return any(_distance(near, line) < 0.6 * JOIN_M for line in lines)


def _chains(walls: Sequence[Segment]) -> list[int]:
    """Which walls hang together: the same number for those that touch."""
    names = list(range(len(walls)))
    for _ in walls:
        for i, wall in enumerate(walls):
            for j, other in enumerate(walls):
                if min(_distance(end, other) for end in wall) < JOIN_M:
                    names[i] = names[j] = min(names[i], names[j])
    return names


def _ahead(point: Point, step: tuple[int, int], line: Segment) -> float | None:
    """Metres straight ahead to a line across, or to the nearer end of one in the same row."""
    axis = 0 if step[0] else 1
    other, sign = 1 - axis, step[axis]
    low, high = sorted((line[0][other], line[1][other]))
    near = min((end[axis] - point[axis]) * sign for end in line)
    if near <= 0 or not low - 0.1 <= point[other] <= high + 0.1:
        return None
    return near


def _distance(point: Point, line: Segment) -> float:
    (x0, y0), (x1, y1) = line
    dx = max(min(x0, x1) - point[0], 0.0, point[0] - max(x0, x1))
    dy = max(min(y0, y1) - point[1], 0.0, point[1] - max(y0, y1))
    return math.hypot(dx, dy)


def _flood(xs: Sequence[float], ys: Sequence[float], cuts: Sequence[Segment]) -> NDArray[np.int64]:
    """(rows, cols) region of each rectangle between neighbouring lines."""
    rows, cols = len(ys) - 1, len(xs) - 1
    names = np.arange(rows * cols).reshape(rows, cols)
    for _ in range(rows * cols):
        before = names.copy()
        for r in range(rows):
            for c in range(cols):
                x, y = (xs[c] + xs[c + 1]) / 2, (ys[r] + ys[r + 1]) / 2
                if c + 1 < cols and not _cut_at((xs[c + 1], y), cuts):
                    names[r, c : c + 2] = names[r, c : c + 2].min()
                if r + 1 < rows and not _cut_at((x, ys[r + 1]), cuts):
                    names[r : r + 2, c] = names[r : r + 2, c].min()
        if (names == before).all():
            break
    return names


def _cut_at(point: Point, cuts: Sequence[Segment]) -> bool:
    return any(_distance(point, cut) < 1e-3 for cut in cuts)


def _joined(
    names: NDArray[np.int64], xs: Sequence[float], ys: Sequence[float]
) -> NDArray[np.int64]:
    """Small regions join the neighbour with the longest common border."""
    areas = np.outer(np.diff(ys), np.diff(xs))
    while True:
        sizes = {name: areas[names == name].sum() for name in set(names.ravel().tolist())}
        name = min(sizes, key=lambda n: (sizes[n], n))
        if sizes[name] >= LEAST_M2 or len(sizes) == 1:
            return names
        border: dict[int, float] = defaultdict(float)
        for r, c in np.argwhere(names == name):
            for dr, dc in ((0, 1), (0, -1), (1, 0), (-1, 0)):
                row, col = r + dr, c + dc
                if 0 <= row < names.shape[0] and 0 <= col < names.shape[1]:
                    length = ys[r + 1] - ys[r] if dc else xs[c + 1] - xs[c]
                    border[int(names[row, col])] += length
        border.pop(name, None)
        names = np.where(names == name, max(border, key=lambda n: (border[n], -n)), names)


def _outline(mine: NDArray[np.bool_], xs: Sequence[float], ys: Sequence[float]) -> Polygon:
    """The boundary of a set of rectangles, counter-clockwise, corners only."""
    padded = np.pad(mine, 1)
    after: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
    for r, c in np.argwhere(mine).tolist():
        ring = [(c, r), (c + 1, r), (c + 1, r + 1), (c, r + 1)]
        beyond = [padded[r, c + 1], padded[r + 1, c + 2], padded[r + 2, c + 1], padded[r + 1, c]]
        for i in range(4):
            if not beyond[i]:
                after[ring[i]].append(ring[(i + 1) % 4])
    start = min(after)
    corner, points = after[start].pop(), [start]
    while corner != start:
        points.append(corner)
        corner = after[corner].pop()
    return _corners([(xs[c], ys[r]) for c, r in points])


def _corners(points: Sequence[Point]) -> Polygon:
    kept = []
    for i, (x, y) in enumerate(points):
        (xa, ya), (xb, yb) = points[i - 1], points[(i + 1) % len(points)]
        if abs((x - xa) * (yb - y) - (y - ya) * (xb - x)) > 1e-9:
            kept.append((x, y))
    return tuple(kept)


def room_type(things: Sequence[tuple[str, Footprint]]) -> str:
    """One of scene.ROOM_TYPES from the AI2-THOR types of what stands in a room; "hallway" where
    nothing says more."""
    score: dict[str, float] = defaultdict(float)
    for name, _ in things:
        for kind, vote in VOTES.get(name, {}).items():
            score[kind] += vote
    if not score or max(score.values()) < 1.0:
        return "hallway"
    return max(sorted(score), key=lambda kind: score[kind])
