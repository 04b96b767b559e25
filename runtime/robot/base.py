"""What a base is to the runtime: a velocity that expires goes in, what was really sent comes back.

The ROS 2 base is `bus.Bus`; one on another wire is a class beside it. Every base keeps to this:
an order that came too late is not sent; while somebody else has the sticks nothing is sent, not
even zero; and what keeps it from driving is said, not worked around.
"""

from dataclasses import dataclass
from typing import Literal, Protocol

from runtime.core.keys import key
from runtime.core.types import Twist
from runtime.errors import ConfigError

ORDER_S = 0.3  # how long an order is worth sending: a few ticks of the control loop


@dataclass(frozen=True)
class BaseConfig:
    """[base]: what drives the robot, and how it is told to."""

    drive: Literal["differential", "holonomic", "ackermann"] = key(
        "differential",
        'How it moves. "differential": it turns on the spot. Another is refused, for it would be '
        "driven wrongly.",
    )


@dataclass(frozen=True)
class DriveOrder:
    """A velocity for the base. `stamp_ns`: of the robot's own clock, 0 where it is not known;
    `expires_s`: monotonic, after which it must not be sent any more; `searching`: a search wants
    to drive, without which nothing is armed and no mode is asked for."""

    twist: Twist
    stamp_ns: int
    expires_s: float
    searching: bool = False

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
    when that is not known."""

    held: str = ""
    hand: str = ""
    battery_percent: float | None = None


WELL = BaseCondition()


class Base(Protocol):
    """What drives the robot. Every method may be called from any thread, and waits for nothing
    but the wire."""

    def drive(self, order: DriveOrder) -> Sent:
        """Send a velocity on. RfNavError when the wire is broken."""
        ...

    def condition(self) -> BaseCondition: ...


def check(config: BaseConfig) -> None:
    """ConfigError for a base that would be driven wrongly."""
    if config.drive == "holonomic":
        what = "a base that moves sideways is not driven yet, only one that turns on the spot"
    elif config.drive == "ackermann":
        what = "car-like steering cannot turn on the spot, which every plan here may ask of it"
    else:
        return
    raise ConfigError(f'base.drive: "{config.drive}": {what}; use a differential base')
