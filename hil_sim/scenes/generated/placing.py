"""Ways to place a thing in a room: against a wall, in the open, on top of or beside another."""

import math
from collections.abc import Mapping

from hil_sim.scenes.format import SceneObject
from hil_sim.scenes.furniture.boxes import Box, CatalogMesh, box_of, gap, offset
from hil_sim.scenes.furniture.surfaces import lies_on, resting_place
from hil_sim.scenes.generated.furnisher import SIDES, YAW, Furnisher, Spot

NEAR_M = 1.0
CHOICES = 3
"""Free places that are compared by what is near them."""

Near = Mapping[str, float]


def against_wall(
    home: Furnisher, mesh: CatalogMesh | None, z: float | None = None, front_m: float = 0.0,
    sides: tuple[str, ...] = SIDES, corner: bool = False, jitter: float = 0.0,
    near: Near | None = None, name: str = "", middle: float = 1.0,
) -> SceneObject | None:  # fmt: skip
    """Back to a wall, facing the room. `near` weighs places by what is within 1 m of them;
    `middle` < 1 keeps it from the wall's ends."""
    if mesh is None:
        return None
    spots: list[Spot] = []
    for _ in range(14):
        side = home.rng.choice(sides)
        slack = (home.wall_length(side) - mesh.size_m[0]) / 2
        if slack < 0:
            continue
        along = home.rng.uniform(-slack, slack) * middle
        if corner:
            along = home.rng.choice([-1, 1]) * (slack - 0.01)
        out = home.rng.uniform(0.005, 0.05) if z is None else 0.004
        out += abs(math.sin(jitter)) * mesh.size_m[0] / 2
        yaw = YAW[side] + home.rng.uniform(-jitter, jitter)
        x, y = home.wall_point(side, along, mesh.size_m[1] / 2 + out)
        if found := home.spot(mesh, x, y, yaw, z, front_m):
            spots.append(found)
        if len(spots) == (CHOICES if near else 1):
            break
    return home.take(mesh, _liked(home, spots, near), name)


def in_the_open(
    home: Furnisher, mesh: CatalogMesh | None, margin: float = 0.0, square: bool = False,
    near: Near | None = None, name: str = "",
) -> SceneObject | None:  # fmt: skip
    """Anywhere in the room, at least `margin` from its walls."""
    if mesh is None:
        return None
    room = home.room.inset(margin + min(mesh.size_m[:2]) / 2)
    if room.width <= 0 or room.depth <= 0:
        return None
    spots: list[Spot] = []
    for _ in range(12):
        x, y = home.rng.uniform(room.x0, room.x1), home.rng.uniform(room.y0, room.y1)
        if square:
            yaw = home.rng.randrange(4) * math.pi / 2 + home.rng.gauss(0, 0.03)
        else:
            yaw = home.inward(x, y) + home.rng.uniform(-0.8, 0.8)
        if found := home.spot(mesh, x, y, yaw):
            spots.append(found)
        if len(spots) == (CHOICES if near else 1):
            break
    return home.take(mesh, _liked(home, spots, near), name)


def on_top(
    home: Furnisher, mesh: CatalogMesh | None, support: SceneObject | None,
    facing: float | None = None, name: str = "", at_back: bool = False,
) -> SceneObject | None:  # fmt: skip
    """On a table's top or a bed's or sofa's seat, `at_back` of it or anywhere; `facing`: the
    same way as the support, give or take that many rad; None: any way."""
    place = resting_place(support) if support else None
    if mesh is None or support is None or place is None:
        return None
    (mw, md, _), under = mesh.size_m, home.box.get(support.id)
    slack_u, slack_v = (place.width - mw) / 2 - 0.01, (place.depth - md) / 2 - 0.01
    if slack_u < 0 or slack_v < 0:
        return None
    for _ in range(8):
        twist = home.rng.uniform(-math.pi, math.pi)
        turn = twist if facing is None else home.rng.gauss(0, facing)
        u, v = home.rng.uniform(-slack_u, slack_u), home.rng.uniform(-slack_v, slack_v)
        x, y = place.at(u, slack_v if at_back else v)
        found = home.spot(mesh, x, y, place.yaw + turn, place.z1, under=under)
        if found and lies_on(found.box, place):
            return home.take(mesh, found, name)
    return None


def beside(
    home: Furnisher, mesh: CatalogMesh | None, anchor: SceneObject, u: float, v: float,
    turn: float = 0.0, z: float | None = None, name: str = "", front_m: float = 0.0,
) -> SceneObject | None:  # fmt: skip
    """At (u, v) in the anchor's own axes, turned by `turn` from it."""
    if mesh is None:
        return None
    x, y = offset(anchor, u, v)
    return home.take(mesh, home.spot(mesh, x, y, anchor.yaw_rad + turn, z, front_m), name)


def _liked(home: Furnisher, spots: list[Spot], near: Near | None) -> Spot | None:
    """One of the spots, rather where there is near what is usually near."""
    if not spots or near is None:
        return spots[0] if spots else None
    around = [(home.names[obj.id], box_of(obj)) for obj in home.here]
    weights = [0.05 + sum(near.get(n, 0.0) for n in _within(around, s.box)) for s in spots]
    return home.rng.choices(spots, weights)[0]


def _within(around: list[tuple[str, Box]], box: Box) -> list[str]:
    """The names of what is within 1 m, each once; sorted, so that sums repeat to the last bit."""
    return sorted({name for name, other in around if gap(other, box) <= NEAR_M})
