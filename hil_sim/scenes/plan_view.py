"""A scene seen from above, as a picture for people: rooms, walls, doors and objects by name."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.format import Scene, SceneObject
from hil_sim.scenes.furniture.boxes import Box

PIXELS_PER_M = 90
MARGIN_M = 0.4
WALL, DOOR, FRONT, INK, ROOM_INK = (
    (60, 60, 60), (235, 225, 200), (120, 120, 135), (20, 20, 20), (150, 30, 30)
)  # fmt: skip
FRONT_M = 0.02  # how thick the front of a thing is drawn
NAMED_M = 0.5  # what is smaller has no name
NAME, ROOM_NAME, LEAST_NAME = 0.36, 0.6, 0.42  # of the font; the last where a room is full
LOW, HIGH, OTHER = (200, 215, 235), (225, 205, 235), (225, 225, 225)
HOLE = (120, 110, 100)
Image = NDArray[np.uint8]
ToPixels = Callable[[NDArray[np.float64]], NDArray[np.int32]]


def plan_bounds(scene: Scene) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(2,) lowest and highest x and y of the plan, m."""
    points = np.array([p for wall in scene.walls for p in (wall.start, wall.end)])
    points = np.vstack([points.reshape(-1, 2), *[np.array(room.polygon) for room in scene.rooms]])
    return points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M


def plan_image(scene: Scene) -> Image:
    """(H, W, 3) RGB top-down plan: rooms, walls, doors and objects with a thicker line in front;
    the larger of them by name."""
    low, high = plan_bounds(scene)
    width, height = ((high - low) * PIXELS_PER_M).astype(int)
    image: Image = np.full((height, width, 3), 255, np.uint8)

    def px(xy: NDArray[np.float64]) -> NDArray[np.int32]:
        flat = (xy - low) * PIXELS_PER_M
        return np.asarray(np.stack([flat[..., 0], height - flat[..., 1]], axis=-1), np.int32)

    for room in scene.rooms:
        cv2.fillPoly(image, [px(np.array(room.polygon))], _pale(room.floor))
    for hole in scene.holes:
        cv2.fillPoly(image, [px(np.array(hole.polygon))], HOLE)
    for wall in scene.walls:
        _line(image, px(np.array([wall.start, wall.end])), WALL, wall.thickness_m)
    for door in scene.doors:
        _line(image, px(np.array([door.start, door.end])), DOOR, 0.13)
    covered: Image = np.zeros((height, width), np.uint8)
    objects = sorted(scene.objects, key=lambda obj: (obj.position_m[2], _size(obj)[2]))
    for obj in objects:
        corners = _draw_object(image, px, obj)
        cv2.fillPoly(covered, [corners], 1)
    names: Image = np.zeros_like(covered)
    for room in scene.rooms:
        _name_room(image, room.name, px(np.array(room.polygon)), covered, names)
    for obj in sorted(objects, key=lambda obj: -max(_size(obj)[:2])):
        _name_object(image, px, obj, names)
    return image


def _draw_object(image: Image, px: ToPixels, obj: SceneObject) -> NDArray[np.int32]:
    """Its (4, 2) corners, px."""
    (x, y, z), (w, d, h) = obj.position_m, _size(obj)
    corners = px(Box(x, y, w, d, obj.yaw_rad, z, z + h).corners())
    colour = OTHER if obj.category == "other" else LOW if z < 0.9 else HIGH
    cv2.fillPoly(image, [corners], colour)
    cv2.polylines(image, [corners], True, (90, 90, 120), 1)
    _line(image, corners[:2], FRONT, FRONT_M)
    return corners


def _name_object(image: Image, px: ToPixels, obj: SceneObject, names: Image) -> None:
    """In its middle, where no other name is; the small ones have none."""
    if max(_size(obj)[:2]) < NAMED_M:
        return
    label = obj.category if obj.category != "other" else obj.mesh.split("#")[-1]
    x, y = px(np.array(obj.position_m[:2]))
    wide, high = _measured(label, NAME)
    if not names[_box(int(x), int(y), wide, high)].any():
        _text(image, label, (int(x), int(y)), NAME, INK, names)


def _name_room(
    image: Image, name: str, polygon: NDArray[np.int32], covered: Image, names: Image
) -> None:
    """Within the room, as deep as can be, on no thing; smaller where it is full, and on a thing
    where there is no other place."""
    inside: Image = np.zeros_like(covered)
    cv2.fillPoly(inside, [polygon], 1)
    bare: Image = inside * (1 - covered) * (1 - names)
    for where, size in ((bare, ROOM_NAME), (bare, LEAST_NAME), (inside, LEAST_NAME)):
        wide, high = _measured(name, size)
        fits = cv2.erode(where, np.ones((high, wide), np.uint8), borderValue=0)
        if fits.any():
            depth = cv2.distanceTransform(np.pad(where, 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
            y, x = np.unravel_index(int((depth * fits).argmax()), depth.shape)
            _text(image, name, (int(x), int(y)), size, ROOM_INK, names)
            return


def _measured(text: str, scale: float) -> tuple[int, int]:
    """Wide, high, px, with a margin."""
    (wide, high), base = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    return wide + 6, high + base + 4


def _box(x: int, y: int, wide: int, high: int) -> tuple[slice, slice]:
    top, left = max(0, y - high // 2), max(0, x - wide // 2)
    return slice(top, y + high // 2 + 1), slice(left, x + wide // 2 + 1)


def _size(obj: SceneObject) -> tuple[float, float, float]:
    return obj.size_m or (0.4, 0.4, 0.4)


def _line(image: Image, ends: NDArray[np.int32], colour: tuple[int, ...], thick_m: float) -> None:
    a, b = (tuple(int(v) for v in end) for end in ends)
    cv2.line(image, a, b, colour, max(1, round(thick_m * PIXELS_PER_M)))


def _text(
    image: Image, text: str, at: tuple[int, int], scale: float, colour: tuple[int, ...],
    names: Image,
) -> None:  # fmt: skip
    """Written, and booked in `names`."""
    (w, h), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    origin = (at[0] - w // 2, at[1] + h // 2)
    cv2.putText(image, text, origin, cv2.FONT_HERSHEY_SIMPLEX, scale, colour, 1, cv2.LINE_AA)
    names[_box(*at, *_measured(text, scale))] = 1


def _pale(colour: str | None) -> tuple[int, ...]:
    if not colour or not colour.startswith("#"):
        return (240, 236, 228)
    rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return tuple(round(255 - (255 - c) * 0.3) for c in rgb)
