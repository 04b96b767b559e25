"""What is open to others is told, and by default nothing is."""

import pytest

from runtime.robot.base_config import BaseConfig
from runtime.robot.endpoints import TlsConfig
from runtime.robot.exposure import doubtful, exposed
from runtime.robot.session import BusConfig


def test_by_default_nothing_is_open() -> None:
    assert exposed(BusConfig(), BaseConfig()) == ()
    assert exposed(BusConfig(), BaseConfig(kind="mavlink")) == ()


def test_an_endpoint_with_certificates_is_told_with_whose_count() -> None:
    tls = TlsConfig("/etc/rf-nav/ca.pem", "robot.pem", "robot-key.pem")
    bus = BusConfig(connect=("tcp/127.0.0.1:7447",), listen=("tls/0.0.0.0:7448",), tls=tls)
    [line] = exposed(bus, BaseConfig())
    assert line.startswith("bus.listen: tls/0.0.0.0:7448: whoever has a certificate of /etc/rf-nav")


@pytest.mark.parametrize(
    ("link", "told"),
    [
        ("udpin:127.0.0.1:14550", False),
        ("tcp:localhost:5760", False),
        ("serial:/dev/ttyACM0:57600", False),
        *((link, True) for link in ("udpin:0.0.0.0:14550", "udpout:10.0.0.2:14550")),
        ("tcp:rover:5760", True),
    ],
)
def test_mavlink_over_a_network_is_told(link: str, told: bool) -> None:
    lines = exposed(BusConfig(), BaseConfig(kind="mavlink", link=link))
    assert bool(lines) is told
    assert all(line.startswith(f"base.link: {link}: MAVLink knows neither") for line in lines)
    assert exposed(BusConfig(), BaseConfig(kind="ros2", link=link)) == ()


def test_a_peer_of_a_router_that_relays_to_clients_alone_is_told_so():
    connect = ("tcp/127.0.0.1:7447",)
    (line,) = doubtful(BusConfig(dialect="rmw_zenoh", connect=connect))
    assert line.startswith('bus.mode: "peer": a router of rmw_zenoh (tcp/127.0.0.1:7447?) ')
    assert doubtful(BusConfig(dialect="rmw_zenoh", mode="client", connect=connect)) == ()
    assert doubtful(BusConfig(connect=connect)) == ()
    assert doubtful(BusConfig(dialect="rmw_zenoh")) == ()
