"""Whether a bus stays on this computer, with certificates or without."""

from runtime.errors import ConfigError
from runtime.robot.endpoints import is_loopback
from runtime.robot.session import BusConfig


def check_alone(config: BusConfig) -> None:
    """ConfigError for a bus that others than this computer's own processes can reach: under a
    harness goals may set everything."""
    for name, endpoint in config.endpoints:
        place = endpoint.partition("/")[2].partition("#")[0].partition("?")[0]
        if not is_loopback(place.rpartition(":")[0]):
            raise ConfigError(
                f"--harness: {name}: {endpoint} is beyond this computer, and goals may set "
                "everything: use tcp/127.0.0.1:PORT"
            )
