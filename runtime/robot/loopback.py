"""Whether a bus stays on this computer."""

import ipaddress
from typing import Final

from runtime.errors import ConfigError
from runtime.robot.session import BusConfig

_LOCALHOST: Final = "localhost"


def check_alone(config: BusConfig) -> None:
    """ConfigError for a bus that others than this computer's own processes can reach: under a
    harness goals may set everything."""
    for endpoint in (*config.connect, *config.listen):
        if not _is_loopback(endpoint):
            raise ConfigError(
                f"--harness: {endpoint} is beyond this computer, and goals may set everything: "
                "use tcp/127.0.0.1:PORT"
            )
    if not (config.connect or config.listen):
        raise ConfigError(
            '--harness: without bus.connect the bus is everywhere; use ["tcp/127.0.0.1:PORT"]'
        )


def _is_loopback(endpoint: str) -> bool:
    """Of "tcp/127.0.0.1:7447" and its like. A name that has to be looked up is not."""
    host = endpoint.partition("/")[2].partition("#")[0].partition("?")[0].rpartition(":")[0]
    try:
        return ipaddress.ip_address(host.removeprefix("[").removesuffix("]")).is_loopback
    except ValueError:
        return host == _LOCALHOST
