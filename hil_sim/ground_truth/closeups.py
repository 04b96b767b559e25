"""A goal from 1 m: where it is seen best from, and what it looks like from there."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hil_sim.scenes.furniture.boxes import Box, box_of
from hil_sim.scenes.viewpoints import StandingFloor
from hil_sim.simulation.camera import CameraModel
from hil_sim.simulation.scene_physics import ScenePhysics

AWAY_M, FARTHEST_M = 1.0, 2.0
"""From its footprint; farther only where no nearer place sees it."""
BEARINGS = 10
EYE_M = 0.88
HFOV_RAD = math.radians(79)
SHARE = 0.45
"""Of the picture's width that the object fills."""
NARROWEST_RAD, WIDEST_RAD = math.radians(8), math.radians(75)
SEARCH_PX, LEAST_PIXELS = (160, 120), 4
"""Of the views that are compared: their size, and what counts as seeing it."""
OFF_COST = 4.0
"""How fast a place loses that is not 1 m away."""


@dataclass(frozen=True)
class CloseUp:
    """An object seen from `away_m` of its footprint. `rgb` (H, W, 3)."""

    away_m: float
    rgb: NDArray[np.uint8]


def close_up(
    world: ScenePhysics, floor: StandingFloor, index: int, size_px: tuple[int, int]
) -> CloseUp | None:
    """The object of this index in the scene where most of it shows from 1 m, from before it rather
    than from behind; else from up to 2 m; None when no place on the floor sees it."""
    box = box_of(world.scene.objects[index])
    best: float = 0.0
    place: tuple[float, float, float] | None = None
    for x, y, away in _places(floor, box):
        yaw, pitch, _ = _toward(box, x, y)
        frame = world.render(
            x, y, yaw, CameraModel(*SEARCH_PX, HFOV_RAD, EYE_M), pitch, colour=False
        )
        seen = int((frame.segmentation == index).sum())
        before = math.cos(math.atan2(y - box.y, x - box.x) - box.yaw + math.pi / 2)
        worth = seen * away**2 * (1.5 + before) / (1 + OFF_COST * abs(away - AWAY_M))
        if seen >= LEAST_PIXELS and worth > best:
            best, place = worth, (x, y, away)
    if place is None:
        return None
    x, y, away = place
    yaw, pitch, far = _toward(box, x, y)
    half = math.hypot(box.width, box.depth, box.z1 - box.z0) / 2
    hfov = min(max(2 * math.atan(half / far / SHARE), NARROWEST_RAD), WIDEST_RAD)
    frame = world.render(x, y, yaw, CameraModel(*size_px, hfov, EYE_M), pitch)
    return CloseUp(away, frame.rgb)


def _places(floor: StandingFloor, box: Box) -> list[tuple[float, float, float]]:
    """For each bearing the place to stand nearest to 1 m away, and how far it is; the nearest to
    1 m first."""
    cells = np.argwhere(floor.standing)
    points = (cells[:, ::-1] + 0.5) * floor.cell_m + floor.origin_m
    c, s = math.cos(box.yaw), math.sin(box.yaw)
    local = np.abs((points - (box.x, box.y)) @ np.array([[c, -s], [s, c]]))
    gaps = np.maximum(local - (box.width / 2, box.depth / 2), 0.0)
    away = np.hypot(gaps[:, 0], gaps[:, 1])
    turns = np.arctan2(points[:, 1] - box.y, points[:, 0] - box.x) / math.tau + 0.5
    found: dict[int, tuple[float, float, float]] = {}
    for i in np.argsort(np.abs(away - AWAY_M), kind="stable").tolist():
        if away[i] <= FARTHEST_M:
            place = float(points[i, 0]), float(points[i, 1]), float(away[i])
            found.setdefault(int(turns[i] * BEARINGS) % BEARINGS, place)
    return list(found.values())


def _toward(box: Box, x: float, y: float) -> tuple[float, float, float]:
    """Yaw, pitch (down positive) and distance from a place to the object's middle."""
    flat = math.hypot(box.x - x, box.y - y)
    drop = EYE_M - (box.z0 + box.z1) / 2
    return math.atan2(box.y - y, box.x - x), math.atan2(drop, flat), math.hypot(flat, drop)
