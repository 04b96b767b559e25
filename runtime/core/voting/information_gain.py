"""Frontiers ranked without any semantics: how much is unknown behind one, against the way there.

The strongest policy we know that sees geometry only, to compare the experts with: information gain
discounted by distance (Gonzalez-Banos and Latombe 2002), a bonus for the frontier under way and for
those in the room where the robot is.
"""

import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from runtime.core.distances.terrain import Terrain
from runtime.core.types import Frontier, Mask, Pose

DISCOUNT_PER_M = 0.35  # exponential, of the way there
KEEP_BONUS = 1.3  # of the frontier under way
ROOM_BONUS = 2.0  # of a frontier in the robot's own room
DOORWAY_M = 0.5  # clearance below which a place separates rooms


def masses(
    frontiers: Sequence[Frontier],
    unknown_m2: Mapping[int, float],
    current: int | None,
    terrain: Terrain,
    pose: Pose,
) -> dict[int, float]:
    """What speaks for each frontier in `unknown_m2` but the way there: that area, with a bonus for
    the one under way and for those in the robot's room."""
    here, found = room_of(terrain, pose), {}
    for frontier in frontiers:
        if frontier.id in unknown_m2:
            row, col = terrain.frame.cell(*frontier.goal_xy)
            in_room = terrain.frame.contains(row, col) and here[row, col]
            keep = KEEP_BONUS if frontier.id == current else 1.0
            found[frontier.id] = unknown_m2[frontier.id] * keep * (ROOM_BONUS if in_room else 1.0)
    return found


def by_worth(frontiers: Sequence[Frontier], mass: Mapping[int, float]) -> list[Frontier]:
    """Those that have a mass, the most of it for the way there first; ties go to the nearer, then
    the older."""

    def worth(frontier: Frontier) -> tuple[float, float, int]:
        value = mass[frontier.id] * math.exp(-DISCOUNT_PER_M * frontier.distance_m)
        return -value, frontier.distance_m, frontier.id

    return sorted((f for f in frontiers if f.id in mass), key=worth)


def room_of(terrain: Terrain, pose: Pose) -> Mask:
    """(r, c) cells of the robot's room: what is connected without passing a doorway's width, and
    the margin that was taken off for that."""
    wide = (terrain.clearance_m >= DOORWAY_M) & terrain.traversable
    _, labels = cv2.connectedComponents(wide.view(np.uint8), connectivity=4)
    row, col = terrain.frame.cell(pose.x_m, pose.y_m)
    n = math.ceil(1.2 * DOORWAY_M / terrain.frame.resolution_m)
    near = labels[max(0, row - n) : row + n + 1, max(0, col - n) : col + n + 1]
    found = np.bincount(near[near > 0]) if (near > 0).any() else np.zeros(0, np.int64)
    if not found.size:
        return np.zeros(terrain.frame.shape, bool)  # the robot stands in a doorway
    core = (labels == int(found.argmax())).astype(np.uint8)
    wider = cv2.dilate(core, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * n + 1, 2 * n + 1)))
    room: Mask = wider.astype(bool)
    return room
