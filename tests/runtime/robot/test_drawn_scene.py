"""What a page is told of a search: bounded, in odometry's frame, with what no way leads to."""

import json
import math
from typing import Any

import numpy as np
from drawn_reader import read

from runtime.core.types import Frontier
from runtime.robot import wire
from runtime.robot.drawn_messages import DrawnObject, Stamp
from runtime.robot.drawn_scene import (
    CELLS_MOST,
    THINGS_MOST,
    WAY_MOST,
    DrawnScene,
    coarser,
    encode_scene,
)

AT = Stamp(7, "odom", (10.0, 20.0))
NOWHERE = np.zeros((0, 2))


def told(**of: Any) -> dict[str, Any]:
    scene: dict[str, Any] = {
        "goal": "mug", "frontiers": (), "elected": None, "things": (), "plan_xy": NOWHERE,
        "way_xy": NOWHERE,
    }  # fmt: skip
    payload = encode_scene(DrawnScene(**scene | of), AT)
    found: dict[str, Any] = json.loads(read(payload, wire.STRING).data)
    return found


def test_a_scene_of_nothing_is_told():
    empty = {"frontiers": [], "things": [], "plan": [], "path": [], "area": None}
    assert told() == {"stamp_ns": 7, "goal": "mug", **empty}


def test_frontiers_are_told_with_the_elected_and_those_that_no_way_leads_to():
    cells = np.array([[1.0, 2.0], [1.0, 3.0]])
    near, shut = Frontier(3, cells, (1.0, 2.0), 4.567), Frontier(4, cells, (1.0, 2.0), math.inf)
    first, second = told(frontiers=(near, shut), elected=3)["frontiers"]
    assert first["xy"] == [11.0, 22.5]
    assert first["cells"] == [[11.0, 22.0], [11.0, 23.0]]
    assert (first["distance_m"], first["elected"]) == (4.57, True)
    assert (second["distance_m"], second["elected"]) == (None, False)


def test_what_is_looked_for_is_marked():
    mug = DrawnObject(1, "mug", 0.91234, (1.0, 1.0, 0.5), (0.1, 0.2, 0.1))
    chair = DrawnObject(2, "chair", 0.5, (2.0, 1.0, 0.5), (0.5, 0.5, 1.0))
    first, second = told(things=(mug, chair))["things"]
    assert first == {
        "id": 1, "name": "mug", "confidence": 0.912, "xy": [11.0, 21.0], "size": [0.1, 0.2],
        "goal": True,
    }  # fmt: skip
    assert not second["goal"]


def test_a_scene_of_a_large_home_stays_small():
    """What a topic of JSON may have is bounded, and so is what a page is sent twice a second."""
    way = np.cumsum(np.ones((20_000, 2)), axis=0)
    wide = Frontier(1, way, (0.0, 0.0), 1.0)
    things = [DrawnObject(n, "x" * 40, 0.5, (1e3, 1e3, 0.5), (1, 1, 1)) for n in range(2000)]
    scene = told(frontiers=[wide] * 50, things=things, plan_xy=way, way_xy=way)
    assert len(scene["frontiers"][0]["cells"]) <= CELLS_MOST
    assert len(scene["path"]) <= WAY_MOST
    assert scene["path"][-1] == [20_010.0, 20_020.0]
    assert len(scene["things"]) == THINGS_MOST
    assert len(json.dumps(scene)) < 1 << 18


def test_the_last_of_a_way_is_kept():
    assert list(coarser([1, 2, 3, 4, 5], 2)) == [2, 5]
    assert list(coarser([1, 2], 2)) == [1, 2]
    assert list(coarser([], 2)) == []
