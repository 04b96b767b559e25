"""What drives the robot, opened as it is configured, and who watches over it."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path

from runtime.clock import Clock
from runtime.log import say
from runtime.robot.base import Base
from runtime.robot.base_config import BaseConfig
from runtime.robot.bus import Bus
from runtime.robot.pulse import Pulse
from runtime.robot.session import BusConfig

MAVLINK_UNGUARDED = "guard: none on MAVLink: the vehicle's own time-out ends what is not commanded"


def opened_base(
    config: BaseConfig, bus: Bus, clock: Clock, arm: bool
) -> AbstractContextManager[Base]:
    """The bus is closed by who opened it. `arm`: see `MavlinkBase`."""
    if config.kind == "ros2":
        return nullcontext(bus)
    from runtime.robot.mavlink.base import MavlinkBase  # its messages take a while to import

    odometry = bus.file_odometry if config.odometry else None
    return MavlinkBase(config.link, clock, arm, odometry, beside=bus.condition)


@contextmanager
def watched(
    base: BaseConfig, bus: BusConfig, path: Path | None = None
) -> Iterator[Callable[[bool], str]]:
    """What the control loop tells its guard by, where there can be one. `path`: see `Pulse`."""
    if base.kind != "ros2":
        say(MAVLINK_UNGUARDED)
        yield lambda moving: ""
        return
    with Pulse(bus, path) as pulse:
        yield pulse.beat
