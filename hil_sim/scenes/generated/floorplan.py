"""Floor plans of generated homes: rooms as rectangles, walls between them, doors in the walls."""

import random
from collections.abc import Sequence
from dataclasses import dataclass

from hil_sim.scenes.format import Door, Point, Wall

OUTER_M, INNER_M = 0.2, 0.12


@dataclass(frozen=True)
class Rect:
    """An axis-aligned rectangle in the scene frame, metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width(self) -> float:
        return self.x1 - self.x0

    @property
    def depth(self) -> float:
        return self.y1 - self.y0

    @property
    def area(self) -> float:
        return self.width * self.depth

    def touches(self, x: float, y: float, slack: float = 0.02) -> bool:
        """Whether the point lies in the rectangle or on its edge."""
        return self.x0 - slack <= x <= self.x1 + slack and self.y0 - slack <= y <= self.y1 + slack

    def inset(self, by: float) -> "Rect":
        return Rect(self.x0 + by, self.y0 + by, self.x1 - by, self.y1 - by)

    def edges(self) -> tuple[tuple[str, float, float, float], ...]:
        """(axis the edge lies at, where, from, to) of the four sides."""
        across = ((v, self.y0, self.y1) for v in (self.x0, self.x1))
        along = ((v, self.x0, self.x1) for v in (self.y0, self.y1))
        return (*(("x", *side) for side in across), *(("y", *side) for side in along))


@dataclass(frozen=True)
class PlanRoom:
    """A room up to its walls' centre lines: one rectangle, or two that meet in an L."""

    kind: str
    rects: tuple[Rect, ...]

    @property
    def area(self) -> float:
        return sum(rect.area for rect in self.rects)

    def touches(self, x: float, y: float) -> bool:
        return any(rect.touches(x, y) for rect in self.rects)


@dataclass(frozen=True)
class FloorPlan:
    rooms: tuple[PlanRoom, ...]
    walls: tuple[Wall, ...]
    doors: tuple[Door, ...]

    @property
    def bounds(self) -> Rect:
        return bounds([rect for room in self.rooms for rect in room.rects])


def bounds(rects: Sequence[Rect]) -> Rect:
    """The smallest rectangle around all."""
    return Rect(
        min(r.x0 for r in rects),
        min(r.y0 for r in rects),
        max(r.x1 for r in rects),
        max(r.y1 for r in rects),
    )


def turned(rng: random.Random, rooms: Sequence[PlanRoom]) -> tuple[PlanRoom, ...]:
    """The rooms mirrored and turned at random, with a corner of the home at the origin, to 1 cm."""
    swap, flip_x, flip_y = (rng.random() < 0.5 for _ in range(3))
    home = bounds([rect for room in rooms for rect in room.rects])

    def moved(r: Rect) -> Rect:
        xs, ys = (r.x0 - home.x0, r.x1 - home.x0), (r.y0 - home.y0, r.y1 - home.y0)
        xs = (home.width - xs[1], home.width - xs[0]) if flip_x else xs
        ys = (home.depth - ys[1], home.depth - ys[0]) if flip_y else ys
        xs, ys = (ys, xs) if swap else (xs, ys)
        return Rect(round(xs[0], 2), round(ys[0], 2), round(xs[1], 2), round(ys[1], 2))

    return tuple(PlanRoom(room.kind, tuple(moved(r) for r in room.rects)) for room in rooms)


def walls_around(rooms: Sequence[PlanRoom]) -> tuple[Wall, ...]:
    """Outer walls around the home and an inner one between any two rooms."""
    home = bounds([rect for room in rooms for rect in room.rects])
    lines: dict[tuple[str, float], list[tuple[float, float]]] = {}
    open_: dict[tuple[str, float], list[tuple[float, float]]] = {}
    for room in rooms:
        for i, rect in enumerate(room.rects):
            for axis, at, low, high in rect.edges():
                lines.setdefault((axis, at), []).append((low, high))
            for other in room.rects[:i]:
                if (line := shared(rect, other, 0.0)) is not None:
                    axis, at, low, high = line
                    open_.setdefault((axis, at), []).append((low, high))
    walls = []
    for (axis, at), spans in sorted(lines.items()):
        outer = at in ((home.x0, home.x1) if axis == "x" else (home.y0, home.y1))
        for low, high in _without(_union(spans), open_.get((axis, at), [])):
            ends = ((at, low), (at, high)) if axis == "x" else ((low, at), (high, at))
            walls.append(Wall(*ends, OUTER_M if outer else INNER_M, "outer" if outer else "inner"))
    return tuple(walls)


def shared(a: Rect, b: Rect, least: float) -> tuple[str, float, float, float] | None:
    """The stretch along which two rectangles meet, (axis, where, from, to), if long enough."""
    for axis, at, low, high in a.edges():
        for axis_b, at_b, low_b, high_b in b.edges():
            start, end = max(low, low_b), min(high, high_b)
            if axis == axis_b and at == at_b and end - start > least:
                return axis, at, start, end
    return None


def on_line(axis: str, at: float, along: float) -> Point:
    """The point `along` a line that lies at `at` on that axis."""
    return (at, along) if axis == "x" else (along, at)


def polygon_of(room: PlanRoom) -> tuple[Point, ...]:
    """The room's outline, counter-clockwise."""
    if len(room.rects) == 1:
        r = room.rects[0]
        return (r.x0, r.y0), (r.x1, r.y0), (r.x1, r.y1), (r.x0, r.y1)
    return _outline(room.rects)


def _outline(rects: tuple[Rect, ...]) -> tuple[Point, ...]:
    """The outline of rectangles that meet, walked along the cells of the grid they span."""
    xs = sorted({v for r in rects for v in (r.x0, r.x1)})
    ys = sorted({v for r in rects for v in (r.y0, r.y1)})

    def filled(i: int, j: int) -> bool:
        if not (0 <= i < len(xs) - 1 and 0 <= j < len(ys) - 1):
            return False
        x, y = (xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2
        return any(r.touches(x, y, 0.0) for r in rects)

    follows: dict[Point, Point] = {}
    for i in range(len(xs) - 1):
        for j in range(len(ys) - 1):
            if not filled(i, j):
                continue
            a, b = (xs[i], ys[j]), (xs[i + 1], ys[j])
            c, d = (xs[i + 1], ys[j + 1]), (xs[i], ys[j + 1])
            sides = ((a, b, i, j - 1), (b, c, i + 1, j), (c, d, i, j + 1), (d, a, i - 1, j))
            follows.update({p: q for p, q, u, v in sides if not filled(u, v)})
    start = min(follows)
    ring = [start]
    while (point := follows[ring[-1]]) != start:
        ring.append(point)
    return tuple(_without_straights(ring))


def _without_straights(ring: list[Point]) -> list[Point]:
    """The ring without points in the middle of a straight side."""
    kept = []
    for i, (x, y) in enumerate(ring):
        (px, py), (nx, ny) = ring[i - 1], ring[(i + 1) % len(ring)]
        if not (px == x == nx or py == y == ny):
            kept.append((x, y))
    return kept


def _union(spans: list[tuple[float, float]]) -> list[tuple[float, float]]:
    merged: list[tuple[float, float]] = []
    for low, high in sorted(spans):
        if merged and low <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
        else:
            merged.append((low, high))
    return merged


def _without(
    spans: list[tuple[float, float]], holes: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    for low, high in holes:
        cut = [(s, min(e, low)) for s, e in spans] + [(max(s, high), e) for s, e in spans]
        spans = sorted((s, e) for s, e in cut if e - s > 1e-6)
    return spans
