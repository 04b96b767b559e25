"""The robot's body in a scene: discrete actions, moved kinematically, without sliding."""

import math
from dataclasses import dataclass, replace
from typing import Protocol as Port

import numpy as np

from hil_sim.simulation.protocol import Protocol
from runtime.core.types import Action, Pose, Twist

# RoboTHOR's motion noise, for `Noise.motion` 1 (FACTS: robothor-challenge 2021).
MOVE_BIAS_M, MOVE_SIGMA_M = 0.001, 0.005
TURN_SIGMA_RAD = math.radians(0.5)
HEADING_SIGMA_RAD = math.radians(0.25)  # of a move
STRAY_TURN = 0.5
"""How much of a metre's sigma, in rad, a straight metre turns the heading."""
FALL_STEP_M = 0.02
STILL = Twist()


class Ground(Port):
    """What a world must do for a robot to drive in it."""

    def move(
        self, x_m: float, y_m: float, yaw_rad: float, distance_m: float
    ) -> tuple[float, float, bool]:
        """Sweep the body ahead: where it ends, and whether it hit something."""
        ...

    def falls(self, x_m: float, y_m: float) -> bool:
        """Whether a body that stands there has left the floor."""
        ...


@dataclass(frozen=True)
class Robot:
    """Where the robot is (scene frame), and what it did to get there.

    `collisions` count moves that ended at an obstacle; on a continuous base, how often it ran into
    one.
    """

    pose: Pose
    path_m: float = 0.0
    collisions: int = 0
    stopped: bool = False  # the runtime said stop
    reckoned: Pose | None = None  # where odometry puts it, scene frame; None: where it is
    twist: Twist = STILL  # of a continuous base: how fast it goes
    order: Twist = STILL  # ... what it was told last
    order_left_s: float = 0.0  # ... and until when that counts
    touched_xy: tuple[float, float] | None = None  # where it ran into what it still touches
    fell: bool = False  # it left the floor, and moves no more

    @property
    def over(self) -> bool:
        """Whether there is nothing more to be done."""
        return self.stopped or self.fell

    @property
    def touching(self) -> bool:
        """What a bumper says."""
        return self.touched_xy is not None

    def odometry(self, start: Pose) -> Pose:
        """The reported pose seen from `start`: the map frame, x forward at the start."""
        at = self.reckoned or self.pose
        dx, dy = at.x_m - start.x_m, at.y_m - start.y_m
        c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
        yaw = wrapped(at.yaw_rad - start.yaw_rad)
        return Pose(c * dx + s * dy, c * dy - s * dx, yaw)


def act(
    robot: Robot,
    action: Action,
    world: Ground,
    protocol: Protocol,
    rng: np.random.Generator | None = None,
) -> Robot:
    """The robot after one action. `path_m` grows by what was really driven; `rng` is needed for
    noise: N(0.001, 0.005) m and 0.25 degrees of heading a move, 0.5 degrees a turn, times
    `protocol.noise.motion`."""
    draw = rng.standard_normal(3) if rng is not None else np.zeros(3)
    amount = protocol.noise.motion if rng is not None else 0.0
    x, y, yaw = robot.pose.x_m, robot.pose.y_m, robot.pose.yaw_rad
    match action:
        case Action.STOP:
            return replace(robot, stopped=True)
        case Action.MOVE_FORWARD:
            yaw = wrapped(yaw + amount * HEADING_SIGMA_RAD * float(draw[0]))
            length = protocol.step_m + amount * (MOVE_BIAS_M + MOVE_SIGMA_M * float(draw[1]))
            new_x, new_y, hit = world.move(x, y, yaw, length)
            new_x, new_y, fell = until_it_falls(world, (x, y), (new_x, new_y))
            moved = replace(
                robot,
                pose=Pose(new_x, new_y, yaw),
                path_m=robot.path_m + math.hypot(new_x - x, new_y - y),
                collisions=robot.collisions + int(hit),
                touched_xy=(new_x, new_y) if hit else None,
                fell=fell,
            )
        case Action.TURN_LEFT | Action.TURN_RIGHT:
            turn = protocol.turn_rad if action is Action.TURN_LEFT else -protocol.turn_rad
            turn += amount * TURN_SIGMA_RAD * float(draw[2])
            moved = replace(robot, pose=Pose(x, y, wrapped(yaw + turn)))
    if rng is None or not protocol.noise.drift:
        return moved
    return replace(moved, reckoned=reckon(robot, moved.pose, protocol.noise.drift, rng))


def until_it_falls(
    world: Ground, start: tuple[float, float], end: tuple[float, float]
) -> tuple[float, float, bool]:
    """How far a straight way between two points leads on floor, and whether that ends on it."""
    steps = max(1, math.ceil(math.dist(start, end) / FALL_STEP_M))
    for n in range(1, steps + 1):
        x, y = (a + (b - a) * n / steps for a, b in zip(start, end, strict=True))
        if world.falls(x, y):
            return x, y, True
    return *end, False


def reckon(before: Robot, now: Pose, drift: float, rng: np.random.Generator) -> Pose:
    """Where odometry puts the robot after a move from `before.pose` to `now`: the true motion,
    which `stray` spoils, added to what it believed before."""
    was, at = before.pose, before.reckoned or before.pose
    dx, dy = now.x_m - was.x_m, now.y_m - was.y_m
    c, s = math.cos(was.yaw_rad), math.sin(was.yaw_rad)
    ahead, left = c * dx + s * dy, c * dy - s * dx
    turn = wrapped(now.yaw_rad - was.yaw_rad)
    extra, veer = stray(ahead, turn, drift, rng)
    ahead, turn = ahead + extra, turn + veer
    c, s = math.cos(at.yaw_rad), math.sin(at.yaw_rad)
    yaw = wrapped(at.yaw_rad + turn)
    return Pose(at.x_m + c * ahead - s * left, at.y_m + s * ahead + c * left, yaw)


def stray(
    ahead_m: float, turn_rad: float, sigma: float, rng: np.random.Generator
) -> tuple[float, float]:
    """What a motion errs by: variances grow with the way, so that the sigmas are `sigma` m after
    1 m, `sigma` rad after 1 rad, and half of that in heading after a straight metre."""
    first, second = rng.standard_normal(2)
    way = abs(ahead_m)
    return (
        float(first) * sigma * math.sqrt(way),
        float(second) * sigma * math.sqrt(abs(turn_rad) + STRAY_TURN**2 * way),
    )


def wrapped(angle_rad: float) -> float:
    """Into (-pi, pi]."""
    angle = math.remainder(angle_rad, math.tau)
    return math.pi if angle == -math.pi else angle
