"""RoboTHOR's apartments as scenes: the same layout, other meshes (README.md says what is real)."""

import hashlib
import math
import random
from collections.abc import Sequence
from dataclasses import replace
from statistics import median_low

from hil_sim.scenes.colours import hex_colour
from hil_sim.scenes.format import CATEGORIES, Room, Scene, SceneObject, Wall, contains
from hil_sim.scenes.furniture.boxes import furniture
from hil_sim.scenes.furniture.surfaces import is_rest, resting_place
from hil_sim.scenes.robothor.evidence import OUTER
from hil_sim.scenes.robothor.facing import TABLES, faced
from hil_sim.scenes.robothor.fitting import TO_MEASURE, fitted
from hil_sim.scenes.robothor.footprints import LEAST_M, Footprint, footprint
from hil_sim.scenes.robothor.metadata import Thing, apartment, layout_of
from hil_sim.scenes.robothor.regions import Segment, regions, room_type
from hil_sim.scenes.robothor.walls import layouts

WALL_HEIGHT_M = 2.44
OUTER_M, INNER_M = 0.12, 0.03
"""Thickness of walls: paintings on both sides of an inner one are 2.5 cm apart."""
SPARE_M = 0.015
"""Between the rectangle and the outer walls, so that official starts 0.24 m from its edge are free
floor on our grid of 5 cm too."""
CATEGORY: dict[str, tuple[str, ...]] = {
    "AlarmClock": ("alarm clock",),
    "Apple": ("apple",),
    "ArmChair": ("armchair",),
    "BaseballBat": ("baseball bat",),
    "BasketBall": ("basketball",),
    "Bed": ("bed",),
    "Book": ("book",),
    "Bottle": ("bottle",),
    "Bowl": ("bowl",),
    "Box": ("box",),
    "ButterKnife": ("butter knife", "knife"),
    "CD": ("cd",),
    "Candle": ("candle",),
    "CellPhone": ("cell phone",),
    "Chair": ("chair",),
    "CoffeeTable": ("coffee table",),
    "Cup": ("cup",),
    "Desk": ("desk",),
    "DeskLamp": ("desk lamp", "lamp"),
    "DiningTable": ("table",),
    "Dresser": ("dresser",),
    "FloorLamp": ("floor lamp", "lamp"),
    "Fork": ("fork",),
    "GarbageCan": ("trash can",),
    "HousePlant": ("plant",),
    "Laptop": ("laptop",),
    "Mug": ("mug",),
    "Newspaper": ("newspaper",),
    "Painting": ("picture",),
    "Pen": ("pen",),
    "Pencil": ("pencil",),
    "PepperShaker": ("pepper shaker",),
    "Pillow": ("pillow",),
    "Plate": ("plate",),
    "Pot": ("pot",),
    "RemoteControl": ("remote control",),
    "SaltShaker": ("salt shaker",),
    "ShelvingUnit": ("shelving unit", "bookcase"),
    "SideTable": ("side table", "nightstand"),
    "Sofa": ("sofa",),
    "SprayBottle": ("spray bottle",),
    "Statue": ("statue",),
    "TVStand": ("tv stand", "cabinet"),
    "TeddyBear": ("teddy bear",),
    "Television": ("television",),
    "TennisRacket": ("tennis racket",),
    "Vase": ("vase",),
    "Watch": ("watch",),
}
"""Our category of each AI2-THOR type: the first that has meshes here, else `other`."""
GOALS = {
    kind: CATEGORY[kind][0]
    for kind in (
        "AlarmClock", "Apple", "BaseballBat", "BasketBall", "Bowl", "GarbageCan", "HousePlant",
        "Laptop", "Mug", "SprayBottle", "Television", "Vase",
    )
}  # fmt: skip
PARTS = ("Drawer", "Shelf", "Floor")
"""Types that are parts of furniture or of the apartment."""
SUPPORTS = ("CoffeeTable", "Desk", "DiningTable", "Dresser", "SideTable", "TVStand")
"""Types that carry things on their top: meshes with a flat one are preferred."""
SEATS = ("ArmChair", "Bed", "Sofa")
"""Types whose meshes have a seat or a mattress of another height, below arms and backs."""
SURFACE = 0.6
"""Share of its height above which what stands on a support stands on its top."""
TINTED = ("armchair", "bed", "book", "box", "chair", "cup", "mug", "pillow", "sofa", "vase")
SPLITS = {
    "Train": (("train",), ("train", "varied")),
    "Val": (("train", "val"), ("train", "val", "val varied")),
}
"""Of the meshes that scenes of a split show: furniture, and what must keep its proportions."""
UNLIKE = (
    "Blend Swap CC-0#decorativePlant", "Blend Swap CC-0#orchids", "Blend Swap CC-0#plant",
    "Blend Swap CC-BY#decorativePlant", "Scopia#vase1", "builtin:vase.1",
)  # fmt: skip
"""From 1 m plants that show hardly a leaf, and beakers for vases."""
FLOORS = ("#b58a5b", "#8a5f3c", "#caa472", "#a77b52", "#bfc3c4", "#9aa0a3", "#c9b9a3")
WALL_COLOURS = ("#efe9dd", "#f4f1ea", "#e3e0d8", "#dcd6c8", "#e8e8e6", "#d9dfe2", "#dfe6da")


def robothor_scene(name: str) -> Scene:
    """The replica of a RoboTHOR scene, e.g. FloorPlan_Val1_1; MetadataError if there is none."""
    things = [thing for thing in apartment(name) if thing.type not in PARTS]
    inner = layouts()[layout_of(name)].walls
    walls = (*_outer_walls(), *(Wall(start, end, INNER_M) for start, end in inner))
    boxes = {thing.id: _inside(_upright(thing, things)) for thing in things}
    tables = [boxes[thing.id] for thing in things if thing.type in TABLES]
    objects = []
    for thing in things:
        box = faced(thing, boxes[thing.id], _facing_walls(inner), tables)
        objects.append(_object(name, thing, box, bool(_carried(thing, things))))
    return Scene(
        name=name,
        walls=walls,
        doors=(),
        rooms=_rooms(name, inner, [(thing.type, boxes[thing.id]) for thing in things]),
        objects=_numbered(_settled(things, objects)),
        wall_height_m=WALL_HEIGHT_M,
    )


def _outer_walls() -> tuple[Wall, ...]:
    x0, y0, x1, y1 = OUTER
    h = OUTER_M / 2 + SPARE_M
    corners = [(x0 - h, y0 - h), (x1 + h, y0 - h), (x1 + h, y1 + h), (x0 - h, y1 + h)]
    ends = zip(corners, corners[1:] + corners[:1], strict=True)
    return tuple(Wall(start, end, OUTER_M, "outer") for start, end in ends)


def _facing_walls(inner: Sequence[Segment]) -> list[Wall]:
    """Walls by their faces' planes, near enough for telling which is near."""
    x0, y0, x1, y1 = OUTER
    edge = [((x0, y0), (x1, y0)), ((x1, y0), (x1, y1)), ((x1, y1), (x0, y1)), ((x0, y1), (x0, y0))]
    return [Wall(start, end) for start, end in (*edge, *inner)]


def _upright(thing: Thing, things: Sequence[Thing]) -> Footprint:
    """The object's box, standing on the floor where it would be sunk into it; the top of what
    carries things is where they stand, below a rim or a rail."""
    box = footprint(thing)
    high = box.z + box.height
    if thing.type in SUPPORTS:
        tops = [top for top in _carried(thing, things) if SURFACE * high < top < high]
        high = max(tops, default=high)
    low = max(box.z, 0.0)
    return replace(box, z=low, height=max(high - low, LEAST_M))


def _carried(thing: Thing, things: Sequence[Thing]) -> list[float]:
    """Heights at which things stand on or in this one."""
    return [other.low_m[2] for other in things if thing.id in other.parents]


def _inside(box: Footprint) -> Footprint:
    """The box moved by what it reaches beyond the outer walls."""
    x0, y0, x1, y1 = OUTER
    half_x, half_y = box.half_along(0.0), box.half_along(math.pi / 2)
    x = min(max(box.x, x0 + half_x), x1 - half_x)
    y = min(max(box.y, y0 + half_y), y1 - half_y)
    return replace(box, x=x, y=y)


def _settled(things: Sequence[Thing], objects: Sequence[SceneObject]) -> list[SceneObject]:
    """What lies on a bed or a seat lies on that of the mesh, which may be higher or lower."""
    settled = list(objects)
    for seat, obj in zip(things, objects, strict=True):
        place = resting_place(obj) if seat.type in SEATS else None
        lying = [i for i, thing in enumerate(things) if seat.id in thing.parents]
        if place is None or not lying:
            continue
        level = median_low([objects[i].position_m[2] for i in lying])
        for i in lying:
            x, y, z = objects[i].position_m
            z = round(place.z1 + max(z - level, 0.0), 3)
            settled[i] = replace(objects[i], position_m=(x, y, z))
    return settled


def _object(scene: str, thing: Thing, box: Footprint, carries: bool) -> SceneObject:
    rng = random.Random(hashlib.sha256(f"{scene}/{thing.id}".encode()).hexdigest())
    category = next(
        (c for c in CATEGORY.get(thing.type, ()) if c in CATEGORIES and furniture().get(c)), "other"
    )
    if category == "other":
        mesh, turn, size = "builtin:box", 0, (box.width, box.depth, box.height)
    else:
        usual, more = SPLITS["Val" if scene.startswith("FloorPlan_Val") else "Train"]
        splits = usual if thing.type in TO_MEASURE else more
        pool = [m for m in furniture()[category] if m.split in splits and m.id not in UNLIKE]
        if carries and thing.type in SUPPORTS:
            pool = [m for m in pool if m.top] or pool
        if carries and thing.type in SEATS:
            pool = [m for m in pool if is_rest(m.id)] or pool
        mesh, turn, size = fitted(rng, pool, box, thing.type)
    width, depth, height = size
    return SceneObject(
        id=thing.type,
        category=category,
        mesh=mesh,
        position_m=(round(box.x, 3), round(box.y, 3), round(box.z, 3)),
        yaw_rad=round(math.remainder(box.yaw_rad + turn * math.pi / 2, 2 * math.pi), 4),
        size_m=(round(width, 3), round(depth, 3), round(height, 3)),
        tint=_tint(rng, category),
    )


def _tint(rng: random.Random, category: str) -> str | None:
    strong = rng.random()
    hue, saturation, value = rng.random(), rng.uniform(0.1, 0.6), rng.uniform(0.65, 1.0)
    if category == "other" or (category in TINTED and strong < 0.5):
        return hex_colour(hue, saturation, value)
    return None


def _numbered(objects: Sequence[SceneObject]) -> tuple[SceneObject, ...]:
    """Ids by type and count, in the metadata's order: armchair-1, armchair-2."""
    count: dict[str, int] = {}
    named = []
    for obj in objects:
        count[obj.id] = count.get(obj.id, 0) + 1
        named.append(SceneObject(**{**vars(obj), "id": f"{obj.id.lower()}-{count[obj.id]}"}))
    return tuple(named)


def _rooms(
    scene: str, inner: Sequence[Segment], things: Sequence[tuple[str, Footprint]]
) -> tuple[Room, ...]:
    rng = random.Random(f"rooms/{scene}")
    floor, rooms, count = rng.choice(FLOORS), list[Room](), dict[str, int]()
    for polygon in regions(OUTER, inner):
        here = [(name, box) for name, box in things if contains(polygon, box.x, box.y)]
        kind = room_type(here)
        count[kind] = count.get(kind, 0) + 1
        name = kind if count[kind] == 1 else f"{kind} {count[kind]}"
        rooms.append(Room(name, kind, polygon, floor, rng.choice(WALL_COLOURS)))
    return tuple(rooms)
