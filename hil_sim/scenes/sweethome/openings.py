"""Doors: which of the drawn doors and windows the robot can drive through, and where."""

import math
from dataclasses import dataclass

from hil_sim.scenes.format import Door, Point, Polygon, Wall
from hil_sim.scenes.sweethome.drawing import Drawn, Opening
from hil_sim.scenes.sweethome.plan import PARALLEL, beside, room_index
from hil_sim.scenes.sweethome.words import is_window

SILL_M = 0.05
"""An opening from higher up than this is a window."""
LEAST_HEIGHT_M = 1.0
LEAST_WIDTH_M = 0.3
BESIDE_M = (0.1, 0.25, 0.4)
"""Where rooms are looked for beyond a door, from the wall's faces."""


@dataclass(frozen=True)
class Doorway:
    """What became of a door: the holes it cuts, or why it stays shut: "window", "outside" (it leads
    out of the rooms) or "no wall"."""

    doors: tuple[Door, ...]
    shut: str = ""


def doorway(piece: Drawn, walls: list[Wall], rooms: list[Polygon], wall_height_m: float) -> Doorway:
    """The doors that a drawn door or window cuts into the walls that it stands in."""
    hole = piece.opening or Opening()
    base, height = piece.position_m[2], piece.size_m[2]
    top = base + height * (1 - hole.top)
    sill = base + height * (1 - hole.top - hole.height)
    named = is_window(piece.catalog_id, piece.name)
    narrow = hole.width * piece.size_m[0] < LEAST_WIDTH_M
    if sill > SILL_M or top < LEAST_HEIGHT_M or named or narrow:
        return Doorway((), "window")
    cuts = [(d, wall) for wall in walls if (d := _cut(piece, hole, wall, min(top, wall_height_m)))]
    if not cuts:
        return Doorway((), "no wall")
    if not all(_within(door, wall, side, rooms) for door, wall in cuts for side in (1, -1)):
        return Doorway((), "outside")
    return Doorway(tuple(door for door, _ in cuts))


def _within(door: Door, wall: Wall, side: int, rooms: list[Polygon]) -> bool:
    """Whether there is a room on that side of the door."""
    hole = Wall(door.start, door.end, wall.thickness_m)
    return any(room_index(rooms, beside(hole, 0.5, side * d)) is not None for d in BESIDE_M)


def _local(piece: Drawn, x: float, y: float) -> Point:
    c, s = math.cos(piece.yaw_rad), math.sin(piece.yaw_rad)
    return piece.position_m[0] + x * c - y * s, piece.position_m[1] + x * s + y * c


def _cut(piece: Drawn, hole: Opening, wall: Wall, height_m: float) -> Door | None:
    """The hole in one wall, on its centre line; None when the piece does not stand in it."""
    (x0, y0), (x1, y1) = wall.start, wall.end
    length = math.dist(wall.start, wall.end)
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    if abs(ux * math.cos(piece.yaw_rad) + uy * math.sin(piece.yaw_rad)) < PARALLEL:
        return None
    width = piece.size_m[0]
    left, right = -width / 2 + hole.left * width, -width / 2 + (hole.left + hole.width) * width
    if piece.mirrored:
        left, right = -right, -left
    off = (piece.position_m[0] - x0) * -uy + (piece.position_m[1] - y0) * ux
    if abs(off) > wall.thickness_m / 2 + piece.size_m[1] / 2:
        return None
    along = sorted(
        (x - x0) * ux + (y - y0) * uy for x, y in (_local(piece, e, 0.0) for e in (left, right))
    )
    begin, end = max(along[0], 0.0), min(along[1], length)
    if end - begin < 0.02:
        return None
    return Door((x0 + ux * begin, y0 + uy * begin), (x0 + ux * end, y0 + uy * end), height_m)
