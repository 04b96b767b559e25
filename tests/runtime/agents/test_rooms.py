"""Rooms, as the map has them."""

import base64
import zlib

import numpy as np
import pytest
from agent_service import KNOWN

from runtime.agents.rooms import MOST_CELLS, rooms_on
from runtime.errors import SensorError


def packed(cells: np.ndarray) -> str:
    return base64.b64encode(zlib.compress(cells.astype(np.uint8).tobytes())).decode()


def test_floor_is_counted_by_room():
    cells, rooms = np.ones((10, 20)), np.zeros((10, 20))
    rooms[:, 15:] = 1
    cells[0] = 2  # a wall is no floor
    told = {"rows": 10, "cols": 20, "resolution_m": 0.1, "origin_xy": [-1.0, 2.0]}
    found = rooms_on(
        {
            **told,
            "cells": packed(cells),
            "rooms": packed(rooms),
            "room_names": ["hall", "bath", "x"],
        }
    )
    assert found == [
        {"room": "hall", "floor_m2": 1.4, "middle_xy": [-0.2, 2.5]},
        {"room": "bath", "floor_m2": 0.5, "middle_xy": [0.8, 2.5]},
    ]


def test_before_the_first_map_there_are_none():
    assert rooms_on({"rows": 0, "cols": 0}) == []


@pytest.mark.parametrize("size", [(MOST_CELLS, 2), (-5, 5), (3, 3)])
def test_what_is_no_map_is_refused(size: tuple[int, int]):
    told = KNOWN.told("map") | {"rows": size[0], "cols": size[1]}
    with pytest.raises(SensorError, match="rfnav/map"):
        rooms_on(told)
