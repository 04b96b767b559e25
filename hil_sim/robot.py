"""The robot's body in a scene: discrete actions, moved kinematically, without sliding."""

import math
from dataclasses import dataclass, replace
from typing import Protocol as Port

from hil_sim.protocol import Protocol
from runtime.core.types import Action, Pose


class Ground(Port):
    """What a world must do for a robot to drive in it."""

    def move(
        self, x_m: float, y_m: float, yaw_rad: float, distance_m: float
    ) -> tuple[float, float, bool]:
        """Sweep the body ahead: where it ends, and whether it hit something."""
        ...


@dataclass(frozen=True)
class Robot:
    """Where the robot is (scene frame), and what it did to get there."""

    pose: Pose
    path_m: float = 0.0
    collisions: int = 0
    stopped: bool = False

    def odometry(self, start: Pose) -> Pose:
        """The pose seen from `start`: the map frame, x forward at the start of the episode."""
        dx, dy = self.pose.x_m - start.x_m, self.pose.y_m - start.y_m
        c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
        yaw = _wrapped(self.pose.yaw_rad - start.yaw_rad)
        return Pose(c * dx + s * dy, c * dy - s * dx, yaw)


def act(robot: Robot, action: Action, world: Ground, protocol: Protocol) -> Robot:
    """The robot after one action. `path_m` grows by what was really driven."""
    x, y, yaw = robot.pose.x_m, robot.pose.y_m, robot.pose.yaw_rad
    match action:
        case Action.STOP:
            return replace(robot, stopped=True)
        case Action.MOVE_FORWARD:
            new_x, new_y, hit = world.move(x, y, yaw, protocol.step_m)
            return replace(
                robot,
                pose=Pose(new_x, new_y, yaw),
                path_m=robot.path_m + math.hypot(new_x - x, new_y - y),
                collisions=robot.collisions + int(hit),
            )
        case Action.TURN_LEFT | Action.TURN_RIGHT:
            turn = protocol.turn_rad if action is Action.TURN_LEFT else -protocol.turn_rad
            return replace(robot, pose=Pose(x, y, _wrapped(yaw + turn)))


def _wrapped(angle_rad: float) -> float:
    """Into (-pi, pi]."""
    angle = math.remainder(angle_rad, math.tau)
    return math.pi if angle == -math.pi else angle
