"""A person who has taken the sticks: what the base is told then, and what is heard of it."""

from dataclasses import dataclass

from hil_sim.simulation.faults import Fault
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


@dataclass
class Sticks:
    """They are taken and let go; `now_s` is monotonic."""

    _since_s: float | None = None
    _spoke_s: float = -1.0

    def twist(self, fault: Fault | None, robot: Robot, now_s: float) -> Twist | None:
        """What they tell the base, which then hears nobody else; None without a hand on them."""
        if fault is None:
            self._since_s = None
            return None
        self._since_s = now_s if self._since_s is None else self._since_s
        return by_hand(robot, now_s - self._since_s, fault.size)

    def speak(self, now_s: float) -> bool:
        """Whether it is time for their next message."""
        speaks = now_s - self._spoke_s >= SPEAKS_S
        self._spoke_s = now_s if speaks else self._spoke_s
        return speaks
