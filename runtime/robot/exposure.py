"""What of the robot can be reached from beyond this computer, and whether it reaches what it is to:
told at every start."""

from runtime.robot.base_config import BaseConfig
from runtime.robot.endpoints import is_loopback
from runtime.robot.mavlink.addresses import MavlinkAddress
from runtime.robot.session import BusConfig


def doubtful(bus: BusConfig) -> tuple[str, ...]:
    """A line for what may be meant otherwise."""
    if bus.dialect != "rmw_zenoh" or bus.mode == "client" or not bus.connect:
        return ()
    where = ", ".join(bus.connect)
    return (
        f'bus.mode: "peer": a router of rmw_zenoh ({where}?) relays between clients alone: set '
        '"client", unless that is a node itself',
    )


def exposed(bus: BusConfig, base: BaseConfig) -> tuple[str, ...]:
    """A line for each way in or out that leaves this computer; none by default."""
    lines = [
        f"{name}: {endpoint}: whoever has a certificate of {bus.tls.ca} may drive the robot"
        for name, endpoint in bus.endpoints
        if endpoint.startswith("tls/")
    ]
    if base.kind == "mavlink":
        link = MavlinkAddress.parse(base.link)
        if link.kind != "serial" and not is_loopback(link.place):
            lines.append(
                f"base.link: {link}: MAVLink knows neither certificates nor secrecy: whoever "
                "reaches it may speak as the vehicle, or drive it; keep it on a network of its own"
            )
    return tuple(lines)
