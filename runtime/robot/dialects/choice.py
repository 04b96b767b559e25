"""Which dialect a bus is spoken in."""

from runtime.robot.dialects.dialect import Dialect
from runtime.robot.dialects.rmw_zenoh import NODE, RmwZenoh
from runtime.robot.dialects.ros2dds import Ros2dds
from runtime.robot.session import BusConfig


def spoken(config: BusConfig, node: str = NODE) -> Dialect:
    """As it is configured; `node`: what the others are to call us."""
    if config.dialect == "rmw_zenoh":
        return RmwZenoh(config.prefix, config.domain, config.distro, node)
    return Ros2dds(config.prefix)
