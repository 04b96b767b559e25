"""Scenes: furnished homes as data; `scene_file` reads and writes them.

Scene frame: metres, x right and y up on the plan, z up, yaw counter-clockwise from x.
An object's front looks along its local -y before yaw is applied.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path

from runtime.errors import RfNavError

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
class Hole:
    """Where the floor is missing: the ground there is `depth_m` lower. With `stairs_rad`, of a
    convex polygon, treads lead down in that direction, as far as there is room for them."""

    polygon: Polygon
    depth_m: float
    stairs_rad: float | None = None


@dataclass(frozen=True)
class Scene:
    name: str
    walls: tuple[Wall, ...]
    doors: tuple[Door, ...]
    rooms: tuple[Room, ...]
    objects: tuple[SceneObject, ...]
    spawn: tuple[Polygon, ...] = ()
    wall_height_m: float = 2.5
    holes: tuple[Hole, ...] = ()
    source: Path | None = field(default=None, compare=False)
    """The file it was read from; meshes given by path are relative to its folder."""


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


def on_wall(door: Door, wall: Wall) -> bool:
    """Whether both ends of the door lie on the wall's centre line."""
    return all(_distance(point, wall) <= ON_WALL_M for point in (door.start, door.end))


def _distance(point: Point, wall: Wall) -> float:
    ux, uy = wall.end[0] - wall.start[0], wall.end[1] - wall.start[1]
    px, py = point[0] - wall.start[0], point[1] - wall.start[1]
    t = min(1.0, max(0.0, (px * ux + py * uy) / (ux * ux + uy * uy)))
    return math.hypot(px - t * ux, py - t * uy)
