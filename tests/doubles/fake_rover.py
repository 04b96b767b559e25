"""A runtime of real time in few lines, run as a child process: drives 0.6 m straight ahead, then
says that it has found what it was sent for. python fake_rover.py MODE --set ...

MODE: find (that), lose (never says anything about the end).
"""

import sys
import tomllib
from typing import Any

from runtime.clock import SystemClock
from runtime.core.types import Twist
from runtime.robot.base import ORDER_S, DriveOrder
from runtime.robot.bus import Bus, BusConfig

SPEED_MPS, WAY_M = 0.4, 0.6


def connect() -> tuple[str, ...]:
    found: Any = next(a for a in sys.argv if a.startswith("bus.connect="))
    return tuple(tomllib.loads(found.replace("bus.connect", "v"))["v"])


def main() -> None:
    mode, state, frames, clock = sys.argv[1], "ready", 0, SystemClock()
    with Bus(BusConfig(connect=connect()), clock) as bus:
        while True:
            frames += bus.next(0.05) is not None
            request = bus.request()
            if request is not None and request.kind == "goal":
                state, frames = "searching", 0
                request.reply({"accepted": True})
            elif request is not None and request.kind == "status":
                request.reply({"state": state})
            elif request is not None:
                request.reply({"seconds": {"frames": float(frames)}})
            newest = bus.pose()
            if state == "ready" or newest is None:
                continue
            stamped, arrival_s = newest
            if mode == "find" and stamped.value.x_m >= WAY_M:
                state = "found"
            driving = state == "searching" and clock.now_s() - arrival_s < 0.3 and frames > 0
            twist = Twist(SPEED_MPS if driving else 0.0, 0.0)
            bus.drive(DriveOrder(twist, 0, clock.now_s() + ORDER_S))
            if state == "found":
                bus.publish_state({"state": state, "reason": "found it"})
            else:
                bus.publish_state({"state": state, "mode": "target", "toward_xy": [1.5, 0.0]})


if __name__ == "__main__":
    main()
