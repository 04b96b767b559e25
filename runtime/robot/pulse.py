"""The runtime's side of its watchdog (`runtime/guard.py`): starts it, and tells it of every turn of
the control loop."""

import socket
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Final, Self

from runtime import guard
from runtime.errors import BusError
from runtime.robot import wire
from runtime.robot.session import BusConfig, session_settings

END_S: Final = 2.0  # how long a guard may take to end


class Pulse:
    """`path`: where a guard waits that somebody else has started; else one is started here, and
    ends after this process. BusError when there is none at `path`."""

    def __init__(self, config: BusConfig, path: Path | None = None) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._ready, self._closed, self._lost = False, False, ""
        self._link = self._started() if path is None else _connected(path)
        self._link.setblocking(False)
        try:
            self._link.send(orders(config).told())
        except OSError as error:
            self._lost = f"the guard is gone ({error.strerror})"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def beat(self, moving: bool) -> str:
        """A turn of the control loop, in its own thread: whether the base was told to move. Why
        nobody guards it, "" when somebody does. Waits for nothing."""
        with self._lock:
            if self._closed or self._lost:
                return self._lost
            try:
                self._link.send(guard.MOVING if moving else guard.STILL)
                if not self._ready:
                    self._ready = self._link.recv(guard.LARGEST) == guard.READY
                    self._lost = "" if self._ready else "the guard has ended"
            except BlockingIOError:
                pass  # it is not ready yet, or has not read what was sent: it was told enough
            except OSError as error:
                self._lost = f"the guard is gone ({error.strerror})"
            return self._lost or ("" if self._ready else "the guard reaches nobody")

    def close(self) -> None:
        """After zero was commanded: the guard may go. Idempotent."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            with suppress(OSError):
                self._link.setblocking(True)
                self._link.settimeout(END_S)
                self._link.send(guard.BYE)
            self._link.close()
        if self._process is not None:
            try:
                self._process.wait(END_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def _started(self) -> socket.socket:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-m", guard.__name__, "--fd", str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(),),
                start_new_session=True,  # what ends our group does not end it
            )
        return ours


def orders(config: BusConfig) -> guard.Orders:
    """What the guard of a bus is to do. It goes where the runtime goes; where that only listens, it
    listens at the port after, for the runtime's own may be gone when it is needed."""
    topics = config.topics
    zero = wire.encode_twist(0.0, 0.0)
    if config.cmd_vel_type == "TwistStamped":
        zero = wire.encode_twist_stamped(0.0, 0.0, 0, config.cmd_vel_frame)
    settings = session_settings(config)
    doors = [end for name, end in config.endpoints if name == "bus.listen"]
    settings["listen/endpoints"] = [] if config.connect else [_beside(end) for end in doors]
    return guard.Orders(
        settings,
        config.key(topics.cmd_vel),
        zero.hex(),
        config.key(topics.pose or topics.odom),
        config.key(topics.teleop) if topics.teleop else "",
        not topics.pose,
    )


def _beside(endpoint: str) -> str:
    """The next port: where the runtime's own is a door, its guard needs one of its own."""
    where, _, port = endpoint.rpartition(":")
    return f"{where}:{int(port) + 1}"


def _connected(path: Path) -> socket.socket:
    link = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    try:
        link.connect(str(path))
    except OSError as error:
        link.close()
        what = f"{path}: no guard waits there ({error.strerror})"
        raise BusError(f"{what}: start `rfnav guard --socket {path}`") from error
    return link
