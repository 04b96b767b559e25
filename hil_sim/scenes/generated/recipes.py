"""How rooms are arranged: what belongs together is placed together, the rest is completed.

How many of what comes from the placement statistics (`placement.py`).
"""

import math
from collections.abc import Callable, Collection

from hil_sim.scenes.format import SceneObject
from hil_sim.scenes.furniture.boxes import box_of
from hil_sim.scenes.generated.complete import Wanted, complete, load, rug
from hil_sim.scenes.generated.furnisher import SIDES, YAW, Furnisher
from hil_sim.scenes.generated.placing import against_wall, beside, on_top
from hil_sim.scenes.generated.recipes_wet import furnish_bathroom, furnish_kitchen
from hil_sim.scenes.generated.seating import arrange_desk, arrange_table, nightstands
from hil_sim.scenes.generated.wares import find

ESSENTIAL = {
    "bathroom": ("toilet", "sink"),
    "bedroom": ("bed",),
    "dining room": ("table", "chair"),
    "kitchen": ("refrigerator", "sink", "stove"),
    "living room": ("sofa", "television"),
    "study": ("desk", "chair"),
}
TV_FAR_M = (2.0, 3.3)
"""From a television to the front of the sofa."""
OPPOSITE = {"south": "north", "north": "south", "east": "west", "west": "east"}
DINING_M2 = 17.0
"""A smaller living room has no dining table."""


def furnish(home: Furnisher, kind: str) -> None:
    """Furnish the room that was entered as one of this type."""
    wanted = Wanted.draw(home.rng, kind)
    RECIPES[kind](home, wanted)
    complete(home, wanted, kind)


def lacks(kind: str, present: Collection[str]) -> str:
    """A category without which a room is not of that type, and that is not present; else ""."""
    return next((name for name in ESSENTIAL.get(kind, ()) if name not in present), "")


def _bedroom(home: Furnisher, wanted: Wanted) -> None:
    rng = home.rng
    stands = wanted.take("nightstand")
    for i in range(wanted.take("bed")):
        longest = max(home.room.width, 2.3) if i == 0 else 2.2
        mesh = home.pick("bed", longest=longest)
        if mesh is None:
            return
        single = mesh.size_m[0] < 1.2
        bed = against_wall(
            home, mesh, corner=single and rng.random() < 0.5, middle=1.0 if single else 0.7
        )
        if bed:
            nightstands(home, bed, stands if i == 0 else 1)
            rug(home, 0.3, bed)
    for _ in range(wanted.take("desk")):
        if arrange_desk(home):
            wanted.placed("chair")


def _living(home: Furnisher, wanted: Wanted) -> None:
    rng = home.rng
    wanted.take("television")
    television, side = _television(home, wanted)
    tables, stands = wanted.take("coffee table"), wanted.take("nightstand")
    armchairs = wanted.take("armchair")
    for i in range(wanted.take("sofa")):
        sofa = _sofa(home, television, side)
        if sofa is None:
            continue
        table = _coffee_table(home, sofa) if tables > i else None
        if i == 0:
            rug(home, 0.5, table or sofa)
            armchairs -= _armchairs(home, sofa, armchairs)
        nightstands(home, sofa, min(stands, rng.choice((1, 2))))
        if television is not None and i == 0:
            home.keep_clear(television.position_m[:2], sofa.position_m[:2], 0.9)
    for _ in range(max(0, armchairs)):
        against_wall(home, home.pick("armchair"), jitter=0.3)
    if home.room.area > DINING_M2 and wanted.take("table"):
        _table_with_chairs(home, wanted)
    wanted.take("table")
    wanted.left["chair"] = min(1, wanted.take("chair"))  # those of a table that is not there


def _dining(home: Furnisher, wanted: Wanted) -> None:
    wanted.left["chair"] = home.rng.randint(3, 6)
    _table_with_chairs(home, wanted)
    wanted.take("chair")
    rug(home, 0.2, next(iter(home.named("table")), None))


def _study(home: Furnisher, wanted: Wanted) -> None:
    for _ in range(max(1, wanted.take("desk"))):
        if arrange_desk(home):
            wanted.placed("chair")
    rug(home, 0.25)


def _hallway(home: Furnisher, wanted: Wanted) -> None:
    """Only what is completed: little stands in a hallway."""


RECIPES: dict[str, Callable[[Furnisher, Wanted], None]] = {
    "kitchen": furnish_kitchen,
    "bathroom": furnish_bathroom,
    "bedroom": _bedroom,
    "living room": _living,
    "dining room": _dining,
    "study": _study,
    "hallway": _hallway,
}


def _table_with_chairs(home: Furnisher, wanted: Wanted) -> None:
    chairs = wanted.take("chair")
    longest = 1.3 if home.room.area < 12 else 9.0
    table = arrange_table(home, max(chairs, 2), longest)
    if table is not None:
        load(home, table, "kitchen", 1)


def _television(home: Furnisher, wanted: Wanted) -> tuple[SceneObject | None, str]:
    """A television on its stand, a dresser or the wall, and the wall it is at."""
    rng = home.rng
    room = {side: home.wall_length(OPPOSITE_AXIS[side]) for side in SIDES}
    sides = sorted(SIDES, key=lambda side: -min(room[side], 4.5) * rng.uniform(0.7, 1.0))
    habit = wanted.habits["television"]
    on = ("tv stand", "wall", "dresser")
    name = rng.choices(on, [habit.share_on(support) for support in on])[0]
    for side in sides:
        if name == "wall" and (mesh := find(home, "television", on="wall")):
            z = rng.uniform(0.95, 1.1)
            shown = against_wall(home, mesh, z, sides=(side,), middle=0.5)
        else:
            name = "dresser" if name == "dresser" else "tv stand"
            stand = against_wall(
                home, find(home, name), front_m=0.7, sides=(side,), middle=0.5, name=name
            )
            wanted.placed(name, 1 if stand else 0)
            mesh = find(home, "television", on=name)
            shown = on_top(home, mesh, stand, facing=0.04) if stand else None
        if shown:
            return shown, side
    return None, sides[0]


OPPOSITE_AXIS = {"south": "east", "north": "east", "east": "south", "west": "south"}
"""The wall along which one walks away from that wall."""


def _sofa(home: Furnisher, television: SceneObject | None, side: str) -> SceneObject | None:
    """Opposite the television, against the other wall or standing free; else at any wall."""
    rng, across = home.rng, home.wall_length(OPPOSITE_AXIS[side])
    mesh = home.pick("sofa", longest=home.wall_length(side) * 0.7)
    if mesh is None:
        return None
    if television is not None and not home.named("sofa"):
        depth = mesh.size_m[1]
        far = min(rng.uniform(*TV_FAR_M), across - depth - 0.5)
        if across - depth - 0.5 < TV_FAR_M[1] + 0.3:
            far = across - depth - 0.45
        slack = (home.wall_length(side) - mesh.size_m[0]) / 2 - 0.01
        along = _along(home, television, side)
        for _ in range(6):
            at = min(slack, max(-slack, along + rng.gauss(0, 0.2)))
            wall = across - far - depth < 0.6
            out = depth / 2 + 0.03 if wall else across - 0.45 - far - depth / 2
            x, y = home.wall_point(OPPOSITE[side], at, out)
            spot = home.spot(mesh, x, y, YAW[OPPOSITE[side]], front_m=0.3)
            if spot:
                return home.take(mesh, spot)
            far -= 0.15
    return against_wall(
        home, mesh, front_m=0.3, sides=tuple(s for s in SIDES if s != side), middle=0.8
    )


def _along(home: Furnisher, obj: SceneObject, side: str) -> float:
    """Where along its wall something stands, from the wall's middle."""
    box, room = box_of(obj), home.room
    if side in ("south", "north"):
        return box.x - (room.x0 + room.x1) / 2
    return box.y - (room.y0 + room.y1) / 2


def _coffee_table(home: Furnisher, sofa: SceneObject) -> SceneObject | None:
    mesh = home.pick("coffee table")
    if mesh is None or sofa.size_m is None:
        return None
    for _ in range(4):
        v = -(sofa.size_m[1] + mesh.size_m[1]) / 2 - home.rng.uniform(0.34, 0.55)
        if table := beside(home, mesh, sofa, home.rng.uniform(-0.15, 0.15), v):
            return table
    return None


def _armchairs(home: Furnisher, sofa: SceneObject, most: int) -> int:
    """Armchairs at the ends of the space before the sofa, turned to its middle."""
    assert sofa.size_m is not None
    placed, ends = 0, [-1, 1]
    home.rng.shuffle(ends)
    for end in ends:
        mesh = home.pick("armchair")
        if placed >= most or mesh is None:
            break
        for _ in range(3):
            u = end * (sofa.size_m[0] / 2 + mesh.size_m[1] / 2 + home.rng.uniform(0.0, 0.35))
            v = -(sofa.size_m[1] / 2 + mesh.size_m[0] / 2) - home.rng.uniform(0.15, 0.7)
            turn = -end * (math.pi / 2 - home.rng.uniform(0.0, 0.5))
            if beside(home, mesh, sofa, u, v, turn):
                placed += 1
                break
    return placed
