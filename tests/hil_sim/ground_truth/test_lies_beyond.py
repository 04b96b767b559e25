"""6 x 3 m, a wall at x = 3 with an opening in its middle; the robot has seen the left half."""

import numpy as np
import pytest

from hil_sim.ground_truth.freespace import FreeSpace
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.ground_truth.lies_beyond import LiesBeyond
from hil_sim.scenes.format import ROOM_TYPES, Room, Scene, SceneObject

SOFA, BED = (LABELLED.index(name) for name in ("sofa", "bed"))


def home(opening: float = 1.0) -> LiesBeyond:
    rooms = (
        Room("left", "bedroom", ((0, 0), (3, 0), (3, 3), (0, 3))),
        Room("right", "living room", ((3, 0), (6, 0), (6, 3), (3, 3))),
    )
    size = (1.0, 0.6, 0.8)
    things = (
        SceneObject("sofa", "sofa", "m", (5.0, 0.5, 0.0), 0.0, size),
        SceneObject("rug", "other", "m", (5.0, 1.5, 0.0), 0.0, size),
        SceneObject("bed", "bed", "m", (1.0, 0.5, 0.0), 0.0, size),
    )
    free = np.zeros((60, 120), bool)
    free[4:56, 4:56] = free[4:56, 64:116] = True
    half = round(opening / 2 / 0.05)
    free[30 - half : 30 + half, 56:64] = True
    free[4:18, 88:112] = free[4:18, 8:32] = False  # around sofa and bed
    return LiesBeyond.of(FreeSpace(Scene("two", (), (), rooms, things), (0.0, 0.0), free))


FRONTIER = np.array([[3.0, y] for y in np.arange(1.1, 1.9, 0.05)])


def unknown(there: LiesBeyond) -> np.ndarray:
    return (
        there.space.points(np.argwhere(np.ones_like(there.space.free)))[:, 0].reshape(
            there.space.free.shape
        )
        > 3.0
    )


def test_what_lies_behind_an_opening_is_reached_through_the_unknown():
    there = home()
    truth = there.behind(FRONTIER, unknown(there), np.ones(3, bool))
    # from (3.3, 1.2) to where one stands before the sofa, about (4.3, 0.9)
    assert truth.beyond_m[SOFA] == pytest.approx(1.1, abs=0.35)
    assert np.isinf(truth.beyond_m[BED])  # behind the robot
    assert truth.onward_m[BED] == pytest.approx(2.7 - 1.6, abs=0.2)
    assert truth.onward_m[SOFA] <= truth.beyond_m[SOFA]
    right = np.count_nonzero(there.space.free & unknown(there)) * 0.05**2
    assert truth.area_m2 == pytest.approx(right, rel=0.01)
    assert truth.room_m2[ROOM_TYPES.index("living room")] == pytest.approx(right, rel=0.05)
    assert truth.room_m2[ROOM_TYPES.index("bedroom")] == 0.0


def test_what_was_in_view_is_not_counted_again():
    there = home()
    truth = there.behind(FRONTIER, unknown(there), np.array([False, True, True]))
    assert np.isinf(truth.beyond_m[SOFA])
    assert np.isfinite(truth.onward_m[BED])


def test_behind_a_gap_that_no_body_fits_lies_nothing():
    there = home(opening=0.0)
    truth = there.behind(FRONTIER - (0.4, 0.0), unknown(there), np.ones(3, bool))
    assert np.isinf(truth.beyond_m).all()
    assert truth.area_m2 < 0.3
    assert np.isinf(truth.onward_m[SOFA])
