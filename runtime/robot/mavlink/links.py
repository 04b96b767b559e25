"""Bytes to a vehicle and from it, over UDP, TCP or a serial line.

One thread receives; any may send. Sending waits for nobody: what cannot be sent at once is lost,
and the next set-point comes a twentieth of a second later.
"""

import fcntl
import os
import select
import socket
import struct
import termios
import threading
import time
from collections import deque
from contextlib import suppress
from typing import Any, Protocol

import serial

from runtime.errors import BaseError
from runtime.robot.mavlink.addresses import MavlinkAddress

CONNECT_S = 1.0
CHUNK = 4096
QUIET_S = 3.0  # after which another may take a vehicle's place
SENDING_BYTES = 4096  # that the system may hold of a connection's messages
STALE_S = 0.3  # nothing is added to what waits for so long: it is worth nothing by then
STALLED_S = 1.0  # and after that it is never sent: the link is opened anew


class MavlinkLink(Protocol):
    """`datagrams`: what is received at once is whole messages. Errors are BaseErrors: the link
    has to be opened anew."""

    datagrams: bool

    def receive(self, timeout_s: float) -> bytes:
        """What came, b"" when nothing did."""
        ...

    def heard_vehicle(self) -> None:
        """What was received last is the vehicle's: it is answered where it is."""
        ...

    def send(self, data: bytes) -> str:
        """Why it was not sent; "" when it was."""
        ...

    def close(self) -> None: ...


def open_link(address: MavlinkAddress) -> MavlinkLink:
    """BaseError when that is not possible now."""
    try:
        return UdpLink(address) if address.kind.startswith("udp") else StreamLink(address)
    except (OSError, ValueError, OverflowError) as error:  # SerialException is an OSError
        raise BaseError(f"{address}: cannot be opened: {_reason(error)}") from error


class UdpLink:
    """Bound where vehicles send to (`udpin`), or sending to where one listens (`udpout`)."""

    datagrams = True

    def __init__(self, address: MavlinkAddress) -> None:
        self._address = address
        info = socket.getaddrinfo(address.place, address.number, type=socket.SOCK_DGRAM)[0]
        self._socket = socket.socket(info[0], socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._from: Any = None
        self._heard_s = 0.0  # the vehicle, last
        self._peer: Any = None if address.kind == "udpin" else info[4]
        if address.kind == "udpin":
            try:
                self._socket.bind(info[4])
            except OSError:
                self._socket.close()
                raise

    def receive(self, timeout_s: float) -> bytes:
        try:
            if not select.select([self._socket], [], [], timeout_s)[0]:
                return b""
            data, self._from = self._socket.recvfrom(65536)
            return data if self._follows(self._from) else b""
        except (OSError, ValueError) as error:
            raise BaseError(f"{self._address}: is gone: {_reason(error)}") from error

    def heard_vehicle(self) -> None:
        self._heard_s = time.monotonic()
        if self._address.kind == "udpin":
            self._peer = self._from

    def _follows(self, source: Any) -> bool:
        """Two vehicles of one number may call the same port: the one that was there first is heard
        as long as it speaks."""
        calls = self._address.kind == "udpin" and self._peer is not None
        return not calls or source == self._peer or time.monotonic() - self._heard_s > QUIET_S

    def send(self, data: bytes) -> str:
        if self._peer is None:
            return f"{self._address}: nobody has called yet"
        try:
            self._socket.sendto(data, self._peer)
        except OSError as error:
            return f"{self._address}: {_reason(error)}"
        return ""

    def close(self) -> None:
        self._socket.close()


class StreamLink:
    """A TCP connection to where a vehicle or a router listens, or a serial line. Bytes are read and
    written at the descriptor, which never blocks: pyserial's own `write` spins while a line is
    full. Where the other side takes nothing any more, set-points of then do not reach it once it
    does again, but for those of the first STALE_S."""

    datagrams = False

    def __init__(self, address: MavlinkAddress) -> None:
        self._address = address
        self._handle: Any
        if address.kind == "serial":
            self._handle = serial.Serial(address.place, address.number, exclusive=True)
        else:
            self._handle = socket.create_connection((address.place, address.number), CONNECT_S)
            self._handle.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._handle.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SENDING_BYTES)
            # What is still in it when it is closed is thrown away, and not sent after all.
            self._handle.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        os.set_blocking(self._handle.fileno(), False)
        self._sending = threading.Lock()
        self._rest = b""  # of a message that went out in part
        self._written = 0  # bytes, since it was opened
        self._waiting: deque[tuple[int, float]] = deque()  # `_written` at times, not taken yet

    def receive(self, timeout_s: float) -> bytes:
        try:
            with self._sending:
                waits_s = self._waits_s()
            if waits_s > STALLED_S:
                raise BaseError(f"{self._address}: takes nothing for {waits_s:.1f} s")
            if not select.select([self._handle], [], [], timeout_s)[0]:
                return b""
            data = os.read(self._handle.fileno(), CHUNK)
        except (OSError, ValueError) as error:  # closed meanwhile: no descriptor
            raise BaseError(f"{self._address}: is gone: {_reason(error)}") from error
        if not data:
            raise BaseError(f"{self._address}: was closed by the other side")
        return data

    def heard_vehicle(self) -> None:
        """There is only one."""

    def send(self, data: bytes) -> str:
        with self._sending:
            try:
                if self._waits_s() <= STALE_S:
                    if self._rest:
                        self._rest = self._rest[self._write(self._rest) :]
                    if not self._rest:
                        self._rest = data[self._write(data) :]
                        return ""
            except BlockingIOError:
                pass
            except (OSError, ValueError) as error:
                return f"{self._address}: {_reason(error)}"
        return f"{self._address}: does not take more"

    def close(self) -> None:
        with suppress(OSError, termios.error):
            if self._address.kind == "serial":
                termios.tcflush(self._handle.fileno(), termios.TCOFLUSH)
        with suppress(OSError):
            self._handle.close()

    def _write(self, data: bytes) -> int:
        """How much of it was taken."""
        taken = os.write(self._handle.fileno(), data)
        self._written += taken
        self._waiting.append((self._written, time.monotonic()))
        return taken

    def _waits_s(self) -> float:
        """How long the oldest byte waits that the other side's system, or the line, has not taken;
        0 where none does. OSError or ValueError where the handle is closed."""
        told = fcntl.ioctl(self._handle.fileno(), termios.TIOCOUTQ, bytes(4))
        taken = self._written - int(struct.unpack("i", told)[0])
        while self._waiting and self._waiting[0][0] <= taken:
            self._waiting.popleft()
        return time.monotonic() - self._waiting[0][1] if self._waiting else 0.0


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
