"""A person who has taken the sticks: what the base is told then, and what is heard of it."""

from hil_sim.simulation.robot import Robot
from runtime.core.types import Twist

SPEAKS_S = 0.1  # between two messages of the sticks
TURN_RADPS = 0.8
TURNS_S = 2.0  # first the robot is turned, then driven ahead


def by_hand(robot: Robot, held_s: float, speed_mps: float) -> Twist:
    """The velocity that a hand gives, which has had the sticks for so long: away from where the
    robot was going, and round whatever it runs into."""
    if held_s < TURNS_S or robot.touching:
        return Twist(0.0, TURN_RADPS)
    return Twist(speed_mps, 0.0)
