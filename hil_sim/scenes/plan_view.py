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
    (60, 60, 60), (235, 225, 200), (220, 60, 60), (20, 20, 20), (150, 30, 30)
)  # fmt: skip
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
    """(H, W, 3) RGB top-down plan: rooms, walls, doors, objects by name with their fronts red."""
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
    for obj in sorted(scene.objects, key=lambda obj: (obj.position_m[2], _size(obj)[2])):
        _draw_object(image, px, obj)
    for room in scene.rooms:
        middle = px(np.array(room.polygon).mean(axis=0))
        _text(image, room.name, middle, 0.6, ROOM_INK)
    return image


def _draw_object(image: Image, px: ToPixels, obj: SceneObject) -> None:
    (x, y, z), (w, d, h) = obj.position_m, _size(obj)
    corners = px(Box(x, y, w, d, obj.yaw_rad, z, z + h).corners())
    colour = OTHER if obj.category == "other" else LOW if z < 0.9 else HIGH
    cv2.fillPoly(image, [corners], colour)
    cv2.polylines(image, [corners], True, (90, 90, 120), 1)
    _line(image, corners[:2], FRONT, 0.03)
    label = obj.category if obj.category != "other" else obj.mesh.split("#")[-1]
    _text(image, label, px(np.array([x, y])), 0.36, INK)


def _size(obj: SceneObject) -> tuple[float, float, float]:
    return obj.size_m or (0.4, 0.4, 0.4)


def _line(image: Image, ends: NDArray[np.int32], colour: tuple[int, ...], thick_m: float) -> None:
    a, b = (tuple(int(v) for v in end) for end in ends)
    cv2.line(image, a, b, colour, max(1, round(thick_m * PIXELS_PER_M)))


def _text(
    image: Image, text: str, at: NDArray[np.int32], scale: float, colour: tuple[int, ...]
) -> None:
    (w, h), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    origin = (int(at[0]) - w // 2, int(at[1]) + h // 2)
    cv2.putText(image, text, origin, cv2.FONT_HERSHEY_SIMPLEX, scale, colour, 1, cv2.LINE_AA)


def _pale(colour: str | None) -> tuple[int, ...]:
    if not colour or not colour.startswith("#"):
        return (240, 236, 228)
    rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return tuple(round(255 - (255 - c) * 0.3) for c in rgb)
