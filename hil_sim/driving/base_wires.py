"""The wire between the runtime and the base that is driven in real time: ROS 2's topics, or MAVLink
to a stand-in."""

import socket
from collections.abc import Callable
from contextlib import suppress
from typing import Any
from typing import Protocol as Port

from pymavlink.dialects.v20 import common as mavlink

from hil_sim.driving.link import Runtime
from hil_sim.simulation.rover_stand_in import RoverStandIn
from runtime.core.types import Pose, Twist
from runtime.robot import wire


class BaseWire(Port):
    """`now_s`: monotonic."""

    def command(self, now_s: float) -> Twist | None:
        """A velocity that is new; None when there is none."""
        ...

    def report(self, pose: Pose, stamp_ns: int, now_s: float) -> None:
        """Where the base is, seen from its start."""
        ...


class CmdVelWire:
    """cmd_vel and odom."""

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime

    def command(self, now_s: float) -> Twist | None:
        return self._runtime.command()

    def report(self, pose: Pose, stamp_ns: int, now_s: float) -> None:
        self._runtime.publish("odom", wire.encode_odometry(pose, stamp_ns))


class MavlinkWire:
    """A stand-in on a UDP port of the loopback. `each`: called with the rover and the time before
    it is asked what it drives, for a pilot to act."""

    def __init__(
        self, rover: RoverStandIn, each: Callable[[RoverStandIn, float], None] | None = None
    ) -> None:
        self.rover, self._each = rover, each
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)
        self._peer: Any = None
        self._writer = mavlink.MAVLink(None, 1, 1)

    def __enter__(self) -> "MavlinkWire":
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    @property
    def address(self) -> str:
        """Where the rover is heard."""
        return f"udpout:127.0.0.1:{self._socket.getsockname()[1]}"

    @property
    def settings(self) -> tuple[str, ...]:
        """How the runtime is told of it."""
        return 'base.kind="mavlink"', f'base.link="{self.address}"', "base.odometry=true"

    def command(self, now_s: float) -> Twist | None:
        self._receive(now_s)
        if self._each is not None:
            self._each(self.rover, now_s)
        return self.rover.velocity(now_s)

    def report(self, pose: Pose, stamp_ns: int, now_s: float) -> None:
        for message in self.rover.tell(pose, now_s):
            self._send(message)

    def _receive(self, now_s: float) -> None:
        while True:
            try:
                data, peer = self._socket.recvfrom(4096)
            except (BlockingIOError, ConnectionRefusedError):
                return
            self._peer = peer
            parser = mavlink.MAVLink(None)
            parser.robust_parsing = True
            for message in parser.parse_buffer(data) or []:
                for answer in self.rover.hear(message, now_s):
                    self._send(answer)

    def _send(self, message: Any) -> None:
        if self._peer is not None:
            data = message.pack(self._writer)
            self._writer.seq = (self._writer.seq + 1) % 256
            with suppress(ConnectionRefusedError, BlockingIOError):
                self._socket.sendto(data, self._peer)
