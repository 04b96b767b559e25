"""A differential drive in a scene: velocity commands, limits, slip, and a watchdog."""

import math
from dataclasses import replace

import numpy as np

from hil_sim.simulation.noise import Noise
from hil_sim.simulation.protocol import DifferentialDrive
from hil_sim.simulation.robot import Ground, Robot, reckon, stray, until_it_falls, wrapped
from runtime.core.types import Pose, Twist

SUBSTEP_S = 0.02
APART_M = 0.02
"""A base that has come this far from where it ran into something has left it."""
STILL_MPS, STILL_RADPS = 1e-3, 1e-3


def ordered(robot: Robot, order: Twist, base: DifferentialDrive) -> Robot:
    """The robot, told a new velocity; it counts until the watchdog expires."""
    order = Twist(_within(order.v_mps, base.speed_mps), _within(order.w_radps, base.turn_radps))
    return replace(robot, order=order, order_left_s=base.watchdog_s)


def drive(
    robot: Robot,
    seconds: float,
    ground: Ground,
    base: DifferentialDrive,
    noise: Noise,
    rng: np.random.Generator,
) -> Robot:
    """Let time pass: the base follows its last order as its limits allow, in substeps of 20 ms
    whose way is swept. What it hits stops it; it does not slide, but a round body may turn. Where
    the floor ends it falls, and stays."""
    steps = max(1, round(seconds / SUBSTEP_S))
    for _ in range(steps):
        if robot.fell:
            break
        robot = _substep(robot, seconds / steps, ground, base, noise, rng)
    return robot


def still(robot: Robot) -> bool:
    """Whether the base stands."""
    return abs(robot.twist.v_mps) < STILL_MPS and abs(robot.twist.w_radps) < STILL_RADPS


def _substep(
    robot: Robot,
    dt: float,
    ground: Ground,
    base: DifferentialDrive,
    noise: Noise,
    rng: np.random.Generator,
) -> Robot:
    wished = robot.order if robot.order_left_s > 1e-9 else Twist()
    v = _toward(robot.twist.v_mps, wished.v_mps, base.accel_mps2 * dt)
    w = _toward(robot.twist.w_radps, wished.w_radps, base.turn_accel_radps2 * dt)
    way, turn = v * dt, w * dt
    if noise.slip:
        extra, veer = stray(way, turn, noise.slip, rng)
        way, turn = way + extra, turn + veer
    x, y, yaw = robot.pose.x_m, robot.pose.y_m, robot.pose.yaw_rad
    new_x, new_y, hit = x, y, False
    if way:
        new_x, new_y, hit = ground.move(x, y, yaw + turn / 2, way)  # along the arc's chord
    new_x, new_y, fell = until_it_falls(ground, (x, y), (new_x, new_y))
    moved = replace(
        robot,
        pose=Pose(new_x, new_y, wrapped(yaw + turn)),
        path_m=robot.path_m + math.hypot(new_x - x, new_y - y),
        collisions=robot.collisions + int(hit and not robot.touching),
        touched_xy=_touched(robot, new_x, new_y, hit),
        twist=Twist() if fell else Twist(0.0 if hit else v, w),
        order_left_s=max(0.0, robot.order_left_s - dt),
        fell=fell,
    )
    if noise.drift:
        moved = replace(moved, reckoned=reckon(robot, moved.pose, noise.drift, rng))
    return moved


def _touched(robot: Robot, x_m: float, y_m: float, hit: bool) -> tuple[float, float] | None:
    """A base that pushes against a wall creeps up to it: that is one collision."""
    if hit and robot.touched_xy is None:
        return x_m, y_m
    if robot.touched_xy is None or math.dist(robot.touched_xy, (x_m, y_m)) > APART_M:
        return (x_m, y_m) if hit else None
    return robot.touched_xy


def _toward(value: float, wished: float, most: float) -> float:
    return value + _within(wished - value, most)


def _within(value: float, most: float) -> float:
    return max(-most, min(most, value))
