"""What of a frontier is given up that was faced, on drawn maps."""

import numpy as np
import pytest

from runtime.core.exploration import HERE_M, SEEN_RANGE_M, to_frontier, with_frontiers
from runtime.core.settings import NavigateConfig
from runtime.core.types import F64, Frontier, Mask, Pose
from runtime.core.world import World

CFG = NavigateConfig()
START = Pose(0.0, 0.0, 0.0)
DILATED_M = 0.15  # what is given up takes what is right beside it along


def begun() -> World:
    return World.begin("toilet", ("toilet",), ("bathroom",), START, CFG.robot.radius_m)


@pytest.fixture
def places() -> F64:
    """(R, C, 2) m, the middles of a new map's cells."""
    frame = begun().map.frame
    cells = np.argwhere(np.ones(frame.shape, bool)).astype(np.int32)
    return frame.centres(cells).reshape(*frame.shape, 2)


def faced(known: Mask, part: Mask) -> tuple[F64, F64]:
    """Of the edge of what is known, all of it floor, that part as a frontier which the robot has
    arrived at, and faces: its cells that are given up, and those that are not, m."""
    world = begun()
    world.map.evidence[known], world.map.swept[known] = -9, True
    world.map.changed()
    with_frontiers(world, CFG)
    cells = world.explored.boundary.edge & part
    frontier = Frontier(1, world.map.frame.centres(np.argwhere(cells).astype(np.int32)), (0, 0), 0)
    assert to_frontier(world, frontier, CFG) is None
    gone = world.explored.given_up[cells]
    return frontier.cells_xy[gone], frontier.cells_xy[~gone]


def test_behind_what_is_ahead_the_robot_has_looked(places: F64):
    x, y = places[..., 0], places[..., 1]
    gone, left = faced((x < 1.5) & (abs(y) < 3.0), (x > 1.3) & (abs(y) < 2.5))
    assert np.hypot(*gone.T).max() == pytest.approx(SEEN_RANGE_M, abs=DILATED_M)
    assert np.hypot(*left.T).min() == pytest.approx(SEEN_RANGE_M, abs=DILATED_M)


def test_what_lies_along_the_line_of_sight_is_looked_into_from_farther_on(places: F64):
    """As past the end of a wall beside the robot: of what the wall hides nothing was seen."""
    x, y = places[..., 0], places[..., 1]
    gone, left = faced((y > -0.2) & (abs(x) < 4.0), (x > 0.2) & (x < 1.9) & (y < 0))
    nearest_m = np.hypot(*np.concatenate([gone, left]).T).min()
    assert np.hypot(*gone.T).max() == pytest.approx(nearest_m + HERE_M, abs=DILATED_M)
    assert np.hypot(*left.T).max() == pytest.approx(1.9, abs=DILATED_M)


def test_something_is_given_up_each_time_however_far_it_is(places: F64):
    x, y = places[..., 0], places[..., 1]
    gone, left = faced((y > -0.2) & (abs(x) < 4.0), (x > 1.0) & (x < 3.5) & (y < 0))
    assert np.hypot(*gone.T).max() == pytest.approx(1.0 + HERE_M, abs=DILATED_M)
    assert len(left) > len(gone)
