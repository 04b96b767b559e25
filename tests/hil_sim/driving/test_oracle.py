"""The shortest way in the robot's own actions: it arrives, hardly longer than geodesic."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil_sim.driving.link import HarnessError
from hil_sim.driving.oracle import ShortestPath, shortest_way
from hil_sim.ground_truth.freespace import FreeSpace
from hil_sim.scenes.format import Room, Scene
from hil_sim.simulation.protocol import HM3D
from hil_sim.simulation.robot import Robot, act
from runtime.core.types import Action, Pose

SCENE = Scene("two", (), (), (Room("all", "hall", ((0, 0), (6, 0), (6, 3), (0, 3))),), ())


def two_rooms(door: bool = True) -> FreeSpace:
    """6 x 3 m; a wall at x = 3, with an opening at y 1 to 2."""
    free = np.zeros((60, 120), bool)
    free[4:56, 4:116] = True
    free[:, 56:64] = False
    if door:
        free[24:36, 56:64] = True
    return FreeSpace(SCENE, (0.0, 0.0), free)


@dataclass
class Floor:
    """What the robot drives on, here the free cells themselves."""

    space: FreeSpace

    def move(self, x: float, y: float, yaw: float, distance: float) -> tuple[float, float, bool]:
        end = x + distance * math.cos(yaw), y + distance * math.sin(yaw)
        return (*end, False) if self.space.is_free(*end) else (x, y, True)

    def falls(self, x: float, y: float) -> bool:
        return False


def drive(space: FreeSpace, success: np.ndarray, start: Pose, push: float = 0.0) -> Robot:
    """Follow the oracle's answers; `push` m to the side after the third step."""
    robot = Robot(start)
    oracle = ShortestPath(space, success, HM3D, lambda: robot.pose, lambda pose: math.pi / 2)
    for step in range(200):
        robot = act(robot, oracle.exchange().action, Floor(space), HM3D)
        if step == 2 and push:
            moved = Pose(robot.pose.x_m, robot.pose.y_m + push, robot.pose.yaw_rad)
            robot = Robot(moved, robot.path_m, robot.collisions)
        if robot.stopped:
            return robot
    raise AssertionError("it never stopped")


SUCCESS = np.array([(row, col) for row in range(48, 56) for col in range(100, 112)])


@settings(max_examples=15, deadline=None)
@given(st.floats(0.25, 2.7), st.floats(0.25, 2.7), st.integers(0, 11), st.sampled_from([0.0, 0.03]))
def test_it_arrives_without_a_touch_and_faces_the_goal(
    x: float, y: float, turns: int, push: float
) -> None:
    space = two_rooms()
    start = Pose(x, y, math.remainder(turns * HM3D.turn_rad, math.tau))
    robot = drive(space, SUCCESS, start, push)
    field = space.distance_field(space.points(SUCCESS))
    assert robot.collisions == 0
    assert space.distance(field, robot.pose.x_m, robot.pose.y_m) == 0.0
    assert (
        abs(math.remainder(robot.pose.yaw_rad - math.pi / 2, math.tau)) < HM3D.turn_rad / 2 + 0.01
    )
    assert robot.path_m <= 1.15 * space.distance(field, x, y) + 2 * HM3D.step_m


def test_its_steps_are_the_robots_own() -> None:
    space = two_rooms()
    field = space.distance_field(space.points(SUCCESS))
    way = shortest_way(space, field, Pose(1.0, 1.5, 0.0), HM3D)
    assert way[-1][1] is Action.STOP
    assert all(action is not Action.STOP for _, action in way[:-1])
    robot = Robot(Pose(1.0, 1.5, 0.0))
    for pose, action in way:
        assert math.hypot(pose.x_m - robot.pose.x_m, pose.y_m - robot.pose.y_m) < 1e-9
        robot = act(robot, action, Floor(space), HM3D)


def test_no_way_is_an_error() -> None:
    with pytest.raises(HarnessError, match="no way in the robot's own steps"):
        drive(two_rooms(door=False), SUCCESS, Pose(1.0, 1.5, 0.0))
