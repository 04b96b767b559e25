"""What stands in 120 single rooms, counted: makes `scenes/generated/placement.json`.

The rooms (30 kitchens, living rooms, bedrooms and bathrooms) are the object metadata of iTHOR in
the PyPI wheel `procthor` 0.0.1.dev2, Apache-2.0 (`scenes/robothor/metadata.py` fetches it). Run
`python -m hil_sim.importers.placement_stats` after a change here.
"""

import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from hil_sim.scenes.generated.placement import TABLE
from hil_sim.scenes.robothor import metadata

SOURCE = {
    "rooms": "30 kitchens, 30 living rooms, 30 bedrooms, 30 bathrooms of iTHOR",
    "file": "procthor/databases/ai2thor-object-metadata.json in the PyPI wheel procthor 0.0.1.dev2",
    "licence": "Apache-2.0",
    "made_by": "python -m hil_sim.importers.placement_stats",
}
NAMES = {
    "Bed": "bed", "Sofa": "sofa", "ArmChair": "armchair", "Chair": "chair", "Stool": "stool",
    "Footstool": "stool", "Ottoman": "ottoman", "DiningTable": "table",
    "CoffeeTable": "coffee table", "SideTable": "nightstand", "Desk": "desk",
    "Dresser": "dresser", "ShelvingUnit": "bookcase", "Shelf": "shelf", "TVStand": "tv stand",
    "CounterTop": "counter", "Fridge": "refrigerator", "Microwave": "microwave",
    "CoffeeMachine": "coffee machine", "Toaster": "toaster", "Kettle": "kettle", "Pot": "pot",
    "Pan": "pan", "Bowl": "bowl", "Mug": "mug", "Cup": "cup", "Apple": "apple", "Plate": "plate",
    "Bottle": "bottle", "WineBottle": "wine bottle", "SoapBottle": "soap bottle", "Book": "book",
    "CellPhone": "cell phone", "RemoteControl": "remote control", "Laptop": "laptop",
    "Television": "television", "HousePlant": "plant", "Vase": "vase", "Statue": "statue",
    "Box": "box", "Pillow": "pillow", "GarbageCan": "trash can", "FloorLamp": "floor lamp",
    "DeskLamp": "desk lamp", "Painting": "picture", "Poster": "picture", "Mirror": "mirror",
    "AlarmClock": "alarm clock", "BaseballBat": "baseball bat", "BasketBall": "basketball",
    "TeddyBear": "teddy bear", "LaundryHamper": "laundry basket", "Toilet": "toilet",
    "Sink": "sink", "Bathtub": "bathtub", "ShowerDoor": "shower", "SprayBottle": "spray bottle",
    "Candle": "candle", "TennisRacket": "tennis racket", "Newspaper": "newspaper",
    "Bread": "bread", "Tomato": "tomato", "Lettuce": "lettuce", "Potato": "potato",
    "PaperTowelRoll": "paper towel", "TissueBox": "tissue box", "Plunger": "plunger",
    "Dumbbell": "dumbbell", "DogBed": "dog bed", "WateringCan": "watering can", "Boots": "boots",
    "SaltShaker": "salt shaker", "PepperShaker": "pepper shaker", "VacuumCleaner": "vacuum cleaner",
    "ToiletPaper": "toilet paper", "Towel": "towel", "HandTowel": "towel",
}  # fmt: skip
"""AI2-THOR types -> our categories, and a few finer names (counter, shelf, floor lamp, ...)."""
SUPPORTS = {
    "Floor": "floor", "StoveBurner": "stove", "SinkBasin": "sink", "BathtubBasin": "bathtub",
    "Cabinet": "inside", "Drawer": "inside", "Fridge": "inside", "Safe": "inside",
    "TowelHolder": "wall", "HandTowelHolder": "wall", "ToiletPaperHanger": "wall",
}  # fmt: skip
WALL_GAP_M = 0.25
"""What stands nearer than this to the room's bounding rectangle stands against a wall."""
NEAR_M = 1.0
RARE = 0.03
LEAST = 3
"""What fewer instances say about walls and neighbours is left out."""
SMALL = (
    "shelf",
    "newspaper",
    "candle",
    "boots",
    "plunger",
    "pillow",
    "remote control",
    "toilet paper",
    "spray bottle",
    "towel",
    "laptop",
)
"""Nobody is placed because these are near."""
MOST = 6

Rect = tuple[float, float, float, float]


@dataclass(frozen=True)
class Standing:
    """An object of a room: footprint (x0, y0, x1, y1) m, and what it stands on."""

    category: str
    rect: Rect
    on: str


def read_room(things: Iterable[metadata.Thing]) -> tuple[list[Standing], Rect]:
    """The known things of a room and its bounding rectangle, metres, on the plan."""
    things = [thing for thing in things if thing.type != "Floor"]
    types = {thing.id: thing.type for thing in things}
    floor = min(thing.low_m[2] for thing in things)
    known = [
        Standing(NAMES[thing.type], _rect(thing), _support(thing, types, thing.low_m[2] - floor))
        for thing in things
        if thing.type in NAMES
    ]
    x0, y0, x1, y1 = zip(*map(_rect, things), strict=True)
    return known, (min(x0), min(y0), max(x1), max(y1))


def _rect(thing: metadata.Thing) -> Rect:
    return (*thing.low_m[:2], *thing.high_m[:2])


def _support(thing: metadata.Thing, types: Mapping[str, str], low_m: float) -> str:
    for parent in thing.parents:
        kind = types.get(parent, parent.split("|")[0])
        if name := SUPPORTS.get(kind) or NAMES.get(kind):
            return name
    return "wall" if low_m > 0.4 else "floor"


def count_rooms(rooms: list[tuple[list[Standing], Rect]]) -> dict[str, dict[str, Any]]:
    """Per category: presence, counts, what it stands on, what is near, how often at a wall."""
    table: dict[str, dict[str, Any]] = {}
    names = sorted({thing.category for things, _ in rooms for thing in things})
    for name in names:
        here = [sum(t.category == name for t in things) for things, _ in rooms]
        mine = [(t, things, rect) for things, rect in rooms for t in things if t.category == name]
        on = Counter(t.on for t, _, _ in mine)
        table[name] = {
            "present": _share(sum(n > 0 for n in here), len(rooms)),
            "mean": round(sum(here) / max(1, sum(n > 0 for n in here)), 2),
            "counts": [_share(sum(min(n, MOST) == k for n in here), len(rooms))
                       for k in range(min(max(here), MOST) + 1)],
            "on": _shares(on, len(mine)),
        }  # fmt: skip
        standing = [row for row in mine if row[0].on == "floor"]
        if len(standing) >= LEAST:
            at_wall = sum(_wall_gap(t.rect, rect) < WALL_GAP_M for t, _, rect in standing)
            table[name]["wall"] = _share(at_wall, len(standing))
            table[name]["near"] = _shares(_neighbours(standing), len(standing))
    return table


def _neighbours(standing: list[tuple[Standing, list[Standing], Rect]]) -> Counter[str]:
    """How many of these have each category of floor-standing things within 1 m."""
    near: Counter[str] = Counter()
    for thing, things, _ in standing:
        near.update(
            {t.category for t in things
             if t is not thing and t.on == "floor" and t.category not in SMALL
             and _gap(t.rect, thing.rect) <= NEAR_M}
        )  # fmt: skip
    return near


def _gap(a: Rect, b: Rect) -> float:
    dx = max(a[0] - b[2], b[0] - a[2], 0.0)
    dy = max(a[1] - b[3], b[1] - a[3], 0.0)
    return math.hypot(dx, dy)


def _wall_gap(thing: Rect, room: Rect) -> float:
    return min(thing[0] - room[0], thing[1] - room[1], room[2] - thing[2], room[3] - thing[3])


def _share(part: int, whole: int) -> float:
    return round(part / whole, 3)


def _shares(counts: Mapping[str, int], whole: int) -> dict[str, float]:
    kept = {key: _share(n, whole) for key, n in counts.items() if n / whole >= RARE}
    return dict(sorted(kept.items(), key=lambda item: (-item[1], item[0])))


def count_all() -> dict[str, Any]:
    """The whole content of placement.json."""
    return {
        "source": SOURCE,
        "rooms": {
            kind: count_rooms([read_room(things) for things in metadata.rooms(kind)])
            for kind in metadata.ROOM_LISTS
        },
    }


def as_text(table: Mapping[str, Any]) -> str:
    """JSON with one category a line."""
    lines = ["{", f'  "source": {json.dumps(table["source"])},', '  "rooms": {']
    for i, (kind, rows) in enumerate(table["rooms"].items()):
        body = ",\n".join(f"      {json.dumps(k)}: {json.dumps(v)}" for k, v in rows.items())
        comma = "," if i + 1 < len(table["rooms"]) else ""
        lines.append(f"    {json.dumps(kind)}: {{\n{body}\n    }}{comma}")
    return "\n".join([*lines, "  }", "}"]) + "\n"


if __name__ == "__main__":
    TABLE.write_text(as_text(count_all()), encoding="utf-8")
    print(TABLE)
