"""What a recording drew of a search, read back: marks of frontiers and of things, and the way that
was planned."""

import re
from typing import Any, Final

from runtime.recording.schemas import MARKERS, PATH
from runtime.robot import wire

TEXT: Final = 9  # Marker.type
_THING: Final = re.compile(r"(.+) (\d\.\d\d)")
POINTS_MOST: Final = 500


def scene_marks(payload: bytes) -> dict[str, list[dict[str, Any]]]:
    """MarkerArray of `/loop/scene` -> frontiers, which are called by their ids, and things, by name
    and confidence. SensorError for damage."""
    frontiers, things = list[dict[str, Any]](), list[dict[str, Any]]()
    for marker in wire.decode(payload, MARKERS, "/loop/scene").markers:
        text, at = str(marker.text), marker.pose.position
        if marker.type != TEXT or not text:
            continue
        xy = [round(float(at.x), 2), round(float(at.y), 2)]
        thing = _THING.fullmatch(text)
        if text.isdecimal():
            frontiers.append({"id": int(text), "xy": xy, "cells": [], "distance_m": None})
        elif thing is not None:
            known = {"name": thing[1], "confidence": float(thing[2]), "xy": xy}
            things.append({"id": len(things) + 1, **known, "size": [0.3, 0.3]})
    return {"frontiers": frontiers, "things": things}


def planned(payload: bytes) -> list[list[float]]:
    """Path -> (x, y) m. SensorError for damage."""
    poses = wire.decode(payload, PATH, "/loop/path").poses[:POINTS_MOST]
    places = [one.pose.position for one in poses]
    return [[round(float(p.x), 2), round(float(p.y), 2)] for p in places]
