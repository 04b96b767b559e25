"""Floor plans for generated homes: a rectangle split into rooms, with doors between them."""

import random
from dataclasses import dataclass

from hil_sim.scene import Door, Wall

OUTER_M, INNER_M = 0.2, 0.12
DOOR_END_M = 0.3
"""Wall left standing between a door and a corner."""

ROOM_WEIGHTS = {
    "living room": 1.0,
    "kitchen": 1.0,
    "bedroom": 0.9,
    "study": 0.8,
    "dining room": 0.55,
}
"""How likely a home has a room of that type; the smallest room is always a bathroom."""


@dataclass(frozen=True)
class Rect:
    """An axis-aligned rectangle in the scene frame, metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width(self) -> float:
        return self.x1 - self.x0

    @property
    def depth(self) -> float:
        return self.y1 - self.y0

    @property
    def area(self) -> float:
        return self.width * self.depth

    def touches(self, x: float, y: float, slack: float = 0.02) -> bool:
        """Whether the point lies in the rectangle or on its edge."""
        return self.x0 - slack <= x <= self.x1 + slack and self.y0 - slack <= y <= self.y1 + slack

    def inset(self, by: float) -> "Rect":
        return Rect(self.x0 + by, self.y0 + by, self.x1 - by, self.y1 - by)


@dataclass(frozen=True)
class Plan:
    """Rooms as (type, rectangle up to the walls' centre lines), walls and doors."""

    rooms: tuple[tuple[str, Rect], ...]
    walls: tuple[Wall, ...]
    doors: tuple[Door, ...]


def draw_plan(rng: random.Random, rooms: int) -> Plan:
    """A rectangular home of about 14 m² a room, all rooms reachable through doors."""
    area = rooms * rng.uniform(11.0, 17.0)
    width = (area * rng.uniform(0.8, 1.5)) ** 0.5
    home = Rect(0.0, 0.0, round(width, 2), round(area / width, 2))
    cells, walls = [home], _outer_walls(home)
    corridor: Rect | None = None
    if rooms >= 4 and rng.random() < 0.5:
        cells, corridor, walls = _with_corridor(rng, home, walls)
    while len(cells) + (corridor is not None) < rooms:
        cells.sort(key=lambda cell: cell.area)
        first, second, wall = _split(rng, cells.pop())
        cells += [first, second]
        walls.append(wall)
    named = _name_rooms(rng, cells)
    if corridor is not None:
        named.append(("hallway", corridor))
    return Plan(tuple(named), tuple(walls), tuple(_doors(rng, named)))


def _outer_walls(home: Rect) -> list[Wall]:
    corners = [
        (home.x0, home.y0),
        (home.x1, home.y0),
        (home.x1, home.y1),
        (home.x0, home.y1),
    ]
    pairs = zip(corners, corners[1:] + corners[:1], strict=True)
    return [Wall(start, end, OUTER_M, "outer") for start, end in pairs]


def _with_corridor(
    rng: random.Random, home: Rect, walls: list[Wall]
) -> tuple[list[Rect], Rect, list[Wall]]:
    half, middle = rng.uniform(0.65, 0.9), rng.uniform(0.4, 0.6)
    if home.width >= home.depth:
        y = home.y0 + home.depth * middle
        parts = [
            Rect(home.x0, home.y0, home.x1, y - half),
            Rect(home.x0, y + half, home.x1, home.y1),
        ]
        corridor = Rect(home.x0, y - half, home.x1, y + half)
        lines = [((home.x0, v), (home.x1, v)) for v in (y - half, y + half)]
    else:
        x = home.x0 + home.width * middle
        parts = [
            Rect(home.x0, home.y0, x - half, home.y1),
            Rect(x + half, home.y0, home.x1, home.y1),
        ]
        corridor = Rect(x - half, home.y0, x + half, home.y1)
        lines = [((v, home.y0), (v, home.y1)) for v in (x - half, x + half)]
    return parts, corridor, walls + [Wall(a, b, INNER_M) for a, b in lines]


def _split(rng: random.Random, cell: Rect) -> tuple[Rect, Rect, Wall]:
    at = rng.uniform(0.38, 0.62)
    if cell.width >= cell.depth:
        x = cell.x0 + cell.width * at
        wall = Wall((x, cell.y0), (x, cell.y1), INNER_M)
        return Rect(cell.x0, cell.y0, x, cell.y1), Rect(x, cell.y0, cell.x1, cell.y1), wall
    y = cell.y0 + cell.depth * at
    wall = Wall((cell.x0, y), (cell.x1, y), INNER_M)
    return Rect(cell.x0, cell.y0, cell.x1, y), Rect(cell.x0, y, cell.x1, cell.y1), wall


def _name_rooms(rng: random.Random, cells: list[Rect]) -> list[tuple[str, Rect]]:
    """The smallest room becomes the bathroom, the largest mostly the living room."""
    by_area = sorted(cells, key=lambda cell: cell.area)
    order = sorted(ROOM_WEIGHTS, key=lambda kind: rng.random() ** (1 / ROOM_WEIGHTS[kind]))[::-1]
    types = (order + ["bedroom"] * len(cells))[: len(cells) - 1]
    if "living room" in types and rng.random() < 0.7:
        types.remove("living room")
        types.append("living room")
    return list(zip(["bathroom", *types], by_area, strict=True))


def _doors(rng: random.Random, rooms: list[tuple[str, Rect]]) -> list[Door]:
    """Doors along a random spanning tree of adjacent rooms, and a few more."""
    edges = []
    for i, (kind_a, a) in enumerate(rooms):
        for j, (kind_b, b) in enumerate(rooms[:i]):
            if (shared := _shared(a, b)) is not None:
                bonus = -1.0 if "hallway" in (kind_a, kind_b) else 0.0
                bonus += 0.6 if "bathroom" in (kind_a, kind_b) else 0.0
                edges.append((rng.random() + bonus, j, i, shared))
    group = list(range(len(rooms)))
    doors = []
    for _, i, j, (start, end) in sorted(edges):
        joined = group[i] == group[j]
        wet = "bathroom" in (rooms[i][0], rooms[j][0])
        if joined and (wet or rng.random() > 0.3):
            continue
        group = [group[i] if g == group[j] else g for g in group]
        doors.append(_door(rng, start, end, open_plan=not wet and rng.random() < 0.2))
    return doors


def _shared(
    a: Rect, b: Rect, least: float = 1.65
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    for x in {a.x0, a.x1} & {b.x0, b.x1}:
        y0, y1 = max(a.y0, b.y0), min(a.y1, b.y1)
        if y1 - y0 >= least:
            return (x, y0), (x, y1)
    for y in {a.y0, a.y1} & {b.y0, b.y1}:
        x0, x1 = max(a.x0, b.x0), min(a.x1, b.x1)
        if x1 - x0 >= least:
            return (x0, y), (x1, y)
    return None


def _door(
    rng: random.Random, start: tuple[float, float], end: tuple[float, float], open_plan: bool
) -> Door:
    length = abs(end[0] - start[0]) + abs(end[1] - start[1])
    width = rng.uniform(0.85, 1.0)
    if open_plan and length > 2.6:
        width = rng.uniform(1.3, min(2.2, length - 1.0))
    low, high = DOOR_END_M + width / 2, length - DOOR_END_M - width / 2
    # Most doors stand near a corner, which leaves a wall for furniture.
    middle = rng.choice([low, high]) if rng.random() < 0.6 else rng.uniform(low, high)
    ux, uy = (end[0] - start[0]) / length, (end[1] - start[1]) / length
    ends = [
        (round(start[0] + ux * t, 3), round(start[1] + uy * t, 3))
        for t in (middle - width / 2, middle + width / 2)
    ]
    height = 2.05 if width < 1.1 else rng.choice([2.05, 2.3])
    return Door(ends[0], ends[1], height)
