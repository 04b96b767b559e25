"""Geometry of a drawn plan: walls with their sides, rooms that reach the walls' middles, and rooms
where none was drawn. Scene frame, metres."""

import math
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import Point, Polygon, Wall, contains, polygon_area
from hil_sim.scenes.sweethome.drawing import DrawnWall

ARC_STEP_RAD = math.radians(15)
SNAP_M = 0.25
"""How far from a wall's face a room's edge may lie and still belong to it."""
PARALLEL = math.cos(math.radians(8))
CELL_M = 0.025
GAP_M = 0.1
"""Gaps between walls up to this are taken for drawn closed."""
LEAST_ROOM_M2 = 1.0

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Side:
    """A straight wall with the colours of its sides, left and right from start to end."""

    wall: Wall
    left: str | None = None
    right: str | None = None


def straight(drawn: DrawnWall) -> list[Side]:
    """The straight walls that a drawn wall consists of; a curved one becomes chords of 15°."""
    points = arc(drawn.start, drawn.end, drawn.arc_rad)
    return [
        Side(Wall(a, b, drawn.thickness_m), drawn.left, drawn.right)
        for a, b in pairwise(points)
        if math.dist(a, b) >= 1e-3
    ]


def arc(start: Point, end: Point, turn_rad: float) -> list[Point]:
    """Points from start to end along the arc that Sweet Home 3D draws: one that turns through
    `turn_rad`, positive bulging to the left of the way from start to end, y up."""
    steps = math.ceil(abs(turn_rad) / ARC_STEP_RAD)
    half, chord = turn_rad / 2, math.dist(start, end)
    if steps < 2 or abs(math.sin(half)) < 1e-6 or chord < 1e-9:
        return [start, end]
    ux, uy = (end[0] - start[0]) / chord, (end[1] - start[1]) / chord
    radius = chord / 2 / math.sin(half)  # signed; its centre lies to the right for a left bulge
    cx = (start[0] + end[0]) / 2 + uy * radius * math.cos(half)
    cy = (start[1] + end[1]) / 2 - ux * radius * math.cos(half)
    angle = math.atan2(start[1] - cy, start[0] - cx)
    reach = math.dist(start, (cx, cy))
    inner = [
        (cx + reach * math.cos(angle - turn_rad * k / steps),
         cy + reach * math.sin(angle - turn_rad * k / steps))
        for k in range(1, steps)
    ]  # fmt: skip
    return [start, *inner, end]


def beside(wall: Wall, along: float, across_m: float) -> Point:
    """The point at the share `along` of the wall, `across_m` to its left beyond the face."""
    (x0, y0), (x1, y1) = wall.start, wall.end
    length = math.dist(wall.start, wall.end)
    away = across_m + math.copysign(wall.thickness_m / 2, across_m)
    x, y = x0 + (x1 - x0) * along, y0 + (y1 - y0) * along
    return x - (y1 - y0) / length * away, y + (x1 - x0) / length * away


def room_index(polygons: list[Polygon], at: Point) -> int | None:
    """Which polygon the point lies in."""
    return next((i for i, polygon in enumerate(polygons) if contains(polygon, *at)), None)


def is_inner(wall: Wall, polygons: list[Polygon]) -> bool:
    """Whether both sides of most of the wall are in rooms."""
    shares = [0.1, 0.3, 0.5, 0.7, 0.9]
    both = [
        all(room_index(polygons, beside(wall, t, side)) is not None for side in (0.1, -0.1))
        for t in shares
    ]
    return sum(both) > len(shares) / 2


def to_middles(polygon: Polygon, walls: list[Wall]) -> Polygon:
    """The room with every edge that runs along a wall moved to the wall's centre line, so that
    rooms on both sides of a door meet in it. Returned as it is where that would distort it."""
    points = [p for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True) if p != q]
    if len(points) < 3:
        return polygon
    ends = list(zip(points, points[1:] + points[:1], strict=True))
    lines = [_moved(a, b, walls) for a, b in ends]
    corners: list[Point] = []
    for i, (point, line) in enumerate(zip(points, lines, strict=True)):
        corners += _corner(point, lines[i - 1], line)
    moved = tuple(p for i, p in enumerate(corners) if math.dist(p, corners[i - 1]) > 1e-3)
    before = polygon_area(polygon)
    if len(moved) < 3 or not 0.9 * before <= polygon_area(moved) <= 2.0 * before + 0.5:
        return polygon
    return moved


Line = tuple[Point, Point]
"""A point and a unit direction."""


def _moved(a: Point, b: Point, walls: list[Wall]) -> Line:
    """The line of an edge, on the centre line of the wall that it runs along most."""
    length = math.dist(a, b)
    ux, uy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    best, line = 0.3 * min(length, 1.0), (a, (ux, uy))
    for wall in walls:
        (x0, y0), (x1, y1) = wall.start, wall.end
        whole = math.dist(wall.start, wall.end)
        vx, vy = (x1 - x0) / whole, (y1 - y0) / whole
        turn = ux * vx + uy * vy
        if abs(turn) < PARALLEL:
            continue
        middle = ((a[0] + b[0]) / 2 - x0, (a[1] + b[1]) / 2 - y0)
        if abs(vx * middle[1] - vy * middle[0]) > wall.thickness_m / 2 + SNAP_M:
            continue
        s, t = sorted(((x0 - a[0]) * ux + (y0 - a[1]) * uy, (x1 - a[0]) * ux + (y1 - a[1]) * uy))
        shared = min(t, length) - max(s, 0.0)
        if shared > best + 1e-9:
            sign = math.copysign(1.0, turn)
            best, line = shared, ((x0, y0), (vx * sign, vy * sign))
    return line


def _corner(point: Point, before: Line, after: Line) -> list[Point]:
    """Where two neighbouring edges' lines meet; a step between them where they are parallel."""
    (px, py), (ux, uy) = before
    (qx, qy), (vx, vy) = after
    cross = ux * vy - uy * vx
    if abs(cross) > math.sin(math.radians(8)):
        t = ((qx - px) * vy - (qy - py) * vx) / cross
        met = (px + t * ux, py + t * uy)
        if math.dist(met, point) <= 3 * SNAP_M:
            return [met]
    return [_onto(point, before), _onto(point, after)]


def _onto(point: Point, line: Line) -> Point:
    (px, py), (ux, uy) = line
    t = (point[0] - px) * ux + (point[1] - py) * uy
    return px + t * ux, py + t * uy


def undrawn_rooms(walls: list[Wall], rooms: list[Polygon]) -> list[Polygon]:
    """Outlines of what walls enclose and no room covers, from 1 m² on, to the walls' middles."""
    points = np.array([p for wall in walls for p in (wall.start, wall.end)])
    low, high = points.min(axis=0) - 1.0, points.max(axis=0) + 1.0
    cols, rows = np.ceil((high - low) / CELL_M).astype(int)
    solid, known = np.zeros((rows, cols), np.uint8), np.zeros((rows, cols), np.uint8)

    def px(xy: Array) -> NDArray[np.int32]:
        return np.asarray(np.round((xy - low) / CELL_M), np.int32)

    for wall in walls:
        cv2.fillPoly(solid, [px(footprint(wall, GAP_M / 2))], 1)
    for room in rooms:
        cv2.fillPoly(known, [px(np.array(room))], 1)
    known = np.asarray(cv2.dilate(known, _square(0.15)), np.uint8)
    _, names = cv2.connectedComponents(1 - solid, connectivity=4)
    inside = ((solid == 0) & (names != names[0, 0])).astype(np.uint8)
    bare = cv2.morphologyEx(inside * (1 - known), cv2.MORPH_OPEN, _square(0.4))
    outlines, _ = cv2.findContours(bare, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    found = []
    for outline in sorted(outlines, key=lambda o: o[:, 0].min(axis=0).tolist()):
        shape = cv2.approxPolyDP(outline, 0.05 / CELL_M, True)[:, 0]
        polygon: Polygon = tuple((float(x), float(y)) for x, y in shape * CELL_M + low)
        if len(polygon) >= 3 and polygon_area(polygon) >= LEAST_ROOM_M2:
            found.append(to_middles(polygon, walls))
    return found


def hull(walls: list[Wall]) -> Polygon:
    """The convex hull of the walls' centre lines; () when it has no area."""
    points = np.array([p for wall in walls for p in (wall.start, wall.end)], np.float32)
    shape = cv2.convexHull(points)[:, 0]
    polygon: Polygon = tuple((float(x), float(y)) for x, y in shape)
    return polygon if len(polygon) >= 3 and polygon_area(polygon) > 0.01 else ()


def footprint(wall: Wall, grow_m: float = 0.0) -> Array:
    """(4, 2) corners of the wall on the plan, lengthened by half its thickness at the ends."""
    start, end = np.array(wall.start), np.array(wall.end)
    along = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
    half = wall.thickness_m / 2 + grow_m
    across = np.array([-along[1], along[0]]) * half
    start, end = start - along * half, end + along * half
    return np.array([start - across, end - across, end + across, start + across])


def _square(side_m: float) -> NDArray[np.uint8]:
    cells = max(1, round(side_m / CELL_M)) | 1
    return np.ones((cells, cells), np.uint8)
