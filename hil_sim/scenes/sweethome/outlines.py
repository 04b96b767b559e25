"""Where a storey's rooms are, and what they are called: by their names, or by texts in them."""

import math
from dataclasses import dataclass

from hil_sim.scenes.format import Polygon, Wall, contains, polygon_area
from hil_sim.scenes.sweethome.drawing import DrawnRoom, DrawnText, usable
from hil_sim.scenes.sweethome.plan import hull, to_middles, undrawn_rooms
from hil_sim.scenes.sweethome.storey import LARGEST_M, Storey
from hil_sim.scenes.sweethome.words import is_outdoors, tells


@dataclass(frozen=True)
class Outline:
    """A room, up to the walls' middles. `texts` stand in it and tell what its name does not: what
    it is for, or that it lies outdoors. `room` is None where none was drawn."""

    polygon: Polygon
    texts: tuple[str, ...]
    room: DrawnRoom | None

    @property
    def name(self) -> str:
        """As the drawing names it, else the first text in it that tells; "" if nothing does."""
        own = self.room.name if self.room else ""
        return own or next(iter(self.texts), "")


def outlines(storey: Storey, walls: list[Wall], notes: list[str]) -> list[Outline]:
    """Each drawn room's outline, moved to the walls' middles, and outlines where none was drawn.
    `notes` hears of what is left out and of what is made."""
    rooms = [room for room in storey.rooms if _fit(room, storey, notes)]
    shapes = [room.polygon for room in rooms]
    drawn = [
        Outline(to_middles(room.polygon, walls), () if tells(room.name) else texts, room)
        for room, texts in zip(rooms, _telling(storey.texts, shapes), strict=True)
    ]
    found = [outline for outline in drawn if _indoors(outline, notes)]
    bare = undrawn_rooms(walls, [outline.polygon for outline in found])
    if bare:
        notes.append(f"{len(bare)} enclosed without a drawn room: made from the walls")
    elif not found:
        notes.append("no room is drawn and the walls enclose none: one room around all walls")
        return _around(storey, walls)
    made = [
        Outline(shape, texts, None)
        for shape, texts in zip(bare, _telling(storey.texts, bare), strict=True)
    ]
    return found + [outline for outline in made if _indoors(outline, notes)]


def _around(storey: Storey, walls: list[Wall]) -> list[Outline]:
    """One room around all walls; a terrace that is also in it does not make it lie outdoors."""
    whole = hull(walls)
    if not whole:
        return []
    texts = _telling(storey.texts, [whole])[0]
    return [Outline(whole, tuple(text for text in texts if not is_outdoors(text)), None)]


def _fit(room: DrawnRoom, storey: Storey, notes: list[str]) -> bool:
    why = ""
    if not usable(room):
        why = "it has no area"
    elif max(math.dist(p, storey.walls[0].start) for p in room.polygon) > LARGEST_M:
        why = f"it lies more than {LARGEST_M:.0f} m away"
    if why:
        notes.append(f"{room.place} ({room.name or 'unnamed'}): left out: {why}")
    return not why


def _telling(texts: tuple[DrawnText, ...], shapes: list[Polygon]) -> list[tuple[str, ...]]:
    """For each outline those texts that tell and stand in it, and in none that is smaller; those
    that tell what it is for before those that say that it lies outdoors."""
    found: list[list[str]] = [[] for _ in shapes]
    for text in texts:
        around = [i for i, shape in enumerate(shapes) if contains(shape, *text.position_m)]
        if around and tells(text.text):
            found[min(around, key=lambda i: polygon_area(shapes[i]))].append(text.text)
    return [tuple(sorted(inside, key=is_outdoors)) for inside in found]


def _indoors(outline: Outline, notes: list[str]) -> bool:
    own = outline.room.name if outline.room else ""
    text = next(iter(outline.texts), "")
    if not is_outdoors(text or own):
        return True
    place = outline.room.place if outline.room else "what the walls enclose"
    what = f"the text {text!r} in it" if text else "its name"
    notes.append(f"{place} ({own or 'unnamed'}): left out: {what} says that it lies outdoors")
    return False
