"""What an operator's page draws over the map, in one message of JSON: frontiers, things, the way
that is planned and the one that was driven, the area of a search."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from runtime.core.types import F64, Frontier
from runtime.robot import wire
from runtime.robot.dialects.dialect import RosTopic
from runtime.robot.drawn_messages import DrawnObject, Stamp

SCENE: Final = RosTopic("rfnav/scene", wire.STRING)
CELLS_MOST: Final = 40  # of a frontier; what has more is drawn coarser
WAY_MOST: Final = 500  # places of a way
THINGS_MOST: Final = 500


@dataclass(frozen=True)
class DrawnScene:
    """Map frame, m. `way_xy`: (N, 2) where the robot has been; `plan_xy`: (N, 2) what it follows;
    `area`: corners of what the search is bound to."""

    goal: str
    frontiers: Sequence[Frontier]
    elected: int | None
    things: Sequence[DrawnObject]
    plan_xy: F64
    way_xy: F64
    area: Sequence[tuple[float, float]] | None = None


def encode_scene(scene: DrawnScene, at: Stamp) -> bytes:
    """JSON in std_msgs/String, in odometry's frame; places to the centimetre."""
    told: Mapping[str, object] = {
        "stamp_ns": at.stamp_ns,
        "goal": scene.goal,
        "frontiers": [_frontier(one, scene.elected, at) for one in scene.frontiers],
        "things": [_thing(one, scene.goal, at) for one in scene.things[:THINGS_MOST]],
        "plan": _listed(scene.plan_xy, at, WAY_MOST),
        "path": _listed(scene.way_xy, at, WAY_MOST),
        "area": _listed(np.array(scene.area), at, WAY_MOST) if scene.area else None,
    }
    return wire.encode_json(told)


def coarser(points: Any, most: int) -> Any:
    """At most so many of a sequence, or of an array's rows, evenly, the last one among them."""
    step = max(1, -(-len(points) // most))
    return points[::-step][::-1]


def _frontier(one: Frontier, elected: int | None, at: Stamp) -> dict[str, object]:
    return {
        "id": one.id,
        "xy": _listed(np.array([one.centre_xy]), at, 1)[0],
        "cells": _listed(one.cells_xy, at, CELLS_MOST),
        "distance_m": round(one.distance_m, 2) if math.isfinite(one.distance_m) else None,
        "elected": one.id == elected,
    }


def _thing(one: DrawnObject, goal: str, at: Stamp) -> dict[str, object]:
    return {
        "id": one.id,
        "name": one.name,
        "confidence": round(one.confidence, 3),
        "xy": _listed(np.array([one.middle_m[:2]]), at, 1)[0],
        "size": [round(side, 2) for side in one.size_m[:2]],
        "goal": one.name == goal,
    }


def _listed(points_xy: F64, at: Stamp, most: int) -> list[list[float]]:
    """(N, 2) m of the map -> odometry's frame."""
    few = coarser(points_xy, most).reshape(-1, 2)
    placed: list[list[float]] = np.round(few + np.array(at.origin_xy), 2).tolist()
    return placed
