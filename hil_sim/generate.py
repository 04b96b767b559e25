"""Generated homes: a seeded floor plan whose rooms are furnished by type.

`generate(seed)` is a training home; `generate(seed, "val")` draws from other seeds and may use
meshes that never appear in training homes.
"""

import random
from collections import Counter

from hil_sim.floorplan import Plan, draw_plan
from hil_sim.furnish import Furnisher, hex_colour
from hil_sim.recipes import furnish
from hil_sim.scene import Room, Scene

WALL_COLOURS = ("#efe9dd", "#f4f1ea", "#e3e0d8", "#dcd6c8", "#f2ead8", "#e8e8e6", "#d9dfe2")
WOOD = ("#b58a5b", "#8a5f3c", "#caa472", "#6b4a31", "#a77b52", "#d6b98c")
TILES = ("#d8d4cb", "#bfc3c4", "#9aa0a3", "#e6e2da", "#777c80", "#c9b9a3")


def generate(seed: int, split: str = "train", rooms: int | None = None) -> Scene:
    """The home of this seed: the same seed gives the same home."""
    rng = random.Random(f"{split}/{seed}")
    rooms = rooms or rng.randint(3, 6)
    plan = draw_plan(rng, rooms)
    while not _livable(plan):
        plan = draw_plan(rng, rooms)
    home = Furnisher(rng, plan, split)
    for kind, rect in plan.rooms:
        home.enter(rect)
        furnish(home, kind)
    return Scene(
        name=f"{split}-{seed}",
        walls=plan.walls,
        doors=plan.doors,
        rooms=_rooms(rng, plan),
        objects=tuple(home.objects),
        wall_height_m=round(rng.uniform(2.35, 2.8), 2),
    )


def _livable(plan: Plan) -> bool:
    least = {"bathroom": 1.75, "hallway": 1.2}
    if any(min(r.width, r.depth) < least.get(kind, 2.5) for kind, r in plan.rooms):
        return False
    return _reachable(plan)


def _reachable(plan: Plan) -> bool:
    """Whether doors connect all rooms."""
    seen, todo = {0}, [0]
    while todo:
        here = plan.rooms[todo.pop()][1]
        for door in plan.doors:
            x, y = (door.start[0] + door.end[0]) / 2, (door.start[1] + door.end[1]) / 2
            if not here.touches(x, y):
                continue
            beyond = {j for j, (_, room) in enumerate(plan.rooms) if room.touches(x, y)} - seen
            seen |= beyond
            todo += sorted(beyond)
    return len(seen) == len(plan.rooms)


def _rooms(rng: random.Random, plan: Plan) -> tuple[Room, ...]:
    common_wall, common_floor = _wall_colour(rng), rng.choice(WOOD + TILES)
    rooms: list[Room] = []
    count: Counter[str] = Counter()
    for kind, r in plan.rooms:
        count[kind] += 1
        wet = kind in ("kitchen", "bathroom")
        floor = rng.choice(TILES + WOOD[:2] if wet else WOOD + TILES[:2])
        if rng.random() < 0.12:
            floor = hex_colour(rng.random(), rng.uniform(0.05, 0.5), rng.uniform(0.3, 0.85))
        rooms.append(
            Room(
                name=f"{kind} {count[kind]}" if count[kind] > 1 else kind,
                type=kind,
                polygon=((r.x0, r.y0), (r.x1, r.y0), (r.x1, r.y1), (r.x0, r.y1)),
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
