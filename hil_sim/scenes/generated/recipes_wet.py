"""Kitchens and bathrooms: what stands side by side along a wall."""

from hil_sim.scenes.format import SceneObject
from hil_sim.scenes.furniture.boxes import CatalogMesh
from hil_sim.scenes.generated.complete import Wanted, load
from hil_sim.scenes.generated.furnisher import SIDES, YAW, Furnisher
from hil_sim.scenes.generated.placing import against_wall, beside
from hil_sim.scenes.generated.seating import arrange_table
from hil_sim.scenes.generated.wares import find

SMALL_KITCHEN_M2 = 9.0
MIRROR_M = 1.2

Modules = list[tuple[str, CatalogMesh]]


def furnish_kitchen(home: Furnisher, wanted: Wanted) -> None:
    counters = wanted.take("counter") + 1
    for name in ("refrigerator", "sink", "stove"):
        wanted.take(name)
    modules, upper = _modules(home, counters), find(home, "upper cabinet")
    sides = sorted(SIDES, key=lambda s: -home.wall_length(s) * home.rng.uniform(0.3, 1.0))
    for side in sides:
        modules = _run(home, side, modules, upper if home.rng.random() < 0.7 else None)
    chairs, tables = wanted.take("chair"), wanted.take("table")
    if tables and home.room.area > SMALL_KITCHEN_M2:
        arrange_table(home, max(2, chairs), longest=1.3 if home.room.area < 14 else 1.7)


def _run(home: Furnisher, side: str, modules: Modules, upper: CatalogMesh | None) -> Modules:
    """What stands side by side along one wall, as far as it goes; returns what is left."""
    rng, end = home.rng, home.wall_length(side) / 2
    at, left = -end + rng.choice([0.01, rng.uniform(0.0, 0.4)]), list(modules)
    while left and at + left[0][1].size_m[0] < end:
        name, mesh = left[0]
        w, d, _ = mesh.size_m
        x, y = home.wall_point(side, at + w / 2, d / 2 + 0.006)
        obj = home.take(mesh, home.spot(mesh, x, y, YAW[side], front_m=0.35), name)
        if obj is None:
            at += 0.15
            continue
        if upper and name in ("counter", "sink") and upper.size_m[0] <= w + 0.06:
            x, y = home.wall_point(side, at + w / 2, upper.size_m[1] / 2 + 0.006)
            home.take(upper, home.spot(upper, x, y, YAW[side]))
        if name == "counter":
            load(home, obj, "kitchen", 1)
        left, at = left[1:], at + w + 0.012
    return left


def _modules(home: Furnisher, counters: int) -> Modules:
    """What stands in the run, in order; counters of one make."""
    rng, counter = home.rng, find(home, "counter")
    names = [("sink", find(home, "kitchen sink")), ("stove", home.pick("stove"))]
    names += [("counter", counter)] * counters
    rng.shuffle(names)
    names.insert(rng.choice([0, len(names)]), ("refrigerator", home.pick("refrigerator")))
    return [(name, mesh) for name, mesh in names if mesh is not None]


def furnish_bathroom(home: Furnisher, wanted: Wanted) -> None:
    rng = home.rng
    tub, shower = wanted.take("bathtub"), wanted.take("shower")
    if tub:
        against_wall(home, home.pick("bathtub"), corner=rng.random() < 0.8)
    for _ in range(wanted.take("toilet")):
        against_wall(home, home.pick("toilet"), front_m=0.4) or against_wall(
            home, home.pick("toilet"), front_m=0.25
        )
    for _ in range(wanted.take("sink")):
        mesh = find(home, "bathroom sink")
        sink = against_wall(home, mesh, front_m=0.35, near={"sink": 1.0})
        if sink and _mirror_over(home, sink):
            wanted.placed("mirror")
    if shower or not tub:
        against_wall(home, home.pick("shower"), corner=True)
    if wanted.take("counter"):
        against_wall(home, find(home, "counter"), near={"sink": 1.0}, name="counter")
    if rng.random() < 0.15:
        against_wall(home, home.pick("other", ("Blend Swap CC-0#bidet",)), near={"toilet": 1.0})


def _mirror_over(home: Furnisher, sink: SceneObject) -> SceneObject | None:
    """A mirror on the wall over a sink that has none of its own."""
    mesh = home.pick("mirror")
    if mesh is None or sink.size_m is None or sink.position_m[2] + sink.size_m[2] > MIRROR_M:
        return None
    return beside(home, mesh, sink, 0.0, (sink.size_m[1] - mesh.size_m[1]) / 2, z=MIRROR_M)
