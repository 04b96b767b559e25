"""Ways of several whole steps through places that no single step leads through."""

import math

import numpy as np
import pytest

from runtime.core.distances.planner import Field, march_from
from runtime.core.distances.terrain import MARGIN_M, Terrain, clearance_between
from runtime.core.geometry import GridFrame
from runtime.core.motion.discrete_policy import FORWARD_M, TURN_RAD, follow
from runtime.core.motion.step_search import GAIN_M, clear, through
from runtime.core.types import Action, Pose

RADIUS_M, RESOLUTION_M = 0.18, 0.025
FRAME = GridFrame(-2.0, -1.5, RESOLUTION_M, 120, 160)
GOAL, START = np.array([1.5, 0.0]), Pose(-0.6, 0.0, 0.0)


def hall(gap_m: float, middle_m: float) -> tuple[Terrain, Field]:
    """A wall 0.4 m thick across a hall, with a gap in it; the distance to a place beyond."""
    rows, cols = np.indices(FRAME.shape)
    xy = FRAME.centres(np.stack([rows, cols], -1).astype(np.int32))
    x, y = xy[..., 0], xy[..., 1]
    aside = np.abs(y - middle_m) - gap_m / 2  # of the gap: inside it is negative
    along = np.abs(x) - 0.2
    wall_m = np.hypot(np.maximum(-aside, 0), np.maximum(along, 0))
    clearance = np.where((aside > 0) & (along < 0), 0.0, wall_m).astype(np.float32)
    fits = clearance >= RADIUS_M + MARGIN_M
    terrain = Terrain(FRAME, clearance, fits, np.where(fits, 1.0, 0.0).astype(np.float32))
    return terrain, march_from(terrain, GOAL)


def moved(pose: Pose, action: Action) -> Pose:
    if action is Action.MOVE_FORWARD:
        x = pose.x_m + FORWARD_M * math.cos(pose.yaw_rad)
        return Pose(x, pose.y_m + FORWARD_M * math.sin(pose.yaw_rad), pose.yaw_rad)
    turn = TURN_RAD if action is Action.TURN_LEFT else -TURN_RAD
    return Pose(pose.x_m, pose.y_m, pose.yaw_rad + turn)


def follows(terrain: Terrain, field: Field, pose: Pose) -> Pose:
    """Where single steps lead."""
    for _ in range(60):
        action = follow(terrain, field, pose, RADIUS_M)
        if action is None or pose.x_m > 0.3:
            break
        pose = moved(pose, action)
    return pose


@pytest.mark.parametrize(
    ("gap_m", "middle_m"), [(0.46, 0.05), (0.44, 0.05), (0.44, 0.11), (0.42, 0.03)]
)
def test_whole_steps_are_combined_to_pass_where_none_of_them_does(gap_m: float, middle_m: float):
    terrain, field = hall(gap_m, middle_m)
    pose, best_m = START, field.at(*START.xy)
    assert follows(terrain, field, pose).x_m < 0.3
    for _ in range(5):
        way = through(terrain, field, pose, RADIUS_M, best_m)
        assert clear(terrain, pose, way.actions, RADIUS_M)
        for action in way.actions:
            pose = moved(pose, action)
            assert clearance_between(terrain, pose.xy) >= RADIUS_M
        assert pose.xy == pytest.approx(way.nearest_xy)
        assert field.at(*pose.xy) <= best_m - GAIN_M
        best_m = field.at(*pose.xy)
        if pose.x_m > 0.3:
            break
    assert pose.x_m > 0.3


def test_where_no_steps_lead_on_the_nearest_place_is_told():
    narrow, _ = hall(0.36, 0.08)
    _, field = hall(0.8, 0.08)  # of a planner that believes in more room than there is
    way = through(narrow, field, START, RADIUS_M, field.at(-0.3, 0.08))
    assert way.actions == ()
    assert -0.6 < way.nearest_xy[0] < -0.2
    assert clearance_between(narrow, np.array(way.nearest_xy)) >= RADIUS_M


def test_a_way_is_no_way_any_more_when_something_stands_there():
    terrain, field = hall(0.46, 0.05)
    way = through(terrain, field, START, RADIUS_M, field.at(*START.xy))
    assert not clear(hall(0.36, 0.05)[0], Pose(-0.2, 0.0, 0.0), [Action.MOVE_FORWARD], RADIUS_M)
    assert not clear(terrain, Pose(-1.9, 0.0, math.pi), [Action.MOVE_FORWARD], RADIUS_M)
    assert clear(terrain, START, way.actions, RADIUS_M)


def test_the_sources_are_near_enough():
    terrain, field = hall(0.8, 0.0)
    way = through(terrain, field, Pose(1.25, 0.0, 0.0), RADIUS_M, 0.1)
    assert way.actions == (Action.MOVE_FORWARD,)
