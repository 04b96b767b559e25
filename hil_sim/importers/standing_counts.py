"""What stands in which room, and what near what, counted for the experts: makes
`models/words/counts.json`.

Two sets of homes are counted, each by itself: 120 single rooms of iTHOR that people furnished (see
`placement_stats`), and generated train homes, which have the room types and the doors that those
lack. No home that anything is judged by is among them.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from hil_sim.ground_truth.labels import LABELLED
from hil_sim.importers.placement_stats import Rect, read_room
from hil_sim.scenes.format import ROOM_TYPES, Door, Scene, room_at
from hil_sim.scenes.furniture.boxes import box_of
from hil_sim.scenes.open import open_scene
from hil_sim.scenes.robothor import metadata

FIRST_SEED = 900_000
"""Of the generated homes: no bank, views, frames or suite has these."""
NEAR_M = 2.5
"""What is nearer than this in the same room, rectangle to rectangle, is near."""
OTHER_NAMES = {"counter": "cabinet"}
"""Categories of iTHOR's rooms that scenes call otherwise."""
ACROSS_M = 0.5
"""From a door's middle to a point in each of the two rooms that it joins."""

Thing = tuple[str, Rect]


@dataclass
class HomeCounts:
    """Counts as they grow; see `runtime.core.voting.counts.Count`."""

    rooms: Counter[str] = field(default_factory=Counter)
    holding: Counter[tuple[str, str]] = field(default_factory=Counter)  # thing, room type
    things: Counter[str] = field(default_factory=Counter)
    beside: Counter[tuple[str, str]] = field(default_factory=Counter)  # thing, the other
    doors: Counter[tuple[str, str]] = field(default_factory=Counter)  # room type, the other

    def add_room(self, kind: str, things: Sequence[Thing]) -> None:
        """One room and what stands in it."""
        self.rooms[kind] += 1
        self.holding.update((name, kind) for name in {name for name, _ in things})
        for n, (name, rect) in enumerate(things):
            self.things[name] += 1
            near = {
                other
                for m, (other, there) in enumerate(things)
                if m != n and _gap(rect, there) <= NEAR_M
            }
            self.beside.update((name, other) for other in near)

    def add_door(self, kind: str, other: str) -> None:
        """A door between two rooms, which is one of each."""
        self.doors.update(((kind, other), (other, kind)))

    def packed(self, names: Sequence[str]) -> dict[str, Any]:
        """As the file has it: rows in the order of `names`, columns of that or of ROOM_TYPES."""
        return {
            "rooms": [self.rooms[room] for room in ROOM_TYPES],
            "things": [self.things[name] for name in names],
            "holding": [[self.holding[name, room] for room in ROOM_TYPES] for name in names],
            "beside": [[self.beside[name, other] for other in names] for name in names],
            "doors": [[self.doors[room, other] for other in ROOM_TYPES] for room in ROOM_TYPES],
        }


def public_rooms() -> HomeCounts:
    """The 120 single rooms."""
    counts = HomeCounts()
    for kind in metadata.ROOM_LISTS:
        for room in metadata.rooms(kind):
            standing, _ = read_room(room)
            named = [(OTHER_NAMES.get(s.category, s.category), s.rect) for s in standing]
            counts.add_room(kind, [row for row in named if row[0] in LABELLED])
    return counts


def generated_homes(homes: Iterable[Scene]) -> HomeCounts:
    """Homes whose rooms have types and whose doors lie between two of them."""
    counts = HomeCounts()
    for scene in homes:
        inside: dict[str, list[Thing]] = {room.name: [] for room in scene.rooms}
        for obj in scene.objects:
            room = room_at(scene, *obj.position_m[:2])
            if room is not None and obj.category in LABELLED:
                inside[room.name].append((obj.category, box_of(obj).span))
        for room in scene.rooms:
            counts.add_room(room.type, inside[room.name])
        for door in scene.doors:
            joined = [room.type for point in _sides(door) if (room := room_at(scene, *point))]
            if len(joined) == 2:
                counts.add_door(*joined)
    return counts


def train_homes(count: int) -> Iterator[Scene]:
    """Generated ones that nothing is judged by."""
    return (open_scene(f"train-{FIRST_SEED + n}") for n in range(count))


def counted(scenes: Iterable[Scene], homes: int) -> dict[str, Any]:
    """The whole content of counts.json; `scenes` are `train_homes(homes)`."""
    public, generated = public_rooms(), generated_homes(scenes)
    names = [name for name in LABELLED if public.things[name] or generated.things[name]]
    return {
        "source": {
            "public": "30 kitchens, living rooms, bedrooms and bathrooms each of iTHOR, by the "
            "object metadata in the PyPI wheel procthor 0.0.1.dev2, Apache-2.0",
            "generated": f"homes train-{FIRST_SEED} to train-{FIRST_SEED + homes - 1}",
            "near_m": NEAR_M,
            "made_by": f"hil-sim counts --homes {homes}",
        },
        "names": names,
        "rooms": list(ROOM_TYPES),
        "counts": {"public": public.packed(names), "generated": generated.packed(names)},
    }


def _sides(door: Door) -> tuple[tuple[float, float], tuple[float, float]]:
    (x0, y0), (x1, y1) = door.start, door.end
    length = math.hypot(x1 - x0, y1 - y0)
    u, v = -(y1 - y0) / length * ACROSS_M, (x1 - x0) / length * ACROSS_M
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    return (x + u, y + v), (x - u, y - v)


def _gap(a: Rect, b: Rect) -> float:
    dx = max(a[0] - b[2], b[0] - a[2], 0.0)
    dy = max(a[1] - b[3], b[1] - a[3], 0.0)
    return math.hypot(dx, dy)
