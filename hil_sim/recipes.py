"""What stands in a room of each type, and where."""

from collections.abc import Callable

from hil_sim.furnish import YAW, Furnisher, Mesh, furniture, hex_colour
from hil_sim.scene import SceneObject

FLOOR_THINGS = (
    "Blend Swap CC-0#crate", "Blend Swap CC-0#electricGuitar", "Blend Swap CC-0#basketball",
    "Blend Swap CC-BY#backpack", "Blend Swap CC-BY#gift", "Blend Swap CC-BY#suitcase",
    "Blend Swap CC-BY#ballonFoot", "Kator Legaz#bench", "Scopia#cardboard-box",
    "Scopia#water_cooler", "Scopia#indoor-bike", "Scopia#clothes-horse", "Scopia#doll-house",
    "Blend Swap CC-0#ammoBox", "Kator Legaz#trunk-large", "Scopia#puff",
    "Scopia#clothes-basket", "Blend Swap CC-0#speaker3", "Blend Swap CC-0#teddyBear",
)  # fmt: skip
COUNTER_THINGS = (
    "Blend Swap CC-0#kitchenaid", "Blend Swap CC-0#tetrapak", "Blend Swap CC-BY#boiler",
    "Blend Swap CC-BY#breadBox", "Blend Swap CC-BY#coffeePress", "Blend Swap CC-BY#largePan",
    "Blend Swap CC-BY#kitchenblender", "Kator Legaz#bowl", "Kator Legaz#coffee-maker",
    "Kator Legaz#oil-servers", "Kator Legaz#red-wine-bottle-01", "Scopia#apples",
    "Scopia#coffee_machine", "Scopia#teapot", "Scopia#bowlWithFruits", "Scopia#toaster",
    "Scopia#cooker", "Scopia#small-oven", "Scopia#bowl",
)  # fmt: skip
TABLE_THINGS = (
    "Blend Swap CC-0#caffe_final", "Blend Swap CC-BY#book", "Kator Legaz#dinner-plate",
    "Kator Legaz#red-wine-bottle-01", "Scopia#apples", "Scopia#teapot",
    "Scopia#bowlWithFruits", "Kator Legaz#bowl", "Blend Swap CC-BY#gift",
)  # fmt: skip
DESK_THINGS = (
    "Kator Legaz#apple-imac-1998", "Scopia#apple_pc", "Blend Swap CC-BY#book",
    "Scopia#inkjet_and_scanner_printer", "Blend Swap CC-0#caffe_final", "Scopia#mini_stereo",
    "Blend Swap CC-BY#radio", "Blend Swap CC-0#tableFan", "Blend Swap CC-0#teddyBear",
    "Scopia#folded_clothes", "Scopia#aquarium",
)  # fmt: skip
RUGS = ("Kator Legaz#oriental-rug", "Scopia#round-carpet")
TV_STAND = "Blend Swap CC-BY#tvStand"
WALL_TV = "Scopia#wall-flat-tv"
FLOOR_LAMP = "Scopia#living_lamp"
SMALL_PLANTS = tuple(
    mesh.id for mesh in furniture()["plant"] if mesh.size_m[2] < 0.62 and mesh.size_m[0] < 0.5
)
KITCHEN_SINKS = ("Blend Swap CC-0#sinkCabinet", "Blend Swap CC-BY#kitchenSink")
BATH_SINKS = tuple(m.id for m in furniture()["sink"] if m.id not in KITCHEN_SINKS)
LOW_CABINETS = (
    "Blend Swap CC-0#drawersCabinet", "Blend Swap CC-0#lowerCabinet",
    "Blend Swap CC-BY#kitchenDrawersCabinet", "Blend Swap CC-BY#kitchenLowerCabinet",
    "Blend Swap CC-BY#kitchenSmallLowerCabinet",
)  # fmt: skip
HIGH_CABINETS = tuple(m.id for m in furniture()["cabinet"] if m.z_m > 1)
LIVING_CABINETS = ("Scopia#box_room", "Blend Swap CC-0#televisionCabinet", "Scopia#office_box")
OFFICE_CHAIRS = ("Kator Legaz#office-chair", "Scopia#office_chair", "Scopia#kids_desk_chair")
TABLE_LAMPS = tuple(m.id for m in furniture()["lamp"] if m.size_m[2] < 0.85)


def furnish(home: Furnisher, kind: str) -> None:
    """Furnish the room that was entered as one of this type."""
    RECIPES[kind](home)
    _hang(home, kind)
    _scatter(home)


def _kitchen(home: Furnisher) -> None:
    rng = home.rng
    _counter_run(home)
    if not _has(home, "refrigerator"):
        home.against_wall("refrigerator", front_m=0.5, corner=rng.random() < 0.6)
    if not _has(home, "stove"):
        home.against_wall("stove", front_m=0.4)
    if not _has(home, "sink"):
        home.against_wall("sink", home.pick("sink", KITCHEN_SINKS), front_m=0.4)
    if rng.random() < 0.35:
        home.against_wall("washing machine", front_m=0.4)
    if rng.random() < 0.65:
        _dining_table(home, 4, longest=1.5)
    for _ in range(rng.randint(0, 3)):
        home.free_standing("stool")
    _some(home, {"trash can": 0.7, "cabinet": 0.25, "radiator": 0.25, "chair": 0.2})
    if rng.random() < 0.45:
        home.against_wall("plant")


def _counter_run(home: Furnisher) -> None:
    """Cabinets, sink, stove and refrigerator side by side along one wall."""
    rng = home.rng
    side = max(("south", "east", "north", "west"), key=lambda s: home.wall_length(s) * rng.random())
    cabinet = home.pick("cabinet", LOW_CABINETS)
    modules = [("sink", home.pick("sink", KITCHEN_SINKS)), ("stove", home.pick("stove"))]
    modules += [("cabinet", cabinet)] * rng.randint(1, 4)
    rng.shuffle(modules)
    if rng.random() < 0.8:
        modules.insert(rng.choice([0, len(modules)]), ("refrigerator", home.pick("refrigerator")))
    length = home.wall_length(side)
    at = -length / 2 + rng.choice([0.01, rng.uniform(0.0, 0.5)])
    upper = home.pick("cabinet", HIGH_CABINETS) if rng.random() < 0.7 else None
    for category, mesh in modules:
        w, d, _ = mesh.size_m
        if at + w > length / 2:
            break
        x, y = home.wall_point(side, at + w / 2, d / 2 + 0.006)
        obj = home.put(category, mesh, x, y, YAW[side])
        if obj is None:
            at += 0.2
            continue
        if upper and category in ("cabinet", "sink") and upper.size_m[0] <= w + 0.06:
            x, y = home.wall_point(side, at + w / 2, upper.size_m[1] / 2 + 0.006)
            home.put("cabinet", upper, x, y, YAW[side])
        if category == "cabinet":
            if not _has(home, "microwave") and rng.random() < 0.6:
                home.on_top("microwave", obj, facing=True)
            _load(home, obj, COUNTER_THINGS, 2, {"plant": 0.12, "vase": 0.1})
        at += w + 0.012


def _bathroom(home: Furnisher) -> None:
    rng = home.rng
    tub = rng.random()
    if tub < 0.7:
        home.against_wall("bathtub", corner=rng.random() < 0.8)
    home.against_wall("toilet", front_m=0.4)
    sink = home.against_wall("sink", home.pick("sink", BATH_SINKS), front_m=0.35)
    if tub > 0.5:
        home.against_wall("shower", corner=True)
    if sink and sink.size_m and sink.position_m[2] + sink.size_m[2] < 1.15 and rng.random() < 0.7:
        mirror = home.pick("mirror")
        v = sink.size_m[1] / 2 - mirror.size_m[1] / 2
        home.beside("mirror", sink, 0.0, v, 0.0, mirror, 1.2)
    _some(home, {"washing machine": 0.35, "trash can": 0.45, "radiator": 0.4, "plant": 0.25,
                 "stool": 0.15, "cabinet": 0.15, "mirror": 0.2})  # fmt: skip
    _wall_thing(home, "other", ("Blend Swap CC-0#towel3",), 0.4, 0.6)
    if rng.random() < 0.2:
        home.against_wall("other", home.pick("other", ("Blend Swap CC-0#bidet",)))


def _bedroom(home: Furnisher) -> None:
    rng = home.rng
    bed = home.against_wall("bed", home.pick("bed", longest=max(home.room.width, 2.3)))
    if bed and bed.size_m:
        stand = home.pick("nightstand")
        for s in (-1, 1):
            if rng.random() < 0.7:
                u = s * (bed.size_m[0] + stand.size_m[0] + rng.uniform(0.02, 0.15)) / 2
                v = bed.size_m[1] / 2 - stand.size_m[1] / 2
                placed = home.beside("nightstand", bed, u, v, 0.0, stand)
                _load(home, placed, ("Blend Swap CC-BY#book",), 1,
                      {"lamp": 0.6, "clock": 0.1, "vase": 0.1, "plant": 0.12})  # fmt: skip
    if rng.random() < 0.8:
        home.against_wall("wardrobe", front_m=0.45)
    if rng.random() < 0.6:
        dresser = home.against_wall("dresser", front_m=0.3)
        _load(home, dresser, DESK_THINGS, 1,
              {"television": 0.35, "lamp": 0.3, "vase": 0.3, "plant": 0.25})  # fmt: skip
    if rng.random() < 0.45:
        _desk(home)
    _some(home, {"chair": 0.35, "armchair": 0.35, "plant": 0.4, "bookcase": 0.3, "mirror": 0.3,
                 "radiator": 0.35, "trash can": 0.2, "nightstand": 0.15})  # fmt: skip
    if rng.random() < 0.15:
        _wall_thing(home, "television", (WALL_TV,), 1.0, 1.0)
    _rug(home, 0.4)


def _living(home: Furnisher) -> None:
    rng = home.rng
    if rng.random() < 0.6:
        stand = home.against_wall("other", home.pick("other", (TV_STAND,)), front_m=0.7)
        home.on_top("television", stand, home.pick("television", ("Blend Swap CC-0#led_tv",
                    "Scopia#tv")), facing=True)  # fmt: skip
    else:
        _wall_thing(home, "television", (WALL_TV,), 1.0, 1.0)
    for _ in range(rng.choice([1, 1, 2])):
        longest = max(home.room.width, home.room.depth) * 0.6
        mesh = home.pick("sofa", longest=longest)
        sofa = home.against_wall("sofa", mesh, front_m=0.3) if rng.random() < 0.75 else None
        sofa = sofa or home.free_standing("sofa", mesh, 0.6, square=True)
        if sofa and sofa.size_m and rng.random() < 0.7:
            table = home.pick("coffee table")
            v = -(sofa.size_m[1] + table.size_m[1]) / 2 - rng.uniform(0.3, 0.5)
            home.zones = home.zones[: home.door_zones]
            placed = home.beside("coffee table", sofa, rng.uniform(-0.2, 0.2), v, 0.0, table)
            _load(home, placed, TABLE_THINGS, 2, {"vase": 0.3, "plant": 0.25, "laptop": 0.25})
    for category in ("piano", "fireplace"):
        if rng.random() < 0.3:
            home.against_wall(category)
    for _ in range(rng.randint(0, 2)):
        home.free_standing("armchair", margin=0.1)
    if rng.random() < 0.5:
        home.against_wall("cabinet", home.pick("cabinet", LIVING_CABINETS))
    if rng.random() < 0.35:
        dresser = home.against_wall("dresser")
        _load(home, dresser, DESK_THINGS, 1, {"vase": 0.5, "lamp": 0.4, "plant": 0.3, "clock": 0.2})
    if rng.random() < 0.25:
        _dining_table(home, 4)
    _some(home, {"bookcase": 0.6, "plant": 0.75, "vase": 0.25,
                 "radiator": 0.35, "stool": 0.15, "chair": 0.3, "trash can": 0.1})  # fmt: skip
    if rng.random() < 0.5:
        home.against_wall("lamp", home.pick("lamp", (FLOOR_LAMP,)))
    if rng.random() < 0.4:
        home.against_wall("plant")
    _rug(home, 0.5)


def _dining(home: Furnisher) -> None:
    rng = home.rng
    _dining_table(home, rng.randint(3, 6))
    if rng.random() < 0.5:
        dresser = home.against_wall("dresser")
        _load(home, dresser, TABLE_THINGS, 2, {"vase": 0.6, "lamp": 0.3, "plant": 0.3})
    _some(home, {"cabinet": 0.35, "plant": 0.6, "bookcase": 0.25, "fireplace": 0.3, "piano": 0.3,
                 "radiator": 0.3, "chair": 0.4, "armchair": 0.15, "vase": 0.15})  # fmt: skip
    _rug(home, 0.25)


def _study(home: Furnisher) -> None:
    rng = home.rng
    for _ in range(rng.choice([1, 1, 2])):
        _desk(home)
    if rng.random() < 0.3:
        home.against_wall("sofa", home.pick("sofa", longest=2.1), front_m=0.3)
    _some(home, {"bookcase": 0.85, "cabinet": 0.45, "armchair": 0.4, "plant": 0.5,
                 "trash can": 0.7, "radiator": 0.35, "piano": 0.15, "chair": 0.35,
                 "stool": 0.1, "table": 0.15})  # fmt: skip
    if rng.random() < 0.35:
        home.against_wall("bookcase")
    if rng.random() < 0.3:
        home.against_wall("lamp", home.pick("lamp", (FLOOR_LAMP,)))
    if rng.random() < 0.15:
        _wall_thing(home, "television", (WALL_TV,), 1.0, 1.0)
    _rug(home, 0.25)


def _hallway(home: Furnisher) -> None:
    if home.rng.random() < 0.4:
        dresser = home.against_wall("dresser")
        _load(home, dresser, DESK_THINGS, 1, {"vase": 0.5, "lamp": 0.4, "plant": 0.3})
    _some(home, {"plant": 0.4, "mirror": 0.5, "radiator": 0.4, "wardrobe": 0.15, "chair": 0.25,
                 "cabinet": 0.15, "stool": 0.1, "vase": 0.1, "bookcase": 0.15})  # fmt: skip


RECIPES: dict[str, Callable[[Furnisher], None]] = {
    "kitchen": _kitchen,
    "bathroom": _bathroom,
    "bedroom": _bedroom,
    "living room": _living,
    "dining room": _dining,
    "study": _study,
    "hallway": _hallway,
}


def _dining_table(home: Furnisher, seats: int, longest: float = 9.0) -> None:
    mesh = home.pick("table", longest=longest)
    table = home.free_standing("table", mesh, 0.55, square=True) or home.against_wall("table", mesh)
    if table:
        category = "stool" if table.size_m and table.size_m[2] > 0.88 else "chair"
        home.seats(table, category, seats)
        _load(home, table, TABLE_THINGS, 3, {"vase": 0.35, "plant": 0.2, "laptop": 0.25})


def _desk(home: Furnisher) -> None:
    rng = home.rng
    desk = home.against_wall("desk", home.pick("desk", longest=max(1.4, home.room.width * 0.6)))
    desk = desk or home.against_wall("desk", home.pick("desk", longest=1.3))
    if desk is None or desk.size_m is None:
        return
    home.on_top("laptop", desk, facing=True) if rng.random() < 0.85 else None
    _load(home, desk, DESK_THINGS, 2, {"lamp": 0.55, "plant": 0.2, "vase": 0.1, "clock": 0.1})
    chair = home.pick("chair", OFFICE_CHAIRS if rng.random() < 0.6 else ())
    v = -(desk.size_m[1] + chair.size_m[1]) / 2 - rng.uniform(0.02, 0.3)
    # A chair in use faces the desk, whose own front faces the room.
    home.beside("chair", desk, rng.uniform(-0.2, 0.2), v, 3.1416 + rng.gauss(0, 0.3), chair)


def _some(home: Furnisher, chances: dict[str, float]) -> None:
    for category, chance in chances.items():
        if home.rng.random() >= chance:
            continue
        if category in ("mirror", "clock", "picture"):
            _wall_thing(home, category, (), 1.1, 1.3)
        elif category == "chair" and home.rng.random() < 0.6:
            home.free_standing("chair")
        elif category == "lamp":
            home.against_wall("lamp", home.pick("lamp", (FLOOR_LAMP,)))
        elif category == "cabinet":
            mesh = home.pick("cabinet", tuple(m.id for m in furniture()["cabinet"] if m.z_m < 0.5))
            home.against_wall("cabinet", mesh)
        elif category == "plant":
            big = tuple(m.id for m in furniture()["plant"] if m.size_m[2] > 0.5)
            home.against_wall("plant", home.pick("plant", big), yaw_jitter=0.3)
        elif category == "vase":
            home.against_wall("vase", home.pick("vase", ("Scopia#vase5", "Scopia#vase3")))
        else:
            home.against_wall(category)


def _hang(home: Furnisher, kind: str) -> None:
    """Pictures, clocks and mirrors on the walls."""
    for _ in range(home.rng.choice([0, 0, 1, 1, 2])):
        _wall_thing(home, "picture", (), 1.15, 1.5)
    chance = {"kitchen": 0.45, "bathroom": 0.08, "hallway": 0.3}.get(kind, 0.3)
    if home.rng.random() < chance:
        _wall_thing(home, "clock", (), 1.2, 1.7)


def _wall_thing(
    home: Furnisher, category: str, only: tuple[str, ...], low: float, high: float
) -> None:
    mesh = home.pick(category, only)
    if category in ("picture", "mirror"):
        w, d, h = mesh.size_m
        stretch = home.rng.uniform(0.6, 1.5)
        mesh = Mesh(mesh.id, (w * stretch, d, h * home.rng.uniform(0.7, 1.3)), mesh.z_m)
    home.against_wall(category, mesh, home.rng.uniform(low, high))


def _scatter(home: Furnisher) -> None:
    """Things on the floor that no goal names."""
    for _ in range(home.rng.choice([0, 0, 1, 1, 2])):
        mesh = home.pick("other", FLOOR_THINGS)
        if home.rng.random() < 0.5:
            home.free_standing("other", mesh)
        else:
            home.against_wall("other", mesh, yaw_jitter=0.2)


def _rug(home: Furnisher, chance: float) -> None:
    """A thin rug under what stands there: it takes part in no overlap test."""
    if home.rng.random() < chance:
        mesh = home.pick("other", RUGS)
        w, d, _ = mesh.size_m
        room = home.room.inset(max(w, d) / 2 + 0.05)
        if room.width > 0 and room.depth > 0:
            x, y = home.rng.uniform(room.x0, room.x1), home.rng.uniform(room.y0, room.y1)
            yaw = home.rng.choice([0.0, 1.5708])
            index, tint = len(home.objects), hex_colour(home.rng.random(), 0.2, 0.9)
            home.objects.append(
                SceneObject(f"rug-{index}", "other", mesh.id, (x, y, 0.0), yaw, (w, d, 0.01), tint)
            )


def _load(
    home: Furnisher, support: SceneObject | None, things: tuple[str, ...], most: int,
    named: dict[str, float],
) -> None:  # fmt: skip
    """Put small things on a support: each named category by its chance, then clutter."""
    if support is None:
        return
    only = {"plant": SMALL_PLANTS, "lamp": TABLE_LAMPS,
            "clock": ("Blend Swap CC-BY#clock",),
            "television": ("Blend Swap CC-0#led_tv", "Scopia#tv")}  # fmt: skip
    for category, chance in named.items():
        if home.rng.random() < chance:
            facing = category in ("television", "laptop", "clock")
            home.on_top(category, support, home.pick(category, only.get(category, ())), facing)
    for _ in range(home.rng.randint(0, most)):
        home.on_top("other", support, home.pick("other", things), facing=home.rng.random() < 0.5)


def _has(home: Furnisher, category: str) -> bool:
    return any(obj.category == category for obj in home.objects)
