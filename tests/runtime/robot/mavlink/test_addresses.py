"""Addresses of vehicles."""

import pytest

from runtime.errors import ConfigError
from runtime.robot.mavlink.addresses import MavlinkAddress


@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("udpin:0.0.0.0:14550", "udpin:0.0.0.0:14550"),
        ("udp:0.0.0.0:14550", "udpin:0.0.0.0:14550"),
        ("udpout:10.0.0.2:14551", "udpout:10.0.0.2:14551"),
        ("udpin://0.0.0.0:14540", "udpin:0.0.0.0:14540"),
        ("tcp:127.0.0.1:5760", "tcp:127.0.0.1:5760"),
        ("tcpout://rover.local:5760", "tcp:rover.local:5760"),
        ("serial:/dev/ttyACM0:57600", "serial:/dev/ttyACM0:57600"),
        ("serial:///dev/ttyUSB0:921600", "serial:/dev/ttyUSB0:921600"),
    ],
)
def test_addresses_as_people_write_them(text: str, known: str):
    assert str(MavlinkAddress.parse(text)) == known


@pytest.mark.parametrize(
    "text",
    [
        *("", "udpin", "udpin:", "udpin:0.0.0.0", "bluetooth:x:1", "tcp::5760"),
        *("udpin:0.0.0.0:0", "udpin:0.0.0.0:70000", "tcp:host:-1", "serial:/dev/ttyACM0"),
        "/dev/ttyACM0,57600",
    ],
)
def test_what_is_no_address_is_refused_with_an_example(text: str):
    with pytest.raises(ConfigError, match=r"^base\.link: ") as told:
        MavlinkAddress.parse(text)
    assert "e.g." in str(told.value) or "port" in str(told.value)


@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("tcp:h:1", MavlinkAddress("tcp", "h", 1)),
        ("udpin:h:65535", MavlinkAddress("udpin", "h", 65535)),
        ("serial:/dev/x:0", MavlinkAddress("serial", "/dev/x", 0)),
        ("serial:/dev/x:65536", MavlinkAddress("serial", "/dev/x", 65536)),
        ("tcp:fe80::1:5760", MavlinkAddress("tcp", "fe80::1", 5760)),
    ],
)
def test_an_address_in_its_parts(text: str, known: MavlinkAddress):
    assert MavlinkAddress.parse(text) == known


@pytest.mark.parametrize("port", [0, 65536])
def test_what_is_no_port_is_refused_in_a_line(port: int):
    with pytest.raises(ConfigError) as told:
        MavlinkAddress.parse(f"tcp:h:{port}")
    assert str(told.value) == f"base.link: {port} is no port, which is 1 to 65535"


def test_what_is_no_address_is_refused_in_a_line():
    with pytest.raises(ConfigError) as told:
        MavlinkAddress.parse("tcp:5760")
    assert str(told.value) == (
        "base.link: 'tcp:5760' is no address: e.g. \"udpin:127.0.0.1:14550\", "
        '"tcp:127.0.0.1:5760" or "serial:/dev/ttyACM0:57600"'
    )
