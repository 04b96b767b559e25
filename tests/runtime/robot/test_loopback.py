"""Under a harness the bus is on this computer alone."""

import pytest

from runtime.errors import ConfigError
from runtime.robot.loopback import check_alone
from runtime.robot.session import BusConfig


@pytest.mark.parametrize(
    "endpoint", ["tcp/127.0.0.1:7447", "tcp/[::1]:7447", "tcp/localhost:7447", "tls/127.0.0.9:1"]
)
def test_this_computers_own_addresses(endpoint: str):
    check_alone(BusConfig(connect=(endpoint,)))
    check_alone(BusConfig(listen=(endpoint,)))


@pytest.mark.parametrize(
    "endpoint",
    ["tcp/0.0.0.0:7447", "tcp/[::]:7447", "tcp/192.168.1.4:7447", "tcp/robot.local:7447", "tcp/:1",
     "tcp/localhost.example.com:7447", "tcp/127.0.0.1.example.com:7447", "", "tcp/7447"],
)  # fmt: skip
def test_what_is_beyond_it(endpoint: str):
    alone = "tcp/127.0.0.1:7447"
    for config in (
        BusConfig(connect=(alone, endpoint)),
        BusConfig(connect=(alone,), listen=(endpoint,)),
    ):
        with pytest.raises(ConfigError, match=r"^--harness: .* is beyond this computer"):
            check_alone(config)


def test_a_bus_by_default_is_alone():
    check_alone(BusConfig())
