"""Scenes as JSON files (`rf-nav-scene/1`): read, checked and written."""

import json
import math
from collections.abc import Container, Iterable, Mapping
from pathlib import Path
from typing import Any

from hil_sim.scenes.format import (
    CATEGORIES,
    ON_WALL_M,
    ROOM_TYPES,
    Door,
    Hole,
    Polygon,
    Room,
    Scene,
    SceneError,
    SceneObject,
    Wall,
    contains,
    on_wall,
)
from hil_sim.scenes.json_node import Node, nearest

FORMAT = "rf-nav-scene/1"
SCENES_DIR = Path(__file__).parent


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
    top = Node(data, label, "")
    if top.get("format") != FORMAT:
        top.fail("format", f"is {top.get('format')!r}; this version reads {FORMAT!r}")
    top.only("format", "name", "wall_height_m", "walls", "doors", "rooms", "objects", "spawn",
             "holes")  # fmt: skip
    scene = Scene(
        name=top.text("name"),
        walls=tuple(_wall(node) for node in top.nodes("walls")),
        doors=tuple(_door(node) for node in top.nodes("doors")),
        rooms=tuple(_room(node) for node in top.nodes("rooms")),
        objects=tuple(_object(node) for node in top.nodes("objects")),
        spawn=tuple(top.polygon_at("spawn", i) for i in range(len(top.get("spawn") or ()))),
        wall_height_m=top.number("wall_height_m", 2.5, above=0.0),
        holes=tuple(_hole(node) for node in top.nodes("holes")),
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
        near = nearest(obj.mesh, meshes if isinstance(meshes, Iterable) else ())
        raise SceneError(f"{label}: objects[{i}] ({obj.id}): unknown mesh {obj.mesh!r}{near}")


def scene_to_json(scene: Scene) -> dict[str, Any]:
    """The inverse of `parse_scene`."""
    # A scene without holes is told as before there were any: truths are kept by what it says.
    holes = {"holes": [_without_none(vars(hole)) for hole in scene.holes]} if scene.holes else {}
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
        **holes,
    }


def save_scene(scene: Scene, path: Path) -> None:
    """Write a scene as JSON, one wall, door, room or object a line."""
    data = scene_to_json(scene)
    lines = [f'  "{key}": {json.dumps(data[key])}' for key in ("format", "name", "wall_height_m")]
    for key in (
        "walls",
        "doors",
        "rooms",
        "objects",
        "spawn",
        *(("holes",) if scene.holes else ()),
    ):
        rows = ",\n".join(f"    {json.dumps(row)}" for row in data[key])
        lines.append(f'  "{key}": [\n{rows}\n  ]' if rows else f'  "{key}": []')
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def _wall(node: Node) -> Wall:
    node.only("from", "to", "thickness_m", "kind")
    start, end = node.point("from"), node.point("to")
    if math.dist(start, end) < 1e-3:
        node.fail("", f"a wall of zero length at ({start[0]:g}, {start[1]:g})")
    thickness = node.number("thickness_m", 0.12, above=0.0)
    return Wall(start, end, thickness, node.choice("kind", ("outer", "inner"), "inner"))


def _door(node: Node) -> Door:
    node.only("from", "to", "height_m")
    start, end = node.point("from"), node.point("to")
    if math.dist(start, end) < 1e-3:
        node.fail("", f"a door of zero width at ({start[0]:g}, {start[1]:g})")
    return Door(start, end, node.number("height_m", 2.05, above=0.0))


def _room(node: Node) -> Room:
    node.only("name", "type", "polygon", "floor", "wall")
    return Room(
        name=node.text("name"),
        type=node.choice("type", ROOM_TYPES),
        polygon=node.polygon("polygon", node.need("polygon")),
        floor=node.optional_text("floor"),
        wall=node.optional_text("wall"),
    )


def _object(node: Node) -> SceneObject:
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


def _hole(node: Node) -> Hole:
    node.only("polygon", "depth_m", "stairs_rad")
    polygon = node.polygon("polygon", node.need("polygon"))
    node.need("depth_m")
    depth_m = node.number("depth_m", 0.0, above=0.0)
    if node.get("stairs_rad") is None:
        return Hole(polygon, depth_m)
    if not _convex(polygon):
        node.fail("stairs_rad", "only a convex polygon can have stairs")
    return Hole(polygon, depth_m, node.number("stairs_rad", 0.0))


def _convex(polygon: Polygon) -> bool:
    """Whether it turns to one side only."""
    turns = [
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
        for a, b, c in zip(
            polygon, polygon[1:] + polygon[:1], polygon[2:] + polygon[:2], strict=True
        )
    ]
    return min(turns) >= -1e-9 or max(turns) <= 1e-9


def _check_whole(scene: Scene, label: str) -> None:
    for i, door in enumerate(scene.doors):
        if not any(on_wall(door, wall) for wall in scene.walls):
            raise SceneError(
                f"{label}: doors[{i}]: lies on no wall's centre line (within {ON_WALL_M} m)"
            )
    if not scene.rooms:
        raise SceneError(f"{label}: rooms: at least one room is needed")
    for i, hole in enumerate(scene.holes):
        middle = [sum(values) / len(hole.polygon) for values in zip(*hole.polygon, strict=True)]
        if any(contains(other.polygon, *middle) for other in scene.holes if other is not hole):
            raise SceneError(f"{label}: holes[{i}]: lies over another hole")
    _check_unique(f"{label}: objects", [obj.id for obj in scene.objects])
    _check_unique(f"{label}: rooms", [room.name for room in scene.rooms])


def _check_unique(place: str, names: list[str]) -> None:
    seen: set[str] = set()
    for i, name in enumerate(names):
        if name in seen:
            raise SceneError(f"{place}[{i}]: {name!r} is used twice")
        seen.add(name)


def _without_none(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}
