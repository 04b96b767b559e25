"""Types of room on the service's map, with how much floor of each was seen."""

import base64
import zlib
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from runtime.errors import SensorError

MOST_CELLS: Final = 1 << 25
FREE: Final = 1


def rooms_on(told: Mapping[str, Any]) -> list[dict[str, Any]]:
    """An answer on `rfnav/map` -> the largest first, by `room`, with `floor_m2` and `middle_xy`, m
    in odometry's frame. SensorError for what is no map."""
    if not told["rows"]:
        return []
    cells, rooms = _grid(told, "cells"), _grid(told, "rooms")
    side_m, (x0_m, y0_m) = float(told["resolution_m"]), told["origin_xy"]
    found = []
    for index, name in enumerate(told["room_names"]):
        rows, cols = np.nonzero((rooms == index) & (cells == FREE))
        if rows.size:
            middle = x0_m + (cols.mean() + 0.5) * side_m, y0_m + (rows.mean() + 0.5) * side_m
            floor = round(rows.size * side_m**2, 1)
            xy = [round(float(at), 1) for at in middle]
            found.append({"room": str(name), "floor_m2": floor, "middle_xy": xy})
    return sorted(found, key=lambda room: -room["floor_m2"])


def _grid(told: Mapping[str, Any], name: str) -> NDArray[np.uint8]:
    rows, cols = int(told["rows"]), int(told["cols"])
    if not 0 < rows * cols <= MOST_CELLS:
        raise SensorError(f"rfnav/map: {rows} x {cols} cells are no map")
    raw = zlib.decompressobj().decompress(base64.b64decode(told[name]), rows * cols + 1)
    if len(raw) != rows * cols:
        raise SensorError(f"rfnav/map: {name}: {len(raw)} cells in place of {rows * cols}")
    return np.frombuffer(raw, np.uint8).reshape(rows, cols)
