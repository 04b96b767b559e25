"""Rooms, as the map has them."""

import numpy as np

from runtime.agents.rooms import rooms_on
from runtime.service.told_map import packed


def test_floor_is_counted_by_room():
    cells, rooms = np.ones((10, 20), np.uint8), np.zeros((10, 20), np.uint8)
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
