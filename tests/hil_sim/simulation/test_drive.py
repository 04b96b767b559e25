"""The differential drive: limits, watchdog, collisions, slip and drift."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.simulation.drive import SUBSTEP_S, drive, ordered, still
from hil_sim.simulation.noise import NONE, Noise
from hil_sim.simulation.protocol import HM3D, DifferentialDrive
from hil_sim.simulation.robot import Robot, act, reckon
from runtime.core.types import Action, Pose, Twist

BASE = DifferentialDrive()
HERE = Robot(Pose(0.0, 0.0, 0.0))


class Walled:
    """Open ground up to a wall at x = 1; a body in front of it stays there."""

    def move(self, x: float, y: float, yaw: float, distance: float) -> tuple[float, float, bool]:
        ahead = x + distance * math.cos(yaw)
        if ahead > 1.0:
            return x, y, True
        return ahead, y + distance * math.sin(yaw), False

    def falls(self, x: float, y: float) -> bool:
        """The floor ends at y = 5."""
        return y > 5.0


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def roll(robot: Robot, seconds: float, noise: Noise = NONE, seed: int = 0) -> Robot:
    return drive(robot, seconds, Walled(), BASE, noise, rng(seed))


def test_speed_builds_up_within_the_acceleration() -> None:
    robot = roll(ordered(HERE, Twist(0.5, 0.0), BASE), 0.2)
    assert robot.twist.v_mps == pytest.approx(0.2 * BASE.accel_mps2)
    assert robot.pose.x_m == pytest.approx(0.5 * BASE.accel_mps2 * 0.2**2, rel=0.15)
    assert robot.path_m == pytest.approx(robot.pose.x_m)


@given(st.floats(-99, 99), st.floats(-99, 99), st.integers(1, 30))
def test_limits_hold_whatever_is_ordered(v: float, w: float, substeps: int) -> None:
    before = ordered(HERE, Twist(v, w), BASE)
    after = roll(before, substeps * SUBSTEP_S)
    reached = min(BASE.speed_mps, BASE.accel_mps2 * substeps * SUBSTEP_S)
    assert abs(after.twist.v_mps) <= reached + 1e-9
    assert abs(after.twist.w_radps) <= BASE.turn_radps
    assert -math.pi < after.pose.yaw_rad <= math.pi


def test_an_order_expires_after_half_a_second_and_the_base_brakes() -> None:
    moving = roll(ordered(HERE, Twist(0.3, 0.0), BASE), 0.5)
    assert moving.twist.v_mps == pytest.approx(0.3)
    assert not still(moving)
    braking = roll(moving, 0.1)
    assert braking.twist.v_mps == pytest.approx(0.3 - 0.1 * BASE.accel_mps2)
    assert still(roll(braking, 0.5))


def test_an_order_that_is_repeated_does_not_expire() -> None:
    robot = HERE
    for _ in range(5):
        robot = roll(ordered(robot, Twist(0.1, 0.0), BASE), 0.4)
    assert robot.twist.v_mps == pytest.approx(0.1)


def test_a_curve_is_a_circle() -> None:
    robot = replace(HERE, twist=Twist(0.2, 0.5))
    for _ in range(4):
        robot = roll(ordered(robot, Twist(0.2, 0.5), BASE), math.pi / 2)  # half a turn in all
        robot = replace(robot, order_left_s=9.0)
    assert math.hypot(robot.pose.x_m, robot.pose.y_m - 0.4) == pytest.approx(0.4, abs=0.15)


def test_a_wall_stops_it_once_and_it_may_still_turn() -> None:
    robot = replace(HERE, pose=Pose(0.95, 0.0, 0.0))
    for _ in range(5):
        robot = roll(ordered(robot, Twist(0.4, 1.0), BASE), 0.2)
    assert robot.collisions == 1
    assert robot.touching
    assert robot.pose.x_m <= 1.0
    assert robot.twist.w_radps == pytest.approx(1.0)
    away = roll(ordered(replace(robot, pose=Pose(0.95, 0.0, math.pi)), Twist(0.4, 0.0), BASE), 0.4)
    assert not away.touching
    again = replace(away, pose=Pose(0.98, 0.0, 0.0))
    assert roll(ordered(again, Twist(0.4, 0.0), BASE), 0.4).collisions == 2


def test_slip_moves_the_robot_and_drift_only_what_it_believes() -> None:
    order = ordered(HERE, Twist(0.4, 0.3), BASE)
    true = roll(order, 0.5)
    slipped, drifted = roll(order, 0.5, Noise(slip=0.02)), roll(order, 0.5, Noise(drift=0.02))
    assert slipped.pose != true.pose
    assert slipped.odometry(HERE.pose) == slipped.pose  # exact, for it slipped where it says
    assert drifted.pose == true.pose
    assert drifted.odometry(HERE.pose) != true.odometry(HERE.pose)


def test_sigmas_are_those_of_a_metre() -> None:
    ends = []
    for seed in range(300):
        robot, random = HERE, rng(seed)
        for _ in range(10):
            now = replace(robot, pose=Pose(robot.pose.x_m + 0.1, 0.0, 0.0))
            robot = replace(now, reckoned=reckon(robot, now.pose, 0.02, random))
        ends.append(robot.odometry(HERE.pose))
    assert np.std([end.x_m for end in ends]) == pytest.approx(0.02, rel=0.2)
    assert np.std([end.yaw_rad for end in ends]) == pytest.approx(0.01, rel=0.2)


@pytest.mark.parametrize("noise", [Noise(slip=0.02), Noise(drift=0.02), Noise(slip=0.1, drift=0.1)])
def test_the_same_seed_drives_the_same_way(noise: Noise) -> None:
    order = ordered(HERE, Twist(0.4, 0.7), BASE)
    assert roll(order, 0.4, noise, 3) == roll(order, 0.4, noise, 3)
    assert roll(order, 0.4, noise, 3) != roll(order, 0.4, noise, 4)


def test_robothors_noise_has_its_sigmas() -> None:
    protocol = replace(HM3D, noise=Noise(motion=1.0))

    class Open:
        def move(self, x: float, y: float, yaw: float, d: float) -> tuple[float, float, bool]:
            return x + d * math.cos(yaw), y + d * math.sin(yaw), False

        def falls(self, x: float, y: float) -> bool:
            return False

    ground = Open()
    moves = [act(HERE, Action.MOVE_FORWARD, ground, protocol, rng(seed)) for seed in range(600)]
    turns = [act(HERE, Action.TURN_LEFT, ground, protocol, rng(seed)) for seed in range(600)]
    lengths = [m.path_m for m in moves]
    assert np.mean(lengths) == pytest.approx(0.251, abs=0.001)
    assert np.std(lengths) == pytest.approx(0.005, rel=0.15)
    assert np.std([m.pose.yaw_rad for m in moves]) == pytest.approx(math.radians(0.25), rel=0.15)
    turned = [t.pose.yaw_rad for t in turns]
    assert np.mean(turned) == pytest.approx(math.radians(30), abs=0.002)
    assert np.std(turned) == pytest.approx(math.radians(0.5), rel=0.15)
    assert all(m.odometry(HERE.pose) == m.pose for m in moves)  # as the challenge's GPS
