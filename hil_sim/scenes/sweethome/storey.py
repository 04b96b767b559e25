"""Which storey of a drawing is imported."""

import math
from dataclasses import dataclass

from hil_sim.scenes.format import SceneError
from hil_sim.scenes.sweethome.drawing import (
    Drawing,
    Drawn,
    DrawnRoom,
    DrawnText,
    DrawnWall,
    Level,
    usable,
)
from hil_sim.scenes.sweethome.words import is_outdoors

LARGEST_M = 100.0
SAME_FLOOR_M = 0.05


@dataclass(frozen=True)
class Storey:
    """What of the drawing is on the storey that is imported."""

    walls: tuple[DrawnWall, ...]
    rooms: tuple[DrawnRoom, ...]
    pieces: tuple[Drawn, ...]
    texts: tuple[DrawnText, ...]
    height_m: float


def pick_storey(drawing: Drawing, name: str | None, label: str, notes: list[str]) -> Storey:
    """The named storey, or of those with walls and, where there are any, rooms, the one whose floor
    is nearest to 0.

    Levels on the same height are one storey. `notes` hears of what is left out."""
    height = drawing.wall_height_m
    if not drawing.levels:
        if name is not None:
            raise SceneError(f"{label}: level {name!r}: the drawing has no levels")
        return Storey(drawing.walls, drawing.rooms, drawing.pieces, drawing.texts, height)
    chosen = _level(drawing, name, label)
    here = {level.id for level in _beside(chosen, drawing.levels)}
    if len(here) < len(drawing.levels):
        others = sorted({level.name for level in drawing.levels if level.id not in here})
        notes.append(
            f"level {chosen.name!r} is imported; others are not: {', '.join(others)} (see --level)"
        )
    return Storey(
        tuple(wall for wall in drawing.walls if wall.level in here),
        tuple(room for room in drawing.rooms if room.level in here),
        tuple(piece for piece in drawing.pieces if piece.level in here),
        tuple(text for text in drawing.texts if text.level in here),
        chosen.height_m if chosen.height_m > 1 else height,
    )


def _level(drawing: Drawing, name: str | None, label: str) -> Level:
    levels = drawing.levels
    if name is not None:
        found = [level for level in levels if level.name == name]
        if not found:
            known = ", ".join(repr(level.name) for level in levels)
            raise SceneError(f"{label}: level {name!r}: no such level; there are: {known}")
        return found[0]
    walled = {wall.level for wall in drawing.walls}
    roomy = {r.level for r in drawing.rooms if usable(r) and not is_outdoors(r.name)}
    candidates = [level for level in levels if level.id in walled] or list(levels)
    lived_in = [c for c in candidates if any(o.id in roomy for o in _beside(c, levels))]
    return min(lived_in or candidates, key=lambda level: abs(level.elevation_m))


def _beside(level: Level, levels: tuple[Level, ...]) -> list[Level]:
    """The levels of the same storey."""
    return [o for o in levels if abs(o.elevation_m - level.elevation_m) <= SAME_FLOOR_M]


def check_extent(storey: Storey, label: str) -> None:
    """SceneError when the walls lie further apart than a home is wide."""
    for wall in storey.walls:
        for mine, at in ((wall.start, "Start"), (wall.end, "End")):
            far = math.dist(mine, storey.walls[0].start)
            if far > LARGEST_M:
                raise SceneError(
                    f"{label}: {wall.place}: x{at}, y{at}: {far:.0f} m from the first wall; a home "
                    f"may be {LARGEST_M:.0f} m wide"
                )
