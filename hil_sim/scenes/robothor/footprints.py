"""The upright box of an object: what its axis-aligned and oriented boxes say together."""

import math
from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from statistics import median

import cv2
import numpy as np

from hil_sim.scenes.robothor.metadata import APARTMENTS, Thing, apartment

RIGHT_ANGLE = math.pi / 2
NEAR_RIGHT_RAD = math.radians(4)
SOLVABLE = 0.35
"""|cos 2θ| above which a turned box's sides follow from its axis-aligned box."""
LONG, LEANING = 5.0, 0.7
"""Longest over shortest side of what can lean, and the slope (sine) from which it does."""
LEAST_M = 0.01
WIDEST_M = {"ArmChair": 1.05}
"""The longest side of a type whose unnamed assets have boxes inflated at right angles too: a part
of them is turned inside."""


@dataclass(frozen=True)
class Footprint:
    """Middle x, y; width and depth along the object's own axes; yaw by which its local -y looks
    the way Unity's forward does; underside z and height. Metres, scene frame."""

    x: float
    y: float
    width: float
    depth: float
    yaw_rad: float
    z: float
    height: float

    def half_along(self, direction_rad: float) -> float:
        """How far the box reaches from its middle along a direction of the plan."""
        turn = direction_rad - self.yaw_rad
        return abs(math.cos(turn)) * self.width / 2 + abs(math.sin(turn)) * self.depth / 2


def footprint(thing: Thing) -> Footprint:
    """The upright box of an object. Boxes that Unity inflated, since they are axis-aligned around
    a turned object, are brought back to the asset's size seen elsewhere, or solved for."""
    yaw = _wrap(math.pi - math.radians(thing.turn_deg[1]))
    if thing.corners_m:
        x, y, width, depth, yaw = _tight(thing, yaw)
    else:
        x, y = thing.middle_m[:2]
        width, depth = _sides(thing, yaw)
    if thing.type in WIDEST_M and not thing.asset:
        shrunk = min(1.0, WIDEST_M[thing.type] / max(width, depth))
        width, depth = width * shrunk, depth * shrunk
    sides = max(width, LEAST_M), max(depth, LEAST_M)
    return Footprint(x, y, *sides, yaw, thing.low_m[2], max(thing.size_m[2], LEAST_M))


def _tight(thing: Thing, yaw: float) -> tuple[float, float, float, float, float]:
    """The smallest rectangle on the plan around the oriented box, its axes named by `yaw`."""
    lean = _lean(thing)
    yaw = yaw if lean is None else lean
    corners = np.array(thing.corners_m, np.float32)[:, :2]
    middle = corners.mean(axis=0)
    (x, y), (a, b), degrees = cv2.minAreaRect(corners - middle)
    turn = math.radians(degrees)
    quarter = round((yaw - turn) / RIGHT_ANGLE)
    width, depth = (b, a) if quarter % 2 else (a, b)
    found = _wrap(turn + quarter * RIGHT_ANGLE)
    return float(x + middle[0]), float(y + middle[1]), float(width), float(depth), found


def _lean(thing: Thing) -> float | None:
    """The yaw of something long that leans: its back is where its top is; None if it does not."""
    corners = np.array(thing.corners_m)
    sides = corners[[1, 3, 4]] - corners[0]
    lengths = np.hypot(np.hypot(*sides.T[:2]), sides.T[2])
    long = sides[int(np.argmax(lengths))] / lengths.max()
    x, y, z = long * (1.0 if long[2] >= 0 else -1.0)
    if lengths.max() < LONG * np.sort(lengths)[0] or z < LEANING or math.hypot(x, y) < 0.05:
        return None
    return math.atan2(y, x) - RIGHT_ANGLE


def _sides(thing: Thing, yaw: float) -> tuple[float, float]:
    along_x, along_y, _ = thing.size_m
    quarter = round(yaw / RIGHT_ANGLE)
    if abs(yaw - quarter * RIGHT_ANGLE) < NEAR_RIGHT_RAD:
        return (along_y, along_x) if quarter % 2 else (along_x, along_y)
    if thing.asset in _asset_sizes():
        return _asset_sizes()[thing.asset]
    c, s = abs(math.cos(yaw)), abs(math.sin(yaw))
    scale = c * c - s * s
    if abs(scale) > SOLVABLE:
        width, depth = (along_x * c - along_y * s) / scale, (along_y * c - along_x * s) / scale
        if min(width, depth) > 0.3 * min(along_x, along_y):
            return width, depth
    shrunk = 1 / (c + s)
    return along_x * shrunk, along_y * shrunk


@cache
def _asset_sizes() -> dict[str, tuple[float, float]]:
    """Width and depth of the assets that stand at a right angle somewhere."""
    seen: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for name in APARTMENTS:
        for thing in apartment(name):
            yaw = math.pi - math.radians(thing.turn_deg[1])
            quarter = round(yaw / RIGHT_ANGLE)
            if thing.asset and abs(yaw - quarter * RIGHT_ANGLE) < NEAR_RIGHT_RAD:
                x, y, _ = thing.size_m
                seen[thing.asset].append((y, x) if quarter % 2 else (x, y))
    return {
        asset: (median(w for w, _ in sizes), median(d for _, d in sizes))
        for asset, sizes in seen.items()
    }


def _wrap(angle: float) -> float:
    return math.remainder(angle, 2 * math.pi)
