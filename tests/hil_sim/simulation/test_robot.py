"""The kinematic robot and the protocol's sensor."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.simulation.protocol import HM3D, Ending, protocol_named
from hil_sim.simulation.robot import Robot, act
from runtime.core.types import Action, Pose
from runtime.errors import ConfigError

POSES = st.builds(Pose, st.floats(-9, 9), st.floats(-9, 9), st.floats(-3.14, 3.14))


class Walled:
    """Open ground up to a wall at x = 1."""

    def move(self, x: float, y: float, yaw: float, distance: float) -> tuple[float, float, bool]:
        ahead = x + distance * math.cos(yaw)
        hit = ahead > 1.0
        return min(ahead, 1.0), y + distance * math.sin(yaw), hit

    def falls(self, x: float, y: float) -> bool:
        """The floor ends at y = 5."""
        return y > 5.0


def test_a_step_a_turn_and_a_stop() -> None:
    robot = Robot(Pose(0, 0, 0))
    robot = act(robot, Action.MOVE_FORWARD, Walled(), HM3D)
    assert (robot.pose.x_m, robot.path_m, robot.collisions) == (0.25, 0.25, 0)
    robot = act(robot, Action.TURN_LEFT, Walled(), HM3D)
    assert math.degrees(robot.pose.yaw_rad) == pytest.approx(30)
    robot = act(act(robot, Action.TURN_RIGHT, Walled(), HM3D), Action.TURN_RIGHT, Walled(), HM3D)
    assert math.degrees(robot.pose.yaw_rad) == pytest.approx(-30)
    assert not robot.stopped
    assert act(robot, Action.STOP, Walled(), HM3D).stopped


def test_a_wall_stops_the_robot_and_only_the_way_driven_counts() -> None:
    robot = Robot(Pose(0.9, 0, 0))
    robot = act(robot, Action.MOVE_FORWARD, Walled(), HM3D)
    assert robot.path_m == pytest.approx(0.1)
    assert robot.collisions == 1
    robot = act(robot, Action.MOVE_FORWARD, Walled(), HM3D)
    assert robot.path_m == pytest.approx(0.1)
    assert robot.collisions == 2


@given(POSES)
def test_twelve_turns_are_a_full_one(pose: Pose) -> None:
    robot = Robot(pose)
    for _ in range(12):
        robot = act(robot, Action.TURN_LEFT, Walled(), HM3D)
        assert -math.pi < robot.pose.yaw_rad <= math.pi
    assert abs(math.remainder(robot.pose.yaw_rad - pose.yaw_rad, math.tau)) < 1e-9


@given(POSES, POSES)
def test_odometry_is_the_rigid_motion_from_the_start(start: Pose, pose: Pose) -> None:
    seen = Robot(pose).odometry(start)
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    assert start.x_m + c * seen.x_m - s * seen.y_m == pytest.approx(pose.x_m, abs=1e-9)
    assert start.y_m + s * seen.x_m + c * seen.y_m == pytest.approx(pose.y_m, abs=1e-9)
    assert abs(math.remainder(start.yaw_rad + seen.yaw_rad - pose.yaw_rad, math.tau)) < 1e-9


def test_ahead_of_the_start_is_x_and_left_of_it_is_y() -> None:
    start = Pose(3, 4, math.pi / 2)
    assert Robot(start).odometry(start) == Pose(0, 0, 0)
    ahead = Robot(Pose(3, 5, math.pi / 2)).odometry(start)
    assert [ahead.x_m, ahead.y_m] == pytest.approx([1, 0])
    left = Robot(Pose(2, 4, math.pi / 2)).odometry(start)
    assert [left.x_m, left.y_m] == pytest.approx([0, 1])


def test_depth_outside_the_sensors_range_reads_0() -> None:
    depth = np.array([[0.0, 0.4, 0.5, 4.9, 5.0, 5.1]], np.float32)
    np.testing.assert_array_equal(
        HM3D.sensed(depth), np.array([[0, 0, 0.5, 4.9, 5.0, 0]], np.float32)
    )


def test_the_camera_of_the_protocol() -> None:
    k = HM3D.intrinsics
    assert (k.width, k.height, k.cx, k.cy) == (640, 480, 320, 240)
    assert k.fx == k.fy == pytest.approx(320 / math.tan(math.radians(39.5)))


def test_success_needs_a_stop_within_10_cm() -> None:
    assert HM3D.success(Ending(True, 0.1))
    assert not HM3D.success(Ending(True, 0.11))
    assert not HM3D.success(Ending(False, 0.0))
    assert not HM3D.success(Ending(True, math.inf))


def test_an_unknown_protocol_is_named_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="protocol hm4d: unknown; known: hm3d"):
        protocol_named("hm4d")


def test_a_step_that_leaves_the_floor_ends_where_it_does() -> None:
    robot = act(Robot(Pose(0, 4.9, math.pi / 2)), Action.MOVE_FORWARD, Walled(), HM3D)
    assert robot.fell
    assert robot.over
    assert 5.0 < robot.pose.y_m < 5.03
    assert robot.path_m == pytest.approx(robot.pose.y_m - 4.9)
