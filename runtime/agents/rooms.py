"""Types of room on the service's map, with how much floor of each was seen."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from runtime.service.told_map import unpacked

FREE: Final = 1


def rooms_on(told: Mapping[str, Any]) -> list[dict[str, Any]]:
    """An answer on `rfnav/map` -> the largest first, by `room`, with `floor_m2` and `middle_xy`, m
    in odometry's frame. SensorError for what is no map."""
    if not told["rows"]:
        return []
    cells, rooms = unpacked(told, "cells"), unpacked(told, "rooms")
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
