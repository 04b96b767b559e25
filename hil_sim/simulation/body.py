"""Bodies that no scene has: a person who walks through the home, a door that closes."""

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from hil_sim.scenes.format import Door, Scene
from hil_sim.simulation.robot import Ground
from runtime.core.types import Pose

PERSON_RADIUS_M, PERSON_HEIGHT_M = 0.2, 1.7
DOOR_DEPTH_M = 0.05
ROUND = ("person", "leg")
WALK_M = 0.1
"""A person's step, in which the way ahead is looked at once."""
NEAR_M, FAR_M = 0.8, 3.0
"""How far from the robot a person appears."""
OPENING_M, OPENING_DEEP_M = 0.8, 1.2
OPENING_AHEAD_M = 2.2
"""From the robot's middle to that of an opening: farther than what a level camera cannot see."""
POLITE_M = 0.55
"""A person does not come closer to the robot's middle than this."""


@dataclass(frozen=True)
class Body:
    """A person or a leg (upright cylinders), a door or a box (upright boxes) on the floor, or an
    opening of the floor, scene frame; `size_m` is width, depth, height, of an opening how deep it
    is."""

    kind: Literal["person", "leg", "door", "box", "opening"]
    x_m: float
    y_m: float
    yaw_rad: float
    size_m: tuple[float, float, float]

    def distance_m(self, x_m: float, y_m: float) -> float:
        """From a point on the plan to the footprint; 0 or less inside."""
        dx, dy = x_m - self.x_m, y_m - self.y_m
        if self.kind in ROUND:
            return math.hypot(dx, dy) - self.size_m[0] / 2
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        across = abs(c * dx + s * dy) - self.size_m[0] / 2
        along = abs(c * dy - s * dx) - self.size_m[1] / 2
        return math.hypot(max(across, 0.0), max(along, 0.0)) + min(max(across, along), 0.0)


def person_near(robot: Pose, ground: Ground, rng: np.random.Generator) -> Body | None:
    """A person in the most open direction around the robot, walking toward it; None when there is
    no place for one."""
    best: tuple[float, float, float, float] | None = None
    turn = float(rng.uniform(-math.pi, math.pi))
    for n in range(12):
        yaw = turn + n * math.tau / 12
        x, y, _ = ground.move(robot.x_m, robot.y_m, yaw, FAR_M)
        far = math.hypot(x - robot.x_m, y - robot.y_m)
        if best is None or far > best[0] + 1e-6:
            best = far, x, y, yaw
    if best is None or best[0] < NEAR_M:
        return None
    _, x, y, yaw = best
    size = (2 * PERSON_RADIUS_M, 2 * PERSON_RADIUS_M, PERSON_HEIGHT_M)
    return Body("person", x, y, math.remainder(yaw + math.pi, math.tau), size)


def walk(person: Body, way_m: float, ground: Ground, robot: Pose, rng: np.random.Generator) -> Body:
    """The person, `way_m` further: straight ahead, and another way where something stands or the
    robot is near. `ground` must not hold the person."""
    for _ in range(max(1, round(way_m / WALK_M))):
        x, y, hit = ground.move(person.x_m, person.y_m, person.yaw_rad, WALK_M)
        now = math.hypot(person.x_m - robot.x_m, person.y_m - robot.y_m)
        then = math.hypot(x - robot.x_m, y - robot.y_m)
        lost = hit or ground.falls(x, y)
        if lost or (then < POLITE_M and then < now):
            person = replace(person, yaw_rad=float(rng.uniform(-math.pi, math.pi)))
        else:
            person = replace(person, x_m=x, y_m=y)
    return person


def opening_ahead(robot: Pose, ground: Ground) -> Body | None:
    """A hole in the floor in the robot's way: straight ahead, or as little to a side as there is
    room for it; None when there is none that it would see in time."""
    half = math.hypot(OPENING_M, OPENING_M) / 2
    for turn in sorted((n * math.radians(15.0) for n in range(-6, 7)), key=abs):
        yaw = robot.yaw_rad + turn
        x, y = (
            at + OPENING_AHEAD_M * way
            for at, way in ((robot.x_m, math.cos(yaw)), (robot.y_m, math.sin(yaw)))
        )
        _, _, hit = ground.move(robot.x_m, robot.y_m, yaw, OPENING_AHEAD_M)
        rims = (yaw + math.pi / 4 + n * math.pi / 2 for n in range(4))
        if not hit and not any(ground.move(x, y, rim, half)[2] for rim in rims):
            return Body("opening", x, y, yaw, (OPENING_M, OPENING_M, OPENING_DEEP_M))
    return None


def closed_door(scene: Scene, robot: Pose, clear_m: float) -> Body | None:
    """The doorway nearest the robot, filled; None while there is none that the robot, `clear_m`
    around its middle, does not stand in."""
    doors = [body_of(door) for door in scene.doors]
    free = [door for door in doors if door.distance_m(robot.x_m, robot.y_m) > clear_m]
    return min(free, key=lambda door: door.distance_m(robot.x_m, robot.y_m), default=None)


def person_in(door: Body) -> Body:
    """A person in the middle of a doorway."""
    size = (2 * PERSON_RADIUS_M, 2 * PERSON_RADIUS_M, PERSON_HEIGHT_M)
    return Body("person", door.x_m, door.y_m, door.yaw_rad, size)


def body_of(door: Door) -> Body:
    """What fills a doorway."""
    (x0, y0), (x1, y1) = door.start, door.end
    size = (math.dist(door.start, door.end), DOOR_DEPTH_M, door.height_m)
    return Body("door", (x0 + x1) / 2, (y0 + y1) / 2, math.atan2(y1 - y0, x1 - x0), size)
