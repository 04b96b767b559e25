"""Generated homes: a seeded floor plan whose rooms are furnished by type.

`generate(seed)` is a training home; `generate(seed, "val")` draws from other seeds and may use
meshes that never appear in training homes.
"""

import random
from collections import Counter

from hil_sim.scenes.colours import hex_colour
from hil_sim.scenes.format import Room, Scene, contains
from hil_sim.scenes.generated.clutter import seat, strew
from hil_sim.scenes.generated.floorplan import FloorPlan, polygon_of
from hil_sim.scenes.generated.furnisher import Furnisher
from hil_sim.scenes.generated.layouts import FEWEST, MOST, LayoutError, draw_plan
from hil_sim.scenes.generated.recipes import furnish, lacks
from hil_sim.scenes.generated.valid import problems

CLUTTERED, VARIED = "cluttered", "varied"
ATTEMPTS, ROOM_ATTEMPTS = 60, 8
WALL_COLOURS = ("#efe9dd", "#f4f1ea", "#e3e0d8", "#dcd6c8", "#f2ead8", "#e8e8e6", "#d9dfe2")
WOOD = ("#b58a5b", "#8a5f3c", "#caa472", "#6b4a31", "#a77b52", "#d6b98c")
TILES = ("#d8d4cb", "#bfc3c4", "#9aa0a3", "#e6e2da", "#777c80", "#c9b9a3")


def generate(seed: int, split: str = "train", rooms: int | None = None, kind: str = "") -> Scene:
    """The home of this seed: the same seed gives the same home, with `problems` none.

    `rooms`: 4 to 9, hallway included; None lets the seed choose. `kind`: "cluttered", with things
    strewn about that homes seldom show, or "varied", with furniture of shapes, proportions and
    colours that no other home has. LayoutError if it cannot be.
    """
    name = f"{split}-{seed}" + (f"-rooms{rooms}" if rooms is not None else "")
    count = draw_rooms(seed, split) if rooms is None else rooms
    rng = random.Random(f"{split}/{seed}" + (f"/{kind}" if kind else ""))
    name += f"-{kind}" if kind else ""
    found = [""]
    for _ in range(ATTEMPTS):
        scene = _draw(rng, name, split, count, kind)
        found = [*_lacking(scene), *problems(scene)]
        if not found:
            return scene
    raise LayoutError(f"{name}: no good home in {ATTEMPTS} attempts; the last: {found[0]}")


def draw_rooms(seed: int, split: str, low: int = FEWEST, high: int = MOST) -> int:
    """How many rooms the home of this seed has, of a range."""
    return random.Random(f"{split}/{seed}/rooms").randint(low, high)


def _draw(rng: random.Random, name: str, split: str, rooms: int, kind: str) -> Scene:
    plan = draw_plan(rng, rooms)
    height = round(rng.uniform(2.4, 2.8), 2)
    home = Furnisher(rng, plan, split, height, varied=kind == VARIED)
    for room in plan.rooms:
        for left in reversed(range(ROOM_ATTEMPTS)):
            home.enter(room)
            if kind == VARIED:
                seat(home)
            furnish(home, room.kind)
            if not left or not lacks(room.kind, {obj.category for obj in home.here}):
                break
            home.clear()
        if kind == CLUTTERED:
            strew(home)
    home.drop_unreachable()
    return Scene(
        name=name,
        walls=plan.walls,
        doors=plan.doors,
        rooms=_rooms(rng, plan),
        objects=tuple(home.objects),
        wall_height_m=height,
    )


def _lacking(scene: Scene) -> list[str]:
    """Rooms without what makes them such rooms."""
    found = []
    for room in scene.rooms:
        here = {o.category for o in scene.objects if contains(room.polygon, *o.position_m[:2])}
        if missing := lacks(room.type, here):
            found.append(f"room {room.name}: has no {missing}")
    return found


def _rooms(rng: random.Random, plan: FloorPlan) -> tuple[Room, ...]:
    common_wall, common_floor = _wall_colour(rng), rng.choice(WOOD + TILES)
    rooms: list[Room] = []
    count: Counter[str] = Counter()
    for place in plan.rooms:
        kind = place.kind
        count[kind] += 1
        wet = kind in ("kitchen", "bathroom")
        floor = rng.choice(TILES + WOOD[:2] if wet else WOOD + TILES[:2])
        if rng.random() < 0.12:
            floor = hex_colour(rng.random(), rng.uniform(0.05, 0.5), rng.uniform(0.3, 0.85))
        rooms.append(
            Room(
                name=f"{kind} {count[kind]}" if count[kind] > 1 else kind,
                type=kind,
                polygon=polygon_of(place),
                floor=common_floor if rng.random() < 0.35 else floor,
                wall=common_wall if rng.random() < 0.4 else _wall_colour(rng),
            )
        )
    return tuple(rooms)


def _wall_colour(rng: random.Random) -> str:
    if rng.random() < 0.6:
        return rng.choice(WALL_COLOURS)
    strong = rng.random() < 0.25
    return hex_colour(
        rng.random(),
        rng.uniform(0.3, 0.6) if strong else rng.uniform(0.02, 0.25),
        rng.uniform(0.4, 0.8) if strong else rng.uniform(0.7, 0.97),
    )
