"""How the rooms of a generated home lie to each other: four kinds of plan.

`spine`: rooms on both sides of a straight corridor, often a living room across its end.
`elbow`: rooms around an L-shaped corridor. `hub`: rooms on both sides of a living room.
`cluster`: a rectangle cut into rooms that lead into one another.
"""

import random
from collections.abc import Callable, Sequence

from hil_sim.scenes.generated.doors import draw_doors
from hil_sim.scenes.generated.floorplan import FloorPlan, PlanRoom, Rect, turned, walls_around
from runtime.errors import RfNavError

FEWEST, MOST = 4, 9
"""Rooms of a home, hallway included."""
WIDTH_M = {"living room": 5.0, "kitchen": 3.5, "bedroom": 3.5, "bathroom": 2.2, "study": 3.0,
           "dining room": 3.6}  # fmt: skip
"""How long a stretch of a strip each room asks for; the strip's rooms are then fitted to it."""
LEAST_M = {"living room": 3.3, "kitchen": 2.5, "bedroom": 2.75, "bathroom": 1.85, "study": 2.4,
           "dining room": 2.8, "hallway": 1.25}  # fmt: skip
MOST_M2 = {"bathroom": 10.5, "kitchen": 22.0, "study": 19.0, "dining room": 22.0}
MOST_ASPECT = 2.3
TRIES = 500
EXTRA = (("bedroom", 1.2), ("study", 0.8), ("dining room", 0.7), ("bathroom", 0.7),
         ("bedroom", 0.9), ("bathroom", 0.4), ("study", 0.3), ("bedroom", 0.4))  # fmt: skip
"""What homes of more than four rooms have besides, drawn without replacement by weight."""
KINDS = {
    4: ("hub", "cluster"),
    5: ("hub", "hub", "cluster", "spine", "spine"),
    6: ("hub", "cluster", "spine", "spine", "elbow"),
    7: ("hub", "spine", "spine", "elbow", "elbow"),
    8: ("spine", "elbow"),
    9: ("spine", "elbow"),
}


class LayoutError(RfNavError):
    """A home that cannot be drawn."""


def draw_plan(rng: random.Random, rooms: int) -> FloorPlan:
    """A home of that many rooms (4 to 9, hallway included), all reachable through doors."""
    if not FEWEST <= rooms <= MOST:
        raise LayoutError(f"rooms: is {rooms}, must be {FEWEST} to {MOST}")
    kind = rng.choice(KINDS[rooms])
    for _ in range(TRIES):
        drawn = LAYOUTS[kind](rng, rooms)
        if drawn is None or not _livable(drawn):
            continue
        placed = turned(rng, drawn)
        doors = draw_doors(rng, placed)
        if doors is not None:
            return FloorPlan(placed, walls_around(placed), doors)
    raise LayoutError(f"no livable {kind} plan of {rooms} rooms in {TRIES} tries")


def _programme(rng: random.Random, count: int) -> list[str]:
    """The types of that many rooms, hallway not counted."""
    kinds = ["living room", "bathroom", "bedroom", "kitchen"][:count]
    extra = sorted(EXTRA, key=lambda row: rng.random() ** (1 / row[1]), reverse=True)
    for kind, _ in extra:
        if len(kinds) < count and (kind != "bathroom" or count >= 5):
            kinds.append(kind)
    return kinds


def _livable(rooms: Sequence[PlanRoom]) -> bool:
    for room in rooms:
        for rect in room.rects:
            short, long = sorted((rect.width, rect.depth))
            if short < LEAST_M[room.kind]:
                return False
            if room.kind != "hallway" and long / short > MOST_ASPECT:
                return False
        if room.area > MOST_M2.get(room.kind, 42.0):
            return False
    return True


Placed = list[PlanRoom] | None


def _spine(rng: random.Random, count: int) -> Placed:
    kinds = _programme(rng, count - 1)
    low, corridor, high = rng.uniform(3.1, 4.3), rng.uniform(1.35, 1.8), rng.uniform(3.1, 4.3)
    rooms, kinds = _end_block(rng, kinds, (low, corridor, high), 0.7)
    lower, upper = _halves(rng, kinds)
    if not lower or not upper:
        return None
    width = (_asked(lower) + _asked(upper)) / 2 * rng.uniform(0.93, 1.1)
    depth = low + corridor + high
    rooms.append(PlanRoom("hallway", (Rect(0.0, low, width, low + corridor),)))
    rooms += _strip(rng, lower, Rect(0.0, 0.0, width, low))
    return rooms + _strip(rng, upper, Rect(0.0, low + corridor, width, depth))


def _elbow(rng: random.Random, count: int) -> Placed:
    kinds = _programme(rng, count - 1)
    low, corridor, high = rng.uniform(3.1, 4.0), rng.uniform(1.35, 1.7), rng.uniform(3.3, 4.3)
    rooms, kinds = _end_block(rng, kinds, (low, corridor, high), 0.75 if count > 6 else 0.3)
    rng.shuffle(kinds)
    beside = rng.choice((1, 2)) if len(kinds) > 4 else 1
    side, rest = kinds[:beside], kinds[beside:]
    above = max(1, round(len(rest) * rng.uniform(0.3, 0.45)))
    upper, lower = rest[:above], rest[above:]
    if not lower:
        return None
    knee, block = _asked(upper) * rng.uniform(0.95, 1.1), rng.uniform(3.0, 4.2)
    width, depth = knee + corridor + block, low + corridor + high
    if not 0.8 < width / _asked(lower) < 1.35:
        return None
    bend = (Rect(0.0, low, knee + corridor, low + corridor),
            Rect(knee, low + corridor, knee + corridor, depth))  # fmt: skip
    rooms.append(PlanRoom("hallway", bend))
    rooms += _strip(rng, lower, Rect(0.0, 0.0, width, low))
    rooms += _strip(rng, upper, Rect(0.0, low + corridor, knee, depth))
    return rooms + _strip(rng, side, Rect(knee + corridor, low, width, depth))


def _hub(rng: random.Random, count: int) -> Placed:
    kinds = _programme(rng, count)
    kinds.remove("living room")
    middle = ["living room"]
    if count > 5:
        second = "dining room" if "dining room" in kinds else "kitchen"
        kinds.remove(second)
        middle.append(second)
    lower, upper = _halves(rng, kinds)
    if not lower or not upper:
        return None
    low, mid, high = rng.uniform(2.9, 4.0), rng.uniform(3.6, 4.6), rng.uniform(2.9, 4.0)
    width = (_asked(lower) + _asked(upper)) / 2 * rng.uniform(0.95, 1.15)
    rooms = _strip(rng, middle, Rect(0.0, low, width, low + mid))
    rooms += _strip(rng, lower, Rect(0.0, 0.0, width, low))
    return rooms + _strip(rng, upper, Rect(0.0, low + mid, width, low + mid + high))


def _cluster(rng: random.Random, count: int) -> Placed:
    kinds = sorted(_programme(rng, count), key=lambda kind: WIDTH_M[kind] + rng.uniform(-0.2, 0.2))
    area = count * rng.uniform(11.5, 16.0)
    width = (area * rng.uniform(0.8, 1.5)) ** 0.5
    cells = [Rect(0.0, 0.0, width, area / width)]
    while len(cells) < count:
        cells.sort(key=lambda cell: cell.area)
        cells += _split(rng, cells.pop())
    cells.sort(key=lambda cell: cell.area)
    return [PlanRoom(kind, (cell,)) for kind, cell in zip(kinds, cells, strict=True)]


LAYOUTS: dict[str, Callable[[random.Random, int], Placed]] = {
    "spine": _spine,
    "elbow": _elbow,
    "hub": _hub,
    "cluster": _cluster,
}


def _end_block(
    rng: random.Random, kinds: list[str], depths: tuple[float, float, float], chance: float
) -> tuple[list[PlanRoom], list[str]]:
    """Perhaps a living room across the corridor's end (x < 0), with a second room beside it.

    `depths`: of the lower strip, the corridor and the upper strip. Returns the rooms placed and
    the kinds left.
    """
    low, corridor, high = depths
    depth = low + corridor + high
    if rng.random() >= chance:
        return [], kinds
    kinds = [kind for kind in kinds if kind != "living room"]
    second = next((kind for kind in ("dining room", "kitchen") if kind in kinds), None)
    if second is None or len(kinds) < 4:
        width = rng.uniform(3.6, 4.6)
        return [PlanRoom("living room", (Rect(-width, 0.0, 0.0, depth),))], kinds
    kinds.remove(second)
    width, cut = rng.uniform(3.9, 5.2), low - rng.uniform(0.0, 0.5)
    if rng.random() < 0.5:
        cut = low + corridor + rng.uniform(0.0, 0.5)
        parts = Rect(-width, 0.0, 0.0, cut), Rect(-width, cut, 0.0, depth)
    else:
        parts = Rect(-width, cut, 0.0, depth), Rect(-width, 0.0, 0.0, cut)
    return [PlanRoom("living room", parts[:1]), PlanRoom(second, parts[1:])], kinds


def _halves(rng: random.Random, kinds: list[str]) -> tuple[list[str], list[str]]:
    """The rooms in two strips that ask for about the same length."""
    lower: list[str] = []
    upper: list[str] = []
    for kind in sorted(kinds, key=lambda kind: (-WIDTH_M[kind], rng.random())):
        (lower if _asked(lower) <= _asked(upper) else upper).append(kind)
    rng.shuffle(lower)
    rng.shuffle(upper)
    return lower, upper


def _asked(kinds: Sequence[str]) -> float:
    return sum(WIDTH_M[kind] for kind in kinds)


def _strip(rng: random.Random, kinds: Sequence[str], strip: Rect) -> list[PlanRoom]:
    """The rooms side by side along the strip's longer side; bathrooms keep their width."""
    along = strip.width >= strip.depth or len(kinds) == 1
    length = strip.width if along else strip.depth
    asked = [WIDTH_M[kind] * rng.uniform(0.85, 1.15) for kind in kinds]
    firm = sum(w for w, kind in zip(asked, kinds, strict=True) if kind == "bathroom")
    others = sum(asked) - firm
    scale = (length - firm) / others if others else 1.0
    rooms, at = [], 0.0
    for i, (kind, width) in enumerate(zip(kinds, asked, strict=True)):
        end = at + (width if kind == "bathroom" and others else width * scale)
        end = length if i == len(kinds) - 1 else end
        rect = (
            Rect(strip.x0 + at, strip.y0, strip.x0 + end, strip.y1)
            if along
            else Rect(strip.x0, strip.y0 + at, strip.x1, strip.y0 + end)
        )
        rooms.append(PlanRoom(kind, (rect,)))
        at = end
    return rooms


def _split(rng: random.Random, cell: Rect) -> tuple[Rect, Rect]:
    at = rng.uniform(0.36, 0.64)
    if cell.width >= cell.depth:
        x = cell.x0 + cell.width * at
        return Rect(cell.x0, cell.y0, x, cell.y1), Rect(x, cell.y0, cell.x1, cell.y1)
    y = cell.y0 + cell.depth * at
    return Rect(cell.x0, cell.y0, cell.x1, y), Rect(cell.x0, y, cell.x1, cell.y1)
