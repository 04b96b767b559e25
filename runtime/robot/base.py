"""What a base is to the runtime: a velocity that expires goes in, what was really sent comes back.

The ROS 2 base is `bus.Bus`, one on MAVLink `mavlink.base.MavlinkBase`; one on another wire is a
class beside them. Every base keeps to this: an order that came too late is not sent; while somebody
else has the sticks nothing is sent that would be obeyed, not even zero, but to stop on MAVLink what
was moving; and what keeps it from driving is said, not worked around.
"""

from dataclasses import dataclass
from typing import Protocol

from runtime.core.types import Twist

ORDER_S = 0.3  # how long an order is worth sending: a few ticks of the control loop


@dataclass(frozen=True)
class DriveOrder:
    """A velocity for the base. `stamp_ns`: of the robot's own clock, 0 where it is not known;
    `expires_s`: monotonic, after which it must not be sent any more; `searching`: a search wants
    to drive, without which nothing is armed and no mode is asked for; `last`: no other follows, so
    that a wire that is full is waited for, where else the order is dropped."""

    twist: Twist
    stamp_ns: int
    expires_s: float
    searching: bool = False
    last: bool = False

    def late(self, now_s: float) -> str:
        """Why it must not be sent any more; "" when it may."""
        over_s = now_s - self.expires_s
        return f"the order came {over_s:.2f} s too late" if over_s > 0 else ""


@dataclass(frozen=True)
class Sent:
    """What went out on the wire: not always what was ordered. `twist`: None when nothing did;
    `why`: what kept the order from going out as it was, else ""."""

    twist: Twist | None
    why: str = ""


@dataclass(frozen=True)
class BaseCondition:
    """What the base says of itself. `held`: why it cannot be driven now (not armed, no link), ""
    when it can; `hand`: who else has the sticks, "" when nobody; `battery_percent`: 0 to 100, None
    when that is not known; `said`: what it warned of lately, in its own words; `bad`: messages of
    it that could not be read."""

    held: str = ""
    hand: str = ""
    battery_percent: float | None = None
    said: str = ""
    bad: int = 0


WELL = BaseCondition()


class Base(Protocol):
    """What drives the robot. Every method may be called from any thread, and waits for nothing,
    but with a last order for the wire."""

    def drive(self, order: DriveOrder) -> Sent:
        """Send a velocity on. RfNavError when the wire is broken."""
        ...

    def condition(self) -> BaseCondition: ...
