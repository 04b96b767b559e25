"""Things in one image by their true boxes: where they are placed, and where they are."""

import numpy as np
import pytest
from boxes import MOUNT as BOXES_MOUNT
from boxes import Box, depth_of, wall

from hil_sim.evaluation import placed_things as placed
from hil_sim.simulation.camera import Frame

CHAIR = Box(2.0, 0.3, (0.4, 0.4), 0.0, 0.9)
CHAIRS = {0: "chair"}


def image(things: dict[int, Box], *others: Box) -> Frame:
    """A frame of things by their number, and of what has none; true depth has no range."""
    depth = depth_of(*things.values(), *others)
    owner = np.full(depth.shape, -1, np.int32)
    for number in things:
        rest = [box for other, box in things.items() if other != number]
        owner[depth != depth_of(*rest, *others)] = number
    return Frame(np.zeros((*depth.shape, 3), np.uint8), depth, owner)


def test_the_camera_is_the_one_of_the_drawn_boxes() -> None:
    assert placed.MOUNT == BOXES_MOUNT


def test_what_stands_free_is_placed_where_it_is() -> None:
    (thing,) = placed.in_frame(image({0: CHAIR}, wall(4.5)), CHAIRS)
    assert (thing.category, thing.misplaced) == ("chair", False)
    assert thing.range_m == pytest.approx(1.81, abs=0.03)
    assert thing.off_m is not None
    assert thing.off_m < 0.1


def test_what_is_hidden_in_its_middle_is_placed_on_what_hides_it() -> None:
    """Of a chair no more is seen than what is round a board before it."""
    board = Box(1.2, 0.2, (0.04, 0.22), 0.35, 0.8)
    (thing,) = placed.in_frame(image({0: CHAIR}, board, wall(4.5)), CHAIRS)
    assert thing.misplaced
    assert thing.off_m == pytest.approx(0.6, abs=0.1)


def test_what_is_beyond_the_cameras_range_is_placed_nowhere() -> None:
    depth = depth_of(CHAIR)
    owner = np.full(depth.shape, -1, np.int32)
    owner[100:200, 300:400] = 0
    far = np.where(owner == 0, np.float32(7.0), depth)
    (thing,) = placed.in_frame(Frame(np.zeros((*far.shape, 3), np.uint8), far, owner), CHAIRS)
    assert (thing.off_m, thing.misplaced) == (None, False)
    assert thing.range_m > 6.9


@pytest.mark.slow
def test_in_a_home_nearly_all_are_placed_where_they_are() -> None:
    views = list(placed.placed_things(["maple"], 3, seed=0))
    assert len(views) == 3
    things = [thing for view in views for thing in view]
    assert len(things) > 5
    assert not {thing.category for thing in things} & {"other", "door"}
    assert sum(thing.misplaced for thing in things) <= 0.1 * len(things)
