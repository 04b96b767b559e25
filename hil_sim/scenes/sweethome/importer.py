"""A drawing -> a scene, and what was done with each of its parts."""

import json
import math
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hil_sim.scenes.format import (
    Door,
    Polygon,
    Room,
    Scene,
    SceneError,
    SceneObject,
    Wall,
    contains,
)
from hil_sim.scenes.scene_file import parse_scene, scene_to_json
from hil_sim.scenes.sweethome.archive import Archive
from hil_sim.scenes.sweethome.drawing import DrawnWall, read_drawing
from hil_sim.scenes.sweethome.models import PLAIN, Models
from hil_sim.scenes.sweethome.openings import doorway
from hil_sim.scenes.sweethome.outlines import Outline, outlines
from hil_sim.scenes.sweethome.plan import (
    Side,
    beside,
    is_inner,
    room_index,
    straight,
)
from hil_sim.scenes.sweethome.storey import Storey, check_extent, pick_storey
from hil_sim.scenes.sweethome.words import category_of, room_type

LOW_WALL = 0.7
"""Walls lower than this share of the home's height become pieces of furnishing."""


@dataclass
class Report:
    """What became of the drawing: counts, and a line for each thing that needs a person's eye."""

    counts: dict[str, int] = field(default_factory=dict)
    categories: dict[str, int] = field(default_factory=dict)
    rooms: dict[str, str] = field(default_factory=dict)
    """Name -> type."""
    notes: list[str] = field(default_factory=list)


def import_home(
    path: Path, out: Path, level: str | None = None, known: frozenset[str] = frozenset()
) -> tuple[Scene, Report]:
    """Read a `.sh3d`, write its models below `out`, and return the scene (not yet written).

    `level`: a storey's name, None for that with rooms nearest the ground; `known`: catalogue ids in
    the cache. SceneError is one line that names the file and the place.
    """
    report = Report()
    with Archive(path) as archive:
        label = f"{path}: Home.xml"
        drawing = read_drawing(archive.home_xml(), label)
        storey = pick_storey(drawing, level, label, report.notes)
        models = Models(archive, out, known)
        scene = _scene(path.stem or "home", storey, models, label, report)
    report.notes += models.boxed
    if drawing.hidden:
        report.counts["hidden pieces left out"] = drawing.hidden
    parse_scene(json.loads(json.dumps(scene_to_json(scene))), label)
    return scene, report


def _scene(name: str, storey: Storey, models: Models, label: str, report: Report) -> Scene:
    sides, low = _walls(storey, report)
    if not sides:
        raise SceneError(f"{label}: wall: none on this level; draw the home's walls")
    walls = [side.wall for side in sides]
    check_extent(storey, label)
    found = outlines(storey, walls, report.notes)
    if not found:
        raise SceneError(f"{label}: room: none on this level is indoors; draw one, or rename it")
    polygons = [outline.polygon for outline in found]
    doors = _doors(storey, walls, polygons, report)
    objects = _objects(storey, polygons, models, report)
    objects += _low_walls(low, models, len(objects))
    report.categories = dict(sorted(Counter(obj.category for obj in objects).items()))
    walls = [replace(w, kind="inner" if is_inner(w, polygons) else "outer") for w in walls]
    rooms = _rooms(found, objects, sides, models, report)
    counts = {"walls": len(walls), "rooms": len(rooms), "doors": len(doors), "pieces": len(objects)}
    report.counts = {**counts, **report.counts}
    return Scene(name, tuple(walls), doors, rooms, tuple(objects), tuple(polygons), storey.height_m)


def _walls(storey: Storey, report: Report) -> tuple[list[Side], list[DrawnWall]]:
    """The straight walls, and those too low to be walls."""
    sides: list[Side] = []
    low: list[DrawnWall] = []
    for drawn in storey.walls:
        parts = straight(drawn)
        if not parts:
            x, y = drawn.start
            report.notes.append(f"{drawn.place}: left out: zero length at ({x:.2f}, {y:.2f}) m")
        elif drawn.height_m is not None and drawn.height_m < LOW_WALL * storey.height_m:
            low.append(drawn)
        else:
            sides += parts
    return sides, low


def _doors(
    storey: Storey,
    walls: list[Wall],
    polygons: list[Polygon],
    report: Report,
) -> tuple[Door, ...]:
    doors: list[Door] = []
    windows = 0
    for piece in storey.pieces:
        if piece.opening is None:
            continue
        way = doorway(piece, walls, polygons, storey.height_m)
        doors += way.doors
        windows += way.shut == "window"
        if way.shut == "outside":
            report.notes.append(f"{piece.place}: kept shut: it leads out of the rooms")
        elif way.shut == "no wall":
            report.notes.append(f"{piece.place}: left out: it stands in no wall")
    report.counts["windows left out"] = windows
    return tuple(doors)


def _objects(
    storey: Storey, polygons: list[Polygon], models: Models, report: Report
) -> list[SceneObject]:
    found: list[SceneObject] = []
    unknown: Counter[str] = Counter()
    outside = 0
    for piece in storey.pieces:
        x, y, z = piece.position_m
        if piece.opening is not None or "LightSource" in piece.catalog_id:
            continue
        if room_index(polygons, (x, y)) is None:
            outside += 1
            continue
        category = category_of(piece.catalog_id, piece.name)
        if category == "other":
            unknown[piece.name or piece.catalog_id or "unnamed"] += 1
        mesh, size = models.mesh(piece)
        position = (round(x, 4), round(y, 4), round(z, 4))
        size = (round(size[0], 4), round(size[1], 4), round(size[2], 4))
        id = f"{category.replace(' ', '-')}-{len(found)}"
        found.append(SceneObject(id, category, mesh, position, round(piece.yaw_rad, 5), size))
    if outside:
        report.counts["pieces outside the rooms left out"] = outside
    if unknown:
        names = ", ".join(f"{n} x {name}" if n > 1 else name for name, n in unknown.most_common(12))
        report.notes.append(f"drawn but never labelled (not one of our categories): {names}")
    return found


def _low_walls(low: list[DrawnWall], models: Models, count: int) -> list[SceneObject]:
    """Walls that one looks over, as cuboids."""
    found: list[SceneObject] = []
    for drawn in low:
        for side in straight(drawn):
            (x0, y0), (x1, y1) = side.wall.start, side.wall.end
            size = (
                math.dist(side.wall.start, side.wall.end) + drawn.thickness_m,
                drawn.thickness_m,
                max(drawn.height_m or 0.0, 0.01),
            )
            found.append(
                SceneObject(
                    f"low-wall-{count + len(found)}", "other", models.box(drawn.left or PLAIN),
                    ((x0 + x1) / 2, (y0 + y1) / 2, 0.0), math.atan2(y1 - y0, x1 - x0), size,
                )
            )  # fmt: skip
    return found


def _rooms(
    found: list[Outline],
    objects: list[SceneObject],
    sides: list[Side],
    models: Models,
    report: Report,
) -> tuple[Room, ...]:
    rooms: list[Room] = []
    for outline in found:
        polygon, drawn = outline.polygon, outline.room
        inside = [obj.category for obj in objects if contains(polygon, *obj.position_m[:2])]
        text = next(iter(outline.texts), "")
        kind, how = room_type(text or outline.name, inside)
        name = _unused(outline.name or kind, [room.name for room in rooms])
        if text:
            others = "".join(f"; also in it: {other!r}" for other in outline.texts[1:])
            report.notes.append(f"room {name!r}: a {kind} by the text {text!r} in it{others}")
        if how == "furniture":
            report.notes.append(f"room {name!r}: taken for a {kind} by its furniture")
        elif how == "guess":
            report.notes.append(
                f"room {name!r}: neither name nor furniture tell; taken for a {kind}"
            )
        floor = None
        if drawn:
            floor = drawn.floor or models.texture_colour(drawn.texture)
        rooms.append(Room(name, kind, _rounded(polygon), floor, _wall_colour(polygon, sides)))
        report.rooms[name] = kind
    return tuple(rooms)


def _unused(name: str, taken: list[str]) -> str:
    numbered = (f"{name} {n}" for n in range(2, len(taken) + 3))
    return name if name not in taken else next(n for n in numbered if n not in taken)


def _rounded(polygon: Polygon) -> Polygon:
    return tuple((round(x, 4), round(y, 4)) for x, y in polygon)


def _wall_colour(polygon: Polygon, sides: list[Side]) -> str | None:
    """The colour that most of the room's walls have on the side that faces it."""
    length: Counter[str] = Counter()
    for side in sides:
        for colour, across in ((side.left, 0.1), (side.right, -0.1)):
            if contains(polygon, *beside(side.wall, 0.5, across)):
                metres = np.hypot(*np.subtract(side.wall.end, side.wall.start))
                length[colour or ""] += int(1000 * metres)
    best = length.most_common(1)
    return best[0][0] or None if best else None
