"""Doors of a floor plan: every room reachable, no bathroom on the way to another room."""

import random
from collections.abc import Sequence

from hil_sim.scenes.format import Door
from hil_sim.scenes.generated.floorplan import PlanRoom, on_line, shared

END_M = 0.25
"""Wall left standing between a door and a corner."""
WIDTH_M = (0.8, 1.0)
OPENING_M = (1.3, 2.4)
LEAST_SHARED_M = 1.25
PUBLIC = ("living room", "dining room", "kitchen", "hallway")
OPEN = 0.4
"""Share of the passages between public rooms that are wide openings."""
LOOP = 0.3
"""Share of further doors between public rooms, so that there is more than one way."""

Line = tuple[str, float, float, float]


def draw_doors(rng: random.Random, rooms: Sequence[PlanRoom]) -> tuple[Door, ...] | None:
    """Doors that connect all rooms, None if these rooms cannot be."""
    edges = [
        (_reluctance(rooms[i].kind, rooms[j].kind) + rng.random(), i, j, line)
        for i in range(len(rooms))
        for j in range(i)
        if (line := _longest_shared(rooms[i], rooms[j])) is not None
    ]
    start = min(range(len(rooms)), key=lambda i: (_rank(rooms[i].kind), i))
    tree, seen = [], {start}
    while len(seen) < len(rooms):
        steps = [edge for edge in edges if _leads_on(rooms, seen, edge)]
        if not steps:
            return None
        edge = min(steps)
        seen |= {edge[1], edge[2]}
        tree.append(edge)
    for edge in edges:
        kinds = {rooms[edge[1]].kind, rooms[edge[2]].kind}
        if edge not in tree and kinds <= set(PUBLIC) and rng.random() < LOOP:
            tree.append(edge)
    return tuple(_door(rng, rooms[i].kind, rooms[j].kind, line) for _, i, j, line in sorted(tree))


def _rank(kind: str) -> int:
    """Where the tree of rooms starts: the hallway, else the living room."""
    return {"hallway": 0, "living room": 1}.get(kind, 2)


def _reluctance(a: str, b: str) -> float:
    """How much rather not a door between rooms of these types; below 1 is usual."""
    pair = {a, b}
    if "hallway" in pair:
        return 0.0
    if "bathroom" in pair:
        return 0.25 if "bedroom" in pair else 3.0 if "kitchen" in pair else 1.2
    if pair <= set(PUBLIC):
        return 0.3
    if "living room" in pair:
        return 0.5
    return 2.5 if "bedroom" in pair else 1.2


def _leads_on(
    rooms: Sequence[PlanRoom], seen: set[int], edge: tuple[float, int, int, Line]
) -> bool:
    """Whether the door leads from a room already reached, no bathroom, into a new one."""
    _, i, j, _ = edge
    if (i in seen) == (j in seen):
        return False
    return rooms[i if i in seen else j].kind != "bathroom"


def _longest_shared(a: PlanRoom, b: PlanRoom) -> Line | None:
    lines = [shared(p, q, LEAST_SHARED_M) for p in a.rects for q in b.rects]
    return max(
        (line for line in lines if line), key=lambda line: (line[3] - line[2], line), default=None
    )


def _door(rng: random.Random, kind_a: str, kind_b: str, line: Line) -> Door:
    axis, at, low, high = line
    length, width = high - low, rng.uniform(*WIDTH_M)
    if {kind_a, kind_b} <= set(PUBLIC) and length > 2.0 and rng.random() < OPEN:
        width = rng.uniform(OPENING_M[0], min(OPENING_M[1], length - 2 * END_M))
    first, last = low + END_M + width / 2, high - END_M - width / 2
    # Most doors stand near a corner, which leaves a wall for furniture.
    middle = rng.choice((first, last)) if rng.random() < 0.6 else rng.uniform(first, last)
    start, end = round(middle - width / 2, 3), round(middle + width / 2, 3)
    height = 2.05 if width < 1.1 else rng.choice((2.05, 2.3))
    return Door(on_line(axis, at, start), on_line(axis, at, end), height)
