"""Two rooms, 3 x 3 m each, with an opening between them; the bed is in the right one."""

from types import SimpleNamespace

import numpy as np
import pytest

from hil_sim.ground_truth.freespace import FreeSpace
from hil_sim.ground_truth.lies_beyond import LiesBeyond
from hil_sim.ground_truth.oracle_votes import AskedFrontier, OracleKnowledge
from hil_sim.scenes.format import Room, Scene, SceneObject
from hil_sim.scenes.furniture.boxes import box_of


@pytest.fixture(scope="module")
def known() -> OracleKnowledge:
    rooms = (
        Room("left", "kitchen", ((0, 0), (3, 0), (3, 3), (0, 3))),
        Room("right", "bedroom", ((3, 0), (6, 0), (6, 3), (3, 3))),
    )
    size = (0.5, 0.5, 0.5)
    things = (
        SceneObject("bed", "bed", "m", (5.6, 0.4, 0.0), 0.0, size),
        SceneObject("lamp", "lamp", "m", (5.6, 1.2, 0.0), 0.0, size),
        SceneObject("sink", "sink", "m", (0.4, 2.6, 0.0), 0.0, size),
    )
    free = np.zeros((60, 120), bool)
    free[4:56, 4:56] = free[4:56, 64:104] = free[20:40, 56:64] = True
    space = FreeSpace(Scene("two", (), (), rooms, things), (0.0, 0.0), free)
    onward_m = space.distance_field(np.array([[5.1, 0.5]]))
    boxes = {0: box_of(things[0]).corners()}
    truth = SimpleNamespace(space=space, field=lambda goal: onward_m, boxes=lambda goal: boxes)
    return OracleKnowledge(truth, "bed", lambda: LiesBeyond.of(space))


def frontier(id: int, x: float, y: float, distance_m: float) -> AskedFrontier:
    cells = np.array([[x, y + d] for d in (-0.1, 0.0, 0.1)])
    return AskedFrontier(id, cells, (x, y), distance_m)


DOOR, SINK, INSIDE = (
    frontier(1, 3.0, 1.5, 2.0), frontier(2, 0.6, 2.4, 0.5), frontier(3, 4.6, 1.2, 4.0),
)  # fmt: skip


def test_a_room_speaks_for_a_frontier_by_its_share_of_the_floor_round_it(known) -> None:
    told = known.evidence("rooms", [DOOR, SINK, INSIDE])
    assert told[1] == pytest.approx(0.5, abs=0.1)
    assert (told[2], told[3]) == (0.0, pytest.approx(1.0, abs=0.05))


def test_things_speak_that_stand_by_the_goal_and_are_none(known) -> None:
    assert known.evidence("objects", [DOOR, SINK, INSIDE]) == {1: 1.0, 2: 0.0, 3: 1.0}


def test_the_way_there_and_on_counts(known) -> None:
    told = known.evidence("beyond", [DOOR, SINK, INSIDE])
    assert max(told.values()) == 1.0
    assert told[1] > told[2]  # 0.5 m there, and 5.5 m on
    nowhere = known.evidence("beyond", [frontier(4, 3.0, 9.0, 1.0), frontier(5, 9.0, 9.0, 1.0)])
    assert nowhere == {4: 0.0, 5: 0.0}  # of which nothing is known
