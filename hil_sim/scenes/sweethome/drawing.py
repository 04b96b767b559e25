"""`Home.xml` -> the drawing as values: metres, y up on the plan, angles counter-clockwise.

Sweet Home 3D draws in centimetres with y down and clockwise angles; its DTD is in the comment of
its class HomeXMLHandler.
"""

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass

from hil_sim.scenes.format import Point, Polygon, SceneError, polygon_area

Numbers = tuple[float, ...]
UNIT: Numbers = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
FAR_CM = 1e6
LARGE_CM = 1e4
MAX_ITEMS = 5_000
MAX_NESTING = 40
_FURNITURE = ("pieceOfFurniture", "doorOrWindow", "light", "furnitureGroup", "shelfUnit")


@dataclass(frozen=True)
class DrawnWall:
    """A wall along its centre line; `arc_rad` is the angle a curved one turns through (0: none),
    `left`, `right` its sides' colours, "#rrggbb"."""

    place: str
    start: Point
    end: Point
    thickness_m: float
    height_m: float | None
    arc_rad: float
    left: str | None
    right: str | None
    level: str | None


@dataclass(frozen=True)
class DrawnRoom:
    """A room's floor; `texture` names an entry of the archive."""

    place: str
    name: str
    polygon: Polygon
    floor: str | None
    texture: str | None
    level: str | None


@dataclass(frozen=True)
class DrawnText:
    """A text label; `position_m` is the middle of its foot."""

    text: str
    position_m: Point
    level: str | None


@dataclass(frozen=True)
class Opening:
    """The hole that a door or window cuts, as shares of its width and height: from the left, and
    from the top."""

    left: float = 0.0
    width: float = 1.0
    top: float = 0.0
    height: float = 1.0


@dataclass(frozen=True)
class Drawn:
    """A placed piece. `position_m` is the centre of its underside, z above its level's floor;
    `rotation` row-major 3x3 applied to the model (Y up); `paints`: (material, colour, texture);
    `lean_rad` (pitch, roll). `opening` is given for doors and windows."""

    place: str
    name: str
    catalog_id: str
    position_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    yaw_rad: float
    rotation: Numbers
    mirrored: bool
    lean_rad: tuple[float, float]
    model: str | None
    colour: str | None
    texture: str | None
    paints: tuple[tuple[str, str | None, str | None], ...]
    opening: Opening | None
    level: str | None


@dataclass(frozen=True)
class Level:
    """A storey; `height_m` from its floor to its ceiling."""

    id: str
    name: str
    elevation_m: float
    height_m: float


@dataclass(frozen=True)
class Drawing:
    name: str
    wall_height_m: float
    levels: tuple[Level, ...]
    walls: tuple[DrawnWall, ...]
    rooms: tuple[DrawnRoom, ...]
    pieces: tuple[Drawn, ...]
    texts: tuple[DrawnText, ...]
    hidden: int
    """Pieces that the drawing holds but does not show."""


def read_drawing(data: bytes, label: str) -> Drawing:
    """Parse `Home.xml`; SceneError starts with `label` and names the element and attribute."""
    if b"<!ENTITY" in data:
        raise SceneError(f"{label}: declares XML entities, which Sweet Home 3D never does")
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise SceneError(f"{label}: not XML: {error}") from None
    if root.tag != "home":
        raise SceneError(f"{label}: the root is <{root.tag[:40]}>, not <home>")
    if sum(1 for _ in root.iter()) > 50 * MAX_ITEMS:
        raise SceneError(f"{label}: more than {50 * MAX_ITEMS} elements")
    top = _Element(root, label, "home")
    pieces: list[Drawn] = []
    hidden = _furniture(root, label, "", None, pieces, 0)
    return Drawing(
        name=root.get("name", ""),
        wall_height_m=top.metres("wallHeight", 250.0, 10.0, LARGE_CM),
        levels=tuple(_level(node) for node in _all(root, label, "level")),
        walls=tuple(_wall(node) for node in _all(root, label, "wall")),
        rooms=tuple(_room(node) for node in _all(root, label, "room")),
        pieces=tuple(pieces),
        texts=tuple(_text(node) for node in _all(root, label, "label")),
        hidden=hidden,
    )


@dataclass(frozen=True)
class _Element:
    """An element with its place in the file, for errors that name it."""

    node: ET.Element
    label: str
    place: str

    def fail(self, key: str, why: str) -> SceneError:
        return SceneError(f"{self.label}: {self.place}: {key}: {why}")

    def number(self, key: str, default: float | None, low: float, high: float) -> float:
        text = self.node.get(key)
        if text is None:
            if default is None:
                raise self.fail(key, "missing")
            return default
        try:
            value = float(text)
        except ValueError:
            raise self.fail(key, f"is {text[:40]!r}, not a number") from None
        if not math.isfinite(value):
            raise self.fail(key, f"is {text[:40]!r}, not a finite number")
        if not low <= value <= high:
            raise self.fail(key, f"is {value:g}, must be from {low:g} to {high:g}")
        return value

    def metres(self, key: str, default: float | None, low: float, high: float) -> float:
        return self.number(key, default, low, high) / 100

    def point(self, x: str, y: str) -> Point:
        return (
            self.metres(x, None, -FAR_CM, FAR_CM),
            -self.metres(y, None, -FAR_CM, FAR_CM),
        )

    def angle(self, key: str) -> float:
        return math.remainder(self.number(key, 0.0, -math.inf, math.inf), math.tau)

    def yes(self, key: str, default: bool = False) -> bool:
        return self.node.get(key, "true" if default else "false") == "true"

    def colour(self, key: str) -> str | None:
        """Sweet Home 3D writes (AA)RRGGBB in hexadecimal."""
        text = self.node.get(key)
        if text is None:
            return None
        if not re.fullmatch("[0-9a-fA-F]{1,8}", text):
            raise self.fail(key, f"is {text[:40]!r}, not a colour such as FF336699")
        return "#" + text.zfill(6)[-6:].lower()

    def texture(self, attribute: str | None = None) -> str | None:
        for node in self.node.findall("texture"):
            if node.get("attribute") == attribute:
                return node.get("image")
        return None


def _all(root: ET.Element, label: str, tag: str) -> list[_Element]:
    nodes = root.findall(tag)
    if len(nodes) > MAX_ITEMS:
        raise SceneError(f"{label}: {tag}: {len(nodes)} of them; at most {MAX_ITEMS}")
    return [_Element(node, label, f"{tag}[{i}]") for i, node in enumerate(nodes)]


def _level(at: _Element) -> Level:
    return Level(
        at.node.get("id", ""),
        at.node.get("name", ""),
        at.metres("elevation", None, -FAR_CM, FAR_CM),
        at.metres("height", 250.0, 0.0, LARGE_CM),
    )


def _wall(at: _Element) -> DrawnWall:
    height = at.node.get("height")
    return DrawnWall(
        at.place,
        at.point("xStart", "yStart"),
        at.point("xEnd", "yEnd"),
        at.metres("thickness", None, 0.1, 1000.0),
        at.metres("height", None, 0.0, LARGE_CM) if height is not None else None,
        at.number("arcExtent", 0.0, -math.tau, math.tau),
        at.colour("leftSideColor"),
        at.colour("rightSideColor"),
        at.node.get("level"),
    )


def _room(at: _Element) -> DrawnRoom:
    points = [
        _Element(node, at.label, f"{at.place}.point[{i}]").point("x", "y")
        for i, node in enumerate(at.node.findall("point"))
    ]
    return DrawnRoom(
        at.place,
        at.node.get("name", "").strip(),
        tuple(points),
        at.colour("floorColor"),
        at.texture("floorTexture"),
        at.node.get("level"),
    )


def _text(at: _Element) -> DrawnText:
    text = " ".join(at.node.findtext("text", "").split())[:60]
    return DrawnText(text, at.point("x", "y"), at.node.get("level"))


def usable(room: DrawnRoom) -> bool:
    """Whether the room's outline encloses anything."""
    return len(room.polygon) >= 3 and polygon_area(room.polygon) > 0.01


def _furniture(
    parent: ET.Element, label: str, path: str, level: str | None, out: list[Drawn], depth: int
) -> int:
    """Add the pieces of a home or a group to `out`; returns how many are hidden."""
    if depth > MAX_NESTING:
        raise SceneError(f"{label}: {path[:80]}: groups in groups, more than {MAX_NESTING} deep")
    hidden, count = 0, dict.fromkeys(_FURNITURE, 0)
    for node in parent:
        if node.tag not in count:
            continue
        place = f"{path}{node.tag}[{count[node.tag]}]"
        count[node.tag] += 1
        at = _Element(node, label, place)
        here = node.get("level", level)
        if not at.yes("visible", default=True):
            hidden += 1
        elif node.tag == "furnitureGroup":
            hidden += _furniture(node, label, place + ".", here, out, depth + 1)
        else:
            out.append(_piece(at, here))
        if len(out) > MAX_ITEMS:
            raise SceneError(f"{label}: furniture: more than {MAX_ITEMS} pieces")
    return hidden


def _piece(at: _Element, level: str | None) -> Drawn:
    node = at.node
    x, y = at.point("x", "y")
    width, depth, height = (
        max(0.001, at.metres(key, None, 0.0, LARGE_CM)) for key in ("width", "depth", "height")
    )
    opens = node.tag == "doorOrWindow" or at.yes("doorOrWindow")
    name = " ".join(node.get("name", "").split())[:60]
    return Drawn(
        place=f"{at.place} ({name})" if name else at.place,
        name=name,
        catalog_id=node.get("catalogId", ""),
        position_m=(x, y, at.metres("elevation", 0.0, -LARGE_CM, LARGE_CM)),
        size_m=(width, depth, height),
        yaw_rad=-at.angle("angle"),
        rotation=_rotation(at),
        mirrored=at.yes("modelMirrored"),
        lean_rad=(at.angle("pitch"), at.angle("roll")),
        model=node.get("model"),
        colour=at.colour("color"),
        texture=at.texture(),
        paints=tuple(
            (paint.node.get("name", ""), paint.colour("color"), paint.texture())
            for paint in (
                _Element(found, at.label, f"{at.place}.material[{i}]")
                for i, found in enumerate(node.findall("material"))
            )
        ),
        opening=_opening(at) if opens else None,
        level=level,
    )


def _opening(at: _Element) -> Opening:
    left, width, top, height = (
        at.number(key, default, -10.0, 10.0)
        for key, default in (
            ("wallLeft", 0.0), ("wallWidth", 1.0), ("wallTop", 0.0), ("wallHeight", 1.0)
        )
    )  # fmt: skip
    return Opening(left, width, top, height)


def _rotation(at: _Element) -> Numbers:
    text = at.node.get("modelRotation")
    if text is None:
        return UNIT
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != 9 or not all(abs(v) <= 1e3 for v in values):
        raise at.fail("modelRotation", f"is {text[:60]!r}, not 9 numbers of a 3x3 rotation")
    return values
