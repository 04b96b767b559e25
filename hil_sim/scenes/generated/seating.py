"""Furniture that comes with its company: chairs at tables, a chair at a desk, nightstands."""

import math

from hil_sim.scenes.format import SceneObject
from hil_sim.scenes.furniture.boxes import CatalogMesh
from hil_sim.scenes.generated.complete import load
from hil_sim.scenes.generated.furnisher import Furnisher
from hil_sim.scenes.generated.placing import against_wall, beside, in_the_open
from hil_sim.scenes.generated.wares import find

HIGH_TABLE_M = 0.88


def arrange_table(home: Furnisher, chairs: int, longest: float = 9.0) -> SceneObject | None:
    """A table in the open, or at a wall, with chairs around it."""
    for _ in range(3):
        mesh = home.pick("table", longest=longest)
        table = in_the_open(home, mesh, 0.6, square=True) or against_wall(home, mesh, front_m=0.6)
        if table and table.size_m:
            high = table.size_m[2] > HIGH_TABLE_M
            seat = home.pick("stool") if high else find(home, "dining chair")
            if seat:
                seats(home, table, seat, chairs)
            return table
        longest = min(longest, 1.5) - 0.2
    return None


def seats(home: Furnisher, table: SceneObject, mesh: CatalogMesh, most: int) -> int:
    """Chairs around a table, facing it, pulled out by a random amount. Returns how many."""
    assert table.size_m is not None
    w, d, _ = table.size_m
    slots = [(u * w, s * d / 2, 0.0 if s > 0 else math.pi)
             for s in (-1, 1) for u in ((-0.25, 0.25) if w > 1.15 else (0.0,))]  # fmt: skip
    slots += [(s * w / 2, 0.0, -s * math.pi / 2) for s in (-1, 1)]
    home.rng.shuffle(slots)
    placed = 0
    for u, v, turn in slots:
        if placed == most:
            break
        twist = home.rng.gauss(0, 0.1)
        out = mesh.size_m[1] / 2 + abs(twist) * mesh.size_m[0] / 2 + home.rng.uniform(0.02, 0.18)
        sideways = abs(turn) == math.pi / 2
        du, dv = (math.copysign(out, u), 0.0) if sideways else (0.0, math.copysign(out, v))
        if beside(home, mesh, table, u + du, v + dv, turn + twist):
            placed += 1
    return placed


def arrange_desk(home: Furnisher) -> SceneObject | None:
    """A desk at a wall with a chair that faces it."""
    rng = home.rng
    desk = None
    for longest in (max(1.4, home.room.width * 0.6), 1.3):
        desk = desk or against_wall(home, home.pick("desk", longest=longest), front_m=0.55)
    if desk is None or desk.size_m is None:
        return None
    home.release(desk)
    chair = find(home, "office chair" if rng.random() < 0.6 else "dining chair")
    for _ in range(6 if chair else 0):
        assert chair is not None
        u = rng.uniform(-0.3, 0.3) * desk.size_m[0]
        v = -(desk.size_m[1] + chair.size_m[1]) / 2 - rng.uniform(0.02, 0.2)
        # A chair in use faces the desk, whose own front faces the room.
        if beside(home, chair, desk, u, v, math.pi + rng.gauss(0, 0.2)):
            break
    load(home, desk, "desk", 1)
    return desk


def nightstands(home: Furnisher, anchor: SceneObject, most: int) -> int:
    """Small tables at the sides of a bed or sofa, backs aligned. Returns how many."""
    mesh = home.pick("nightstand")
    if mesh is None or anchor.size_m is None:
        return 0
    (w, d, _), (mw, md, _) = anchor.size_m, mesh.size_m
    sides, placed = [-1, 1], 0
    home.rng.shuffle(sides)
    for s in sides[:most]:
        u = s * ((w + mw) / 2 + home.rng.uniform(0.02, 0.12))
        placed += beside(home, mesh, anchor, u, (d - md) / 2) is not None
    return placed
