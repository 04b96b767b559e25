"""Which way a piece of furniture faces.

An object's rotation gives Unity's forward, (sin θ, cos θ) on the plan. Over the 75 apartments, of
the pieces that stand with forward or its opposite against a wall, nearly all have the wall behind
forward: it is the front. The assets of `TURNS` have theirs elsewhere, in quarter turns
counter-clockwise. The rule:

1. Start from forward, turned by the asset's `TURNS`.
2. Furniture whose back belongs to a wall: of the two ways along its depth, take the one with a wall
   close behind and none close before it; without such evidence keep step 1.
3. Armchairs and chairs without an asset's name stand in the metadata with the turn of a part of
   them: of all four ways, the one toward the nearest table or desk, else the one with a wall close
   behind, else step 1.
4. What has no front keeps its rotation.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from hil_sim.scenes.format import Wall
from hil_sim.scenes.robothor.footprints import Footprint
from hil_sim.scenes.robothor.metadata import Thing

TURNS = {
    "Bed_13": 2,
    "Bed_2": 2,
    "Bed_26_1": 2,
    "Bed_26_2": 2,
    "Bed_3": 2,
    "Shelving_Unit_001_Master": 2,
}
BACKED = (
    "ArmChair", "Bed", "Desk", "Dresser", "Painting", "ShelvingUnit", "SideTable", "Sofa",
    "Television", "TVStand",
)  # fmt: skip
TABLES = ("DiningTable", "Desk", "CoffeeTable")
CLOSE_M = 0.35
"""A wall this near a side is the one it stands against."""
SEAT_M = 1.1
"""How far a chair's middle may be from that of the table it belongs to."""
THROUGH_M = 0.3
"""Walls are looked for from inside the box: it may overlap one by this."""


def faced(
    thing: Thing, box: Footprint, walls: Sequence[Wall], tables: Iterable[Footprint]
) -> Footprint:
    """The box with the yaw of its front (local -y); a quarter turn swaps width and depth.

    `tables`: boxes of the tables and desks in the apartment.
    """
    usual = TURNS.get(thing.asset, 0)
    if thing.type in ("ArmChair", "Chair") and not thing.asset:
        return _turned(box, _seat(box, walls, tables))
    if thing.type in BACKED:
        ways = [usual, (usual + 2) % 4]
        return _turned(box, max(ways, key=lambda way: (_backing(box, way, walls), way == usual)))
    return _turned(box, usual)


def _turned(box: Footprint, quarters: int) -> Footprint:
    yaw = math.remainder(box.yaw_rad + quarters * math.pi / 2, 2 * math.pi)
    if quarters % 2:
        return replace(box, yaw_rad=yaw, width=box.depth, depth=box.width)
    return replace(box, yaw_rad=yaw)


def _front(box: Footprint, way: int) -> float:
    """Direction on the plan of the front after `way` quarter turns."""
    return box.yaw_rad - math.pi / 2 + way * math.pi / 2


def _backing(box: Footprint, way: int, walls: Sequence[Wall]) -> int:
    """1 with a wall close behind and none close before, -1 the other way round, else 0."""
    front = _front(box, way)
    behind = _gap(box, front + math.pi, walls) < CLOSE_M
    before = _gap(box, front, walls) < CLOSE_M
    return int(behind) - int(before)


def _seat(box: Footprint, walls: Sequence[Wall], tables: Iterable[Footprint]) -> int:
    near = min(tables, key=lambda table: math.dist((table.x, table.y), (box.x, box.y)), default=box)
    away = math.dist((near.x, near.y), (box.x, box.y))
    if 0 < away < SEAT_M:
        toward = math.atan2(near.y - box.y, near.x - box.x)
        return max(range(4), key=lambda way: (math.cos(_front(box, way) - toward), -way))
    return max(range(4), key=lambda way: (_backing(box, way, walls), -way))


def _gap(box: Footprint, direction: float, walls: Sequence[Wall]) -> float:
    """Metres from the box's side to the nearest wall straight ahead of its middle; inf if none."""
    dx, dy = math.cos(direction), math.sin(direction)
    reach = box.half_along(direction)
    best = math.inf
    for wall in walls:
        (x0, y0), (x1, y1) = wall.start, wall.end
        ex, ey = x1 - x0, y1 - y0
        cross = dx * ey - dy * ex
        if abs(cross) < 1e-6:
            continue
        ahead = ((x0 - box.x) * ey - (y0 - box.y) * ex) / cross
        along = ((x0 - box.x) * dy - (y0 - box.y) * dx) / cross
        if ahead > 0 and -0.02 <= along <= 1.02:
            best = min(best, ahead - reach)
    return best if best > -THROUGH_M else math.inf
