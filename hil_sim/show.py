"""`hil-sim show`: a scene for people, as a top-down plan and four camera views."""

import math
from pathlib import Path

import click
import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.furnish import Box
from hil_sim.scene import Scene, SceneObject, contains, load_scene

PIXELS_PER_M = 90
MARGIN_M = 0.4
Image = NDArray[np.uint8]


def plan_image(scene: Scene, sizes: dict[str, tuple[float, float, float]]) -> Image:
    """(H, W, 3) RGB top-down plan: rooms, walls, doors, objects by name with their fronts.

    `sizes`: catalogue sizes by mesh for objects that give none.
    """
    points = np.array([p for wall in scene.walls for p in (wall.start, wall.end)])
    points = np.vstack([points, *[room.polygon for room in scene.rooms]])
    low, high = points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M
    width, height = ((high - low) * PIXELS_PER_M).astype(int)
    image: Image = np.full((height, width, 3), 255, np.uint8)

    def px(xy: NDArray[np.float64]) -> NDArray[np.int32]:
        flat = (np.asarray(xy) - low) * PIXELS_PER_M
        return np.stack([flat[..., 0], height - flat[..., 1]], axis=-1).astype(np.int32)

    for room in scene.rooms:
        cv2.fillPoly(image, [px(np.array(room.polygon))], _pale(room.floor))
    for wall in scene.walls:
        thick = round(wall.thickness_m * PIXELS_PER_M)
        ends = px(np.array([wall.start, wall.end]))
        cv2.line(image, ends[0].tolist(), ends[1].tolist(), (60, 60, 60), thick)
    for door in scene.doors:
        ends = px(np.array([door.start, door.end]))
        cv2.line(image, ends[0].tolist(), ends[1].tolist(), (235, 225, 200), 12)
    for obj in sorted(scene.objects, key=lambda obj: (obj.position_m[2], _height(obj))):
        _draw_object(image, px, obj, obj.size_m or sizes.get(obj.mesh, (0.4, 0.4, 0.4)))
    for room in scene.rooms:
        middle = px(np.mean(np.array(room.polygon), axis=0))
        _text(image, room.name, middle.tolist(), 0.6, (150, 30, 30))
    return image


def _height(obj: SceneObject) -> float:
    return obj.size_m[2] if obj.size_m else 0.5


def _draw_object(image, px, obj: SceneObject, size) -> None:  # type: ignore[no-untyped-def]
    (x, y, z), (w, d, h) = obj.position_m, size
    box = Box(x, y, w, d, obj.yaw_rad, z, z + h)
    corners = px(box.corners())
    colour = (200, 215, 235) if z < 0.9 else (225, 205, 235)
    if obj.category == "other":
        colour = (225, 225, 225)
    cv2.fillPoly(image, [corners], colour)
    cv2.polylines(image, [corners], True, (90, 90, 120), 1)
    cv2.line(image, corners[0].tolist(), corners[1].tolist(), (220, 60, 60), 3)  # the front
    label = obj.category if obj.category != "other" else obj.mesh.split("#")[-1]
    _text(image, label, px(np.array([x, y])).tolist(), 0.36, (20, 20, 20))


def _text(image: Image, text: str, at: list[int], scale: float, colour: tuple[int, ...]) -> None:
    (w, h), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    origin = (at[0] - w // 2, at[1] + h // 2)
    cv2.putText(image, text, origin, cv2.FONT_HERSHEY_SIMPLEX, scale, colour, 1, cv2.LINE_AA)


def _pale(colour: str | None) -> tuple[int, int, int]:
    if not colour or not colour.startswith("#"):
        return (240, 236, 228)
    rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return tuple(round(255 - (255 - c) * 0.3) for c in rgb)  # type: ignore[return-value]
