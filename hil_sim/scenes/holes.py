"""Where a scene has no floor: how deep it is there, and the surfaces that are seen in it."""

import itertools
import math
from collections.abc import Iterable, Sequence

import numpy as np

from hil_sim.scenes.format import Hole, Point, Polygon, contains
from runtime.core.types import F64

RISE_M, RUN_M = 0.18, 0.28
"""Of a tread."""
PIECE_M = 0.1
"""Sides are drawn in pieces of that length: what is beside each may be lower than what is beside
the next."""
BESIDE_M = 0.005
Level = tuple[Polygon, float]  # how deep it lies, m


def depth_at(holes: Iterable[Hole], x: float, y: float) -> float:
    """How far below the floor the ground is at a point, m; 0 where the floor is whole."""
    return max((_depth(hole, x, y) for hole in holes if contains(hole.polygon, x, y)), default=0.0)


def _depth(hole: Hole, x: float, y: float) -> float:
    if hole.stairs_rad is None:
        return hole.depth_m
    ahead = math.cos(hole.stairs_rad), math.sin(hole.stairs_rad)
    begins = min(ahead[0] * px + ahead[1] * py for px, py in hole.polygon)
    tread = max(0, math.floor((ahead[0] * x + ahead[1] * y - begins) / RUN_M))
    return min(hole.depth_m, RISE_M * (tread + 1))


def levels(hole: Hole) -> list[Level]:
    """The level parts of its ground: one, or as many as it has treads, and what comes after."""
    if hole.stairs_rad is None:
        return [(hole.polygon, hole.depth_m)]
    c, s = math.cos(hole.stairs_rad), math.sin(hole.stairs_rad)
    along = [c * x + s * y for x, y in hole.polygon]
    treads = min(math.ceil(hole.depth_m / RISE_M), math.ceil((max(along) - min(along)) / RUN_M))
    found = []
    for n in range(treads):
        begins = min(along) + n * RUN_M
        part = _beyond(hole.polygon, (c, s), begins)
        if n + 1 < treads:
            part = _beyond(part, (-c, -s), -begins - RUN_M)
        if len(part) >= 3:
            found.append((part, min(hole.depth_m, RISE_M * (n + 1))))
    return found


def _beyond(polygon: Polygon, ahead: Point, least: float) -> Polygon:
    """The part of a convex polygon that is so far on in a direction."""
    kept: list[Point] = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        da, db = (ahead[0] * x + ahead[1] * y - least for x, y in (a, b))
        if da >= 0:
            kept.append(a)
        if (da >= 0) != (db >= 0):
            t = da / (da - db)
            kept.append((a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))
    return tuple(kept)


def sides(holes: Sequence[Hole]) -> F64:
    """(N, 2, 3, 3) m: upright walls and risers, two triangles each, that face what is lower."""
    found = []
    for hole in holes:
        for polygon, depth_m in levels(hole):
            for a, b, out in _pieces(polygon):
                middle = (a + b) / 2 + BESIDE_M * out
                beside_m = depth_at(holes, float(middle[0]), float(middle[1]))
                if beside_m < depth_m - 1e-6:
                    low, high = -depth_m, -beside_m
                    p, q = np.r_[a, low], np.r_[b, low]
                    r, t = np.r_[b, high], np.r_[a, high]
                    found.append([[p, q, r], [p, r, t]])
    return np.array(found, np.float64).reshape(-1, 2, 3, 3)


def _pieces(polygon: Polygon) -> Iterable[tuple[F64, F64, F64]]:
    """The polygon's rim in short pieces: their ends, so that the inside is in front, and the unit
    vector that leads out."""
    pairs = list(zip(polygon, polygon[1:] + polygon[:1], strict=True))
    area = sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in pairs)
    for start, end in pairs:
        a, b = np.array(start, np.float64), np.array(end, np.float64)
        length = float(np.hypot(*(b - a)))
        if length < 1e-9:
            continue
        out = np.array([b[1] - a[1], a[0] - b[0]]) / length * (1.0 if area > 0 else -1.0)
        corners = a + np.linspace(0.0, 1.0, math.ceil(length / PIECE_M) + 1)[:, None] * (b - a)
        for p, q in itertools.pairwise(corners):
            yield (q, p, out) if area > 0 else (p, q, out)


def trapezoids(polygons: Sequence[Polygon]) -> F64:
    """(N, 4, 2) m, counter-clockwise, level at bottom and top: what lies in an odd number of the
    polygons, none of which crosses another or itself."""
    edges = [
        (a, b)
        for polygon in polygons
        for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True)
        if a[1] != b[1]
    ]
    found = []
    for low, high in itertools.pairwise(sorted({y for p in polygons for _, y in p})):
        middle = (low + high) / 2
        across = sorted(
            tuple(_x_at(a, b, y) for y in (middle, low, high))
            for a, b in edges
            if (a[1] > middle) != (b[1] > middle)
        )
        for (_, a, d), (_, b, c) in zip(across[::2], across[1::2], strict=True):
            found.append([(a, low), (b, low), (c, high), (d, high)])
    return np.array(found, np.float64).reshape(-1, 4, 2)


def _x_at(a: Point, b: Point, y: float) -> float:
    return a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
