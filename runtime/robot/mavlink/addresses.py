"""Where a vehicle is on MAVLink, in words: "udpin:127.0.0.1:14550", "serial:/dev/ttyACM0:57600"."""

from dataclasses import dataclass
from typing import Literal

from runtime.errors import ConfigError

KINDS = ("udpin", "udpout", "tcp", "serial")
EXAMPLE = 'e.g. "udpin:127.0.0.1:14550", "tcp:127.0.0.1:5760" or "serial:/dev/ttyACM0:57600"'


@dataclass(frozen=True)
class MavlinkAddress:
    """`place`: a host, or a serial device; `number`: its port, or its baud rate."""

    kind: Literal["udpin", "udpout", "tcp", "serial"]
    place: str
    number: int

    @classmethod
    def parse(cls, text: str) -> "MavlinkAddress":
        """ConfigError when it is none. The two slashes that others write after the kind may be
        there."""
        kind, _, rest = text.partition(":")
        kind = {"udp": "udpin", "tcpout": "tcp"}.get(kind, kind)
        place, _, number = rest.removeprefix("//").rpartition(":")
        if kind not in KINDS or not place or not number.isdecimal():
            raise ConfigError(f"base.link: {text!r} is no address: {EXAMPLE}")
        if kind != "serial" and not 0 < int(number) < 65536:
            raise ConfigError(f"base.link: {number} is no port, which is 1 to 65535")
        return cls(kind, place, int(number))  # type: ignore[arg-type]

    def __str__(self) -> str:
        return f"{self.kind}:{self.place}:{self.number}"
