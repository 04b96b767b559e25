"""Which base the robot has, and where it is."""

from dataclasses import dataclass
from typing import Literal

from runtime.core.keys import key
from runtime.errors import ConfigError
from runtime.robot.mavlink.addresses import MavlinkAddress


@dataclass(frozen=True)
class BaseConfig:
    """[base]: what drives the robot, and how it is told to."""

    kind: Literal["ros2", "mavlink"] = key(
        "ros2", 'Its wire: "ros2" (cmd_vel on the bus), or "mavlink" (ArduPilot\'s Rover, PX4\'s).'
    )
    drive: Literal["differential", "holonomic", "ackermann"] = key(
        "differential",
        'How it moves. "differential": it turns on the spot. Another is refused, for it would be '
        "driven wrongly.",
    )
    link: str = key(
        "udpin:127.0.0.1:14550",
        'Where its MAVLink is: "serial:DEVICE:BAUD", "udpin:HOST:PORT" (listen), '
        '"udpout:HOST:PORT" or "tcp:HOST:PORT".',
    )
    odometry: bool = key(
        False, "Whether odometry is taken from its MAVLink, in place of bus.topics.odom."
    )


def check(config: BaseConfig) -> None:
    """ConfigError for a base that would be driven wrongly, or cannot be reached."""
    if config.drive == "holonomic":
        what = "a base that moves sideways is not driven yet, only one that turns on the spot"
    elif config.drive == "ackermann":
        what = "car-like steering cannot turn on the spot, which every plan here may ask of it"
    else:
        MavlinkAddress.parse(config.link)
        if config.odometry and config.kind != "mavlink":
            raise ConfigError('base.odometry: only a base of kind "mavlink" brings its own')
        return
    raise ConfigError(f'base.drive: "{config.drive}": {what}; use a differential base')
