"""The stand-in rover on the wall clock, on a floor without walls."""

import math
import threading
import time
from collections.abc import Callable
from contextlib import suppress

from hil_sim.driving.base_wires import MavlinkWire
from hil_sim.simulation.rover_stand_in import RoverStandIn
from runtime.core.types import Pose, Twist

TURN_S = 0.01
PATIENCE_S = 30.0


class RoverDouble:
    """`mute`: it hears, and says nothing. `velocities`: what it drove."""

    def __init__(self, rover: RoverStandIn | None = None) -> None:
        self.rover = rover or RoverStandIn()
        self.rover.every_s[0] = 0.2  # a heartbeat five times as often, for tests to be over sooner
        self.wire = MavlinkWire(self.rover)
        self.pose, self.mute = Pose(0.0, 0.0, 0.0), False
        self.velocities: list[Twist] = [Twist()]
        self.link = self.wire.address
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> "RoverDouble":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()
        with suppress(OSError):
            self.wire.__exit__()

    def _run(self) -> None:
        last_s = time.monotonic()
        while not self._ending.wait(TURN_S):
            now_s = time.monotonic()
            dt, last_s = now_s - last_s, now_s
            twist = self.wire.command(now_s) or Twist()
            self.velocities.append(twist)
            yaw = self.pose.yaw_rad + twist.w_radps * dt
            x = self.pose.x_m + twist.v_mps * dt * math.cos(yaw)
            y = self.pose.y_m + twist.v_mps * dt * math.sin(yaw)
            self.pose = Pose(x, y, math.remainder(yaw, math.tau))
            if not self.mute:
                self.wire.report(self.pose, 0, now_s)


def until(what: Callable[[], object], seconds: float = PATIENCE_S) -> None:
    """Wait for something to become true."""
    by_s = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < by_s, "it does not come"
        time.sleep(0.01)
