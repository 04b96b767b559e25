"""Scenes: furnished homes as data, in one JSON format (`rf-nav-scene/1`).

Scene frame: metres, x right and y up on the plan, z up, yaw counter-clockwise from x.
An object's front looks along its local -y before yaw is applied.
"""

import difflib
import json
import math
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from runtime.errors import RfNavError

FORMAT = "rf-nav-scene/1"
ROOM_TYPES = (
    "kitchen",
    "bathroom",
    "bedroom",
    "living room",
    "dining room",
    "study",
    "hallway",
)
CATEGORIES = (
    "bed", "sofa", "chair", "armchair", "table", "coffee table", "desk", "toilet", "bathtub",
    "shower", "sink", "refrigerator", "stove", "microwave", "television", "plant", "laptop",
    "wardrobe", "bookcase", "cabinet", "nightstand", "dresser", "lamp", "washing machine",
    "stool", "trash can", "vase", "clock", "radiator", "piano", "fireplace", "mirror",
    "picture", "alarm clock", "apple", "baseball bat", "basketball", "bowl", "mug",
    "spray bottle", "pillow", "statue", "bottle", "cup", "remote control", "cell phone",
    "pencil", "pen", "box", "book", "plate", "pot", "pan", "candle", "tennis racket",
    "newspaper", "teddy bear", "salt shaker", "pepper shaker", "watch", "cd", "fork",
    "butter knife", "knife", "spoon", "tv stand", "side table", "shelving unit", "shelf",
    "toaster", "coffee machine", "kettle", "teapot", "dishwasher", "bread", "tomato", "lettuce",
    "potato", "egg", "soap bottle", "toilet paper", "paper towel", "towel", "plunger",
    "tissue box", "curtain", "desk lamp", "floor lamp", "ottoman", "bench", "safe",
    "laundry basket", "dumbbell", "vacuum cleaner", "dog bed", "watering can", "boots",
    "garbage bag", "suitcase", "backpack", "guitar", "printer", "computer monitor", "speaker",
    "wine bottle", "wine glass", "aquarium", "clothes rack", "drying rack", "toy", "rug", "fan",
    "radio", "blender", "soccer ball", "umbrella", "keyboard", "broom", "bucket", "game console",
    "door", "other",
)  # fmt: skip
"""`other` is furnishing that no goal names: it is drawn and collided with, never labelled."""
SCENES_DIR = Path(__file__).parent
ON_WALL_M = 0.05
"""How far a door may lie off a wall's centre line."""

Point = tuple[float, float]
Polygon = tuple[Point, ...]


class SceneError(RfNavError):
    """A scene that is unknown or cannot be used."""


@dataclass(frozen=True)
class Wall:
    """A wall along its centre line. `kind` is "outer" or "inner"."""

    start: Point
    end: Point
    thickness_m: float = 0.12
    kind: str = "inner"


@dataclass(frozen=True)
class Door:
    """An opening that lies on a wall's centre line, from the floor up to `height_m`."""

    start: Point
    end: Point
    height_m: float = 2.05


@dataclass(frozen=True)
class Room:
    """A room's floor; `floor` and `wall` are "#rrggbb" or a texture's name."""

    name: str
    type: str
    polygon: Polygon
    floor: str | None = None
    wall: str | None = None


@dataclass(frozen=True)
class SceneObject:
    """A placed object. `position_m` is the centre of its footprint, z that of its underside.

    `size_m` is width (local x), depth (local y), height; None takes the catalogue's size.
    `tint` "#rrggbb" multiplies the mesh's colours; `paint` takes their place, lighter or darker as
    they are.
    """

    id: str
    category: str
    mesh: str
    position_m: tuple[float, float, float]
    yaw_rad: float = 0.0
    size_m: tuple[float, float, float] | None = None
    tint: str | None = None
    paint: str | None = None


@dataclass(frozen=True)
class Scene:
    name: str
    walls: tuple[Wall, ...]
    doors: tuple[Door, ...]
    rooms: tuple[Room, ...]
    objects: tuple[SceneObject, ...]
    spawn: tuple[Polygon, ...] = ()
    wall_height_m: float = 2.5
    source: Path | None = field(default=None, compare=False)
    """The file it was read from; meshes given by path are relative to its folder."""


def known_scenes() -> tuple[str, ...]:
    """Names of the bundled scenes."""
    return tuple(sorted(path.stem for path in SCENES_DIR.glob("*.json")))


def load_scene(name_or_path: str | Path, meshes: Container[str] | None = None) -> Scene:
    """A bundled scene by name, or any scene by the path of its JSON file.

    `meshes`: the known catalogue ids and "builtin:NAME"s; None leaves meshes unchecked.
    """
    path = Path(name_or_path)
    if path.suffix != ".json":
        path = SCENES_DIR / f"{name_or_path}.json"
        if str(name_or_path) not in known_scenes():
            known = ", ".join(known_scenes())
            raise SceneError(f"scene {name_or_path}: unknown; known: {known}, or a .json file")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise SceneError(f"{path}: no such scene file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: cannot be read: {error}") from None
    except json.JSONDecodeError as error:
        raise SceneError(f"{path}:{error.lineno}: not JSON: {error.msg}") from None
    return parse_scene(data, str(path), meshes, source=path)


def parse_scene(
    data: Any, label: str, meshes: Container[str] | None = None, source: Path | None = None
) -> Scene:
    """Plain JSON data -> a validated Scene; errors start with `label` and the place."""
    top = _Node(data, label, "")
    if top.get("format") != FORMAT:
        top.fail("format", f"is {top.get('format')!r}; this version reads {FORMAT!r}")
    top.only("format", "name", "wall_height_m", "walls", "doors", "rooms", "objects", "spawn")
    scene = Scene(
        name=top.text("name"),
        walls=tuple(_wall(node) for node in top.nodes("walls")),
        doors=tuple(_door(node) for node in top.nodes("doors")),
        rooms=tuple(_room(node) for node in top.nodes("rooms")),
        objects=tuple(_object(node) for node in top.nodes("objects")),
        spawn=tuple(top.polygon_at("spawn", i) for i in range(len(top.get("spawn") or ()))),
        wall_height_m=top.number("wall_height_m", 2.5, above=0.0),
        source=source,
    )
    _check_whole(scene, label)
    if meshes is not None:
        check_meshes(scene, meshes, label)
    return scene


def check_meshes(scene: Scene, meshes: Container[str], label: str | None = None) -> None:
    """Raise SceneError at the first object whose mesh is neither known nor a file."""
    label = label or scene.name
    folder = scene.source.parent if scene.source else Path()
    for i, obj in enumerate(scene.objects):
        if obj.mesh in meshes or (obj.mesh.endswith(".obj") and (folder / obj.mesh).is_file()):
            continue
        near = _nearest(obj.mesh, meshes if isinstance(meshes, Iterable) else ())
        raise SceneError(f"{label}: objects[{i}] ({obj.id}): unknown mesh {obj.mesh!r}{near}")


def scene_to_json(scene: Scene) -> dict[str, Any]:
    """The inverse of `parse_scene`."""
    return {
        "format": FORMAT,
        "name": scene.name,
        "wall_height_m": scene.wall_height_m,
        "walls": [
            {"from": w.start, "to": w.end, "thickness_m": w.thickness_m, "kind": w.kind}
            for w in scene.walls
        ],
        "doors": [{"from": d.start, "to": d.end, "height_m": d.height_m} for d in scene.doors],
        "rooms": [_without_none(vars(room)) for room in scene.rooms],
        "objects": [_without_none(vars(obj)) for obj in scene.objects],
        "spawn": list(scene.spawn),
    }


def save_scene(scene: Scene, path: Path) -> None:
    """Write a scene as JSON, one wall, door, room or object a line."""
    data = scene_to_json(scene)
    lines = [f'  "{key}": {json.dumps(data[key])}' for key in ("format", "name", "wall_height_m")]
    for key in ("walls", "doors", "rooms", "objects", "spawn"):
        rows = ",\n".join(f"    {json.dumps(row)}" for row in data[key])
        lines.append(f'  "{key}": [\n{rows}\n  ]' if rows else f'  "{key}": []')
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def contains(polygon: Polygon, x: float, y: float) -> bool:
    """Whether the point lies in the polygon (even-odd rule)."""
    inside = False
    for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) * (x1 - x0) / (y1 - y0):
            inside = not inside
    return inside


def room_at(scene: Scene, x: float, y: float) -> Room | None:
    """The room that the point lies in."""
    return next((room for room in scene.rooms if contains(room.polygon, x, y)), None)


def polygon_area(polygon: Polygon) -> float:
    """Area in m² (shoelace formula)."""
    pairs = zip(polygon, polygon[1:] + polygon[:1], strict=True)
    return abs(sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in pairs)) / 2


@dataclass(frozen=True)
class _Node:
    """A JSON object with its place in the file, for errors that name it."""

    data: Any
    label: str
    place: str

    def __post_init__(self) -> None:
        if not isinstance(self.data, dict):
            self.fail("", f"is {type(self.data).__name__}, not an object")

    def fail(self, key: str, why: str) -> None:
        where = ".".join(part for part in (self.place, key) if part)
        raise SceneError(f"{self.label}: {where or 'scene'}: {why}")

    def get(self, key: str) -> Any:
        return self.data.get(key)

    def only(self, *keys: str) -> None:
        for key in self.data:
            if key not in keys:
                self.fail(str(key), f"unknown key{_nearest(str(key), keys)}")

    def need(self, key: str) -> Any:
        if key not in self.data:
            self.fail(key, "missing")
        return self.data[key]

    def text(self, key: str) -> str:
        value = self.need(key)
        if not isinstance(value, str) or not value:
            self.fail(key, f"is {value!r}, not a text")
        return str(value)

    def optional_text(self, key: str) -> str | None:
        return self.text(key) if self.data.get(key) is not None else None

    def choice(self, key: str, choices: tuple[str, ...], default: str | None = None) -> str:
        value = self.text(key) if key in self.data or default is None else default
        if value not in choices:
            self.fail(key, f"unknown {value!r}{_nearest(value, choices, len(choices) < 9)}")
        return value

    def number(self, key: str, default: float, above: float = -math.inf) -> float:
        value = self.numbers(key, 1, [default] if key not in self.data else [self.data[key]])[0]
        if value <= above:
            self.fail(key, f"is {value:g}, must be more than {above:g}")
        return value

    def numbers(self, key: str, count: int, value: Any) -> tuple[float, ...]:
        good = isinstance(value, (list, tuple)) and len(value) == count
        if not good or not all(_is_number(v) for v in value):
            self.fail(key, f"is {value!r}, not {count} finite number{'s' * (count > 1)}")
        return tuple(float(v) for v in value)

    def point(self, key: str) -> Point:
        x, y = self.numbers(key, 2, self.need(key))
        return x, y

    def triple(self, key: str) -> tuple[float, float, float]:
        x, y, z = self.numbers(key, 3, self.need(key))
        return x, y, z

    def nodes(self, key: str) -> list["_Node"]:
        rows = self.data.get(key, [])
        if not isinstance(rows, list):
            self.fail(key, "is not a list")
        return [_Node(row, self.label, f"{key}[{i}]") for i, row in enumerate(rows)]

    def polygon(self, key: str, value: Any) -> Polygon:
        if not isinstance(value, list) or len(value) < 3:
            self.fail(key, "a polygon needs at least 3 points")
        points: list[Point] = []
        for i, row in enumerate(value):
            x, y = self.numbers(f"{key}[{i}]", 2, row)
            points.append((x, y))
        if polygon_area(tuple(points)) < 1e-6:
            self.fail(key, "the polygon has no area")
        return tuple(points)

    def polygon_at(self, key: str, i: int) -> Polygon:
        if not isinstance(self.data[key], list):
            self.fail(key, "is not a list of polygons")
        return self.polygon(f"{key}[{i}]", self.data[key][i])


def _wall(node: _Node) -> Wall:
    node.only("from", "to", "thickness_m", "kind")
    start, end = node.point("from"), node.point("to")
    if math.dist(start, end) < 1e-3:
        node.fail("", f"a wall of zero length at ({start[0]:g}, {start[1]:g})")
    thickness = node.number("thickness_m", 0.12, above=0.0)
    return Wall(start, end, thickness, node.choice("kind", ("outer", "inner"), "inner"))


def _door(node: _Node) -> Door:
    node.only("from", "to", "height_m")
    start, end = node.point("from"), node.point("to")
    if math.dist(start, end) < 1e-3:
        node.fail("", f"a door of zero width at ({start[0]:g}, {start[1]:g})")
    return Door(start, end, node.number("height_m", 2.05, above=0.0))


def _room(node: _Node) -> Room:
    node.only("name", "type", "polygon", "floor", "wall")
    return Room(
        name=node.text("name"),
        type=node.choice("type", ROOM_TYPES),
        polygon=node.polygon("polygon", node.need("polygon")),
        floor=node.optional_text("floor"),
        wall=node.optional_text("wall"),
    )


def _object(node: _Node) -> SceneObject:
    node.only("id", "category", "mesh", "position_m", "yaw_rad", "size_m", "tint", "paint")
    size = node.triple("size_m") if node.get("size_m") is not None else None
    if size is not None and min(size) <= 0:
        node.fail("size_m", f"is {list(size)}, every side must be more than 0")
    return SceneObject(
        id=node.text("id"),
        category=node.choice("category", CATEGORIES),
        mesh=node.text("mesh"),
        position_m=node.triple("position_m"),
        yaw_rad=node.number("yaw_rad", 0.0),
        size_m=size,
        tint=node.optional_text("tint"),
        paint=node.optional_text("paint"),
    )


def _check_whole(scene: Scene, label: str) -> None:
    for i, door in enumerate(scene.doors):
        if not any(on_wall(door, wall) for wall in scene.walls):
            raise SceneError(
                f"{label}: doors[{i}]: lies on no wall's centre line (within {ON_WALL_M} m)"
            )
    if not scene.rooms:
        raise SceneError(f"{label}: rooms: at least one room is needed")
    _check_unique(f"{label}: objects", [obj.id for obj in scene.objects])
    _check_unique(f"{label}: rooms", [room.name for room in scene.rooms])


def _check_unique(place: str, names: list[str]) -> None:
    seen: set[str] = set()
    for i, name in enumerate(names):
        if name in seen:
            raise SceneError(f"{place}[{i}]: {name!r} is used twice")
        seen.add(name)


def on_wall(door: Door, wall: Wall) -> bool:
    """Whether both ends of the door lie on the wall's centre line."""
    return all(_distance(point, wall) <= ON_WALL_M for point in (door.start, door.end))


def _distance(point: Point, wall: Wall) -> float:
    ux, uy = wall.end[0] - wall.start[0], wall.end[1] - wall.start[1]
    px, py = point[0] - wall.start[0], point[1] - wall.start[1]
    t = min(1.0, max(0.0, (px * ux + py * uy) / (ux * ux + uy * uy)))
    return math.hypot(px - t * ux, py - t * uy)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _nearest(word: str, words: Iterable[str], everything: bool = False) -> str:
    words = list(words)
    if near := difflib.get_close_matches(word, words, 1, 0.5):
        return f"; did you mean {near[0]!r}?"
    return f"; one of {', '.join(words)}" if everything else ""


def _without_none(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}
