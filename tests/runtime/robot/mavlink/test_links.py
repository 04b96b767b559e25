"""Links over real sockets, and a serial line that is a pseudo-terminal."""

import os
import pty
import socket
import struct
import termios
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from types import SimpleNamespace

import pytest

from runtime.errors import BaseError
from runtime.robot.mavlink import links as module
from runtime.robot.mavlink.addresses import MavlinkAddress
from runtime.robot.mavlink.links import QUIET_S, SENDING_BYTES, STALLED_S, open_link

PATIENCE = 100  # receptions of 0.1 s


def link_to(text: str):
    return open_link(MavlinkAddress.parse(text))


def receive(link) -> bytes:
    for _ in range(PATIENCE):
        if data := link.receive(0.1):
            return data
    raise AssertionError("nothing came")


def gone(what: Callable[[], object]) -> str:
    """Why, once it is."""
    for _ in range(PATIENCE):
        try:
            what()
        except BaseError as error:
            return str(error)
    raise AssertionError("it is still there")


class Clock:
    """Time, in the hands of a test."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 100.0
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: self.now_s))


@pytest.fixture
def clock(monkeypatch) -> Clock:
    return Clock(monkeypatch)


@pytest.fixture
def vehicle():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        other.settimeout(10)
        yield other


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def test_a_vehicle_that_calls_is_answered_once_it_is_known_for_one(vehicle):
    port = free_port()
    link = link_to(f"udpin:127.0.0.1:{port}")
    assert link._socket.gettimeout() == 0.0  # a full link holds nothing up
    nobody = f"udpin:127.0.0.1:{port}: nobody has called yet"
    assert link.send(b"early") == nobody
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(b"me!", ("127.0.0.1", port))
        assert receive(link) == b"me!"
    assert link.send(b"to whom?") == nobody  # that it spoke does not make it one
    vehicle.sendto(b"heartbeat", ("127.0.0.1", port))
    assert receive(link) == b"heartbeat"
    link.heard_vehicle()
    assert link.send(b"hello") == ""
    assert vehicle.recv(100) == b"hello"
    assert link.datagrams
    link.close()
    why = gone(lambda: link.receive(0.0))
    assert why.startswith(f"udpin:127.0.0.1:{port}: is gone: file descriptor cannot be")


@pytest.mark.parametrize("kind", ["udpin", "tcp"])
def test_what_does_not_come_is_waited_for_as_long_as_is_asked(monkeypatch, kind: str):
    asked: list[object] = []

    def select(*how: object) -> tuple[list[object], ...]:
        asked.append(how)
        return [], [], []

    with socket.create_server(("127.0.0.1", 0)) as server:
        link = link_to(f"{kind}:127.0.0.1:{server.getsockname()[1]}")
    handle = link._socket if kind == "udpin" else link._handle
    monkeypatch.setattr(module.select, "select", select)
    assert link.receive(0.25) == b""
    assert asked == [([handle], [], [], 0.25)]
    link.close()


def test_of_two_that_call_the_first_is_heard_as_long_as_it_speaks(vehicle, clock):
    port = free_port()
    link = link_to(f"udpin:127.0.0.1:{port}")
    vehicle.sendto(b"first", ("127.0.0.1", port))
    assert receive(link) == b"first"
    link.heard_vehicle()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second:
        second.sendto(b"second", ("127.0.0.1", port))
        assert [link.receive(0.1) for _ in range(3)] == [b""] * 3
        assert link.send(b"to the first") == ""
        assert vehicle.recv(100) == b"to the first"
        clock.now_s += QUIET_S
        second.sendto(b"second", ("127.0.0.1", port))
        assert [link.receive(0.1) for _ in range(3)] == [b""] * 3
        clock.now_s += 0.01
        second.sendto(b"second", ("127.0.0.1", port))
        assert receive(link) == b"second"
    link.close()


def test_who_listens_is_spoken_to_first(vehicle):
    link = link_to(f"udpout:127.0.0.1:{vehicle.getsockname()[1]}")
    assert link.send(b"hello") == ""
    data, peer = vehicle.recvfrom(100)
    vehicle.sendto(b"welcome", peer)
    assert (data, receive(link)) == (b"hello", b"welcome")
    assert link.receive(0.0) == b""
    link.heard_vehicle()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.sendto(b"from elsewhere", peer)
        assert receive(link) == b"from elsewhere"
    link.heard_vehicle()
    assert link.send(b"again") == ""
    assert vehicle.recv(100) == b"again"
    link.close()


@pytest.mark.skipif(not socket.has_ipv6, reason="no IPv6 here")
def test_an_address_may_be_one_of_ipv6():
    link = link_to("udpout:::1:14550")
    assert link._socket.family == socket.AF_INET6
    link.close()


def test_what_cannot_be_sent_is_said(vehicle):
    link = link_to(f"udpout:127.0.0.1:{vehicle.getsockname()[1]}")
    link.close()
    address = f"udpout:127.0.0.1:{vehicle.getsockname()[1]}"
    assert link.send(b"hello") == f"{address}: Bad file descriptor"


def test_what_went_out_in_part_goes_out_before_anything_else(monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}")
    written: list[bytes] = []
    full = False

    def write(_: int, data: bytes) -> int:
        if full:
            raise BlockingIOError
        written.append(data[:4])
        return len(written[-1])

    monkeypatch.setattr("runtime.robot.mavlink.links.os.write", write)
    assert link.send(b"0123456789") == ""
    lost = f"tcp:127.0.0.1:{link._address.number}: does not take more"
    assert link.send(b"abc") == lost
    full = True
    assert link.send(b"nothing") == lost
    full = False
    assert link.send(b"def") == ""
    assert b"".join(written) == b"0123456789def"
    link.close()
    why = "file descriptor cannot be a negative integer (-1)"
    assert link.send(b"late") == f"tcp:127.0.0.1:{link._address.number}: {why}"


def test_a_port_where_nobody_listens_yet_is_no_error():
    link = link_to(f"udpout:127.0.0.1:{free_port()}")
    for _ in range(5):
        link.send(b"hello")
        assert link.receive(0.01) == b""
    link.close()


def test_a_connection_is_bytes_in_order_until_the_other_side_ends_it():
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}")
        other, _ = server.accept()
    with other:
        assert link.send(b"one") == ""
        assert link.send(b"two") == ""
        other.settimeout(10)
        got = b""
        while len(got) < 6:
            got += other.recv(100)
        assert got == b"onetwo"
        other.sendall(b"three")
        assert receive(link) == b"three"
        assert not link.datagrams
    name = f"tcp:127.0.0.1:{link._address.number}"
    assert gone(lambda: link.receive(0.1)) == f"{name}: was closed by the other side"
    link.close()
    assert gone(lambda: link.receive(0.1)).startswith(f"{name}: is gone: file descriptor")


def test_a_connection_holds_little_and_nothing_waits_for_more():
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}")
    handle = link._handle
    assert handle.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
    assert handle.getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF) == 2 * SENDING_BYTES
    lingers = handle.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
    assert struct.unpack("ii", lingers) == (1, 0)
    assert not os.get_blocking(handle.fileno())
    link.close()


def test_a_connection_that_cannot_even_be_closed_is_closed():
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}")

    def close() -> None:
        raise OSError("it is gone")

    link._handle.close()
    link._handle = SimpleNamespace(close=close)
    link.close()


def test_a_connection_that_is_not_taken_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(module, "CONNECT_S", 0.05)
    with socket.socket() as server, ExitStack() as others:
        server.bind(("127.0.0.1", 0))
        server.listen(0)
        for _ in range(3):  # no more wait there
            other = others.enter_context(socket.socket())
            other.setblocking(False)
            with suppress(BlockingIOError):
                other.connect(server.getsockname())
        with pytest.raises(BaseError, match="cannot be opened: timed out"):
            link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}")


def test_the_oldest_byte_decides_what_is_added_and_when_the_link_is_given_up(clock, monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}")
        other, _ = server.accept()
    name, waiting = f"tcp:127.0.0.1:{link._address.number}", 0

    def write(_: int, data: bytes) -> int:
        nonlocal waiting
        waiting += len(data)
        return len(data)

    monkeypatch.setattr(module.os, "write", write)
    monkeypatch.setattr(module.fcntl, "ioctl", lambda *_: struct.pack("i", waiting))
    monkeypatch.setattr(module, "STALE_S", 0.5)
    assert link.send(bytes(10)) == ""
    clock.now_s += 0.5
    assert link.send(bytes(10)) == ""
    clock.now_s += 0.25
    assert link.send(bytes(10)) == f"{name}: does not take more"
    waiting = 11  # all but one byte of the first
    assert link.send(bytes(10)) == f"{name}: does not take more"
    waiting = 10  # the first is taken, and the second waits for as long as it is there
    assert link.send(bytes(10)) == ""
    clock.now_s += STALLED_S - 0.25
    assert link.receive(0.0) == b""
    clock.now_s += 0.5
    assert gone(lambda: link.receive(0.0)) == f"{name}: takes nothing for 1.5 s"
    waiting = 0
    assert link.receive(0.0) == b""
    assert link.send(bytes(10)) == ""
    link.close()
    other.close()


def test_a_connection_that_takes_no_more_loses_whole_messages_and_never_waits():
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}")
        other, _ = server.accept()
    message = bytes(range(256)) * 40
    with other:
        lost, sent = 0, 0
        while lost < 3:
            lost, sent = (lost + 1, sent) if link.send(message) else (lost, sent + 1)
        other.settimeout(0.5)
        got = bytearray()
        try:
            while True:
                got += other.recv(1 << 20)
                link.send(b"")  # what waits goes first
        except TimeoutError:
            pass
    assert bytes(got) == message * sent
    link.close()


def test_a_connection_that_stalls_is_given_up_and_old_set_points_do_not_come_after_all():
    with socket.socket() as server:
        server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        server.bind(("127.0.0.1", 0))
        server.listen(1)
        link = link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}")
        other, _ = server.accept()
    began_s, sent, said = time.monotonic(), list[float](), set[str]()
    with other:  # it reads nothing

        def drive() -> None:
            while time.monotonic() < began_s + 60.0:
                now_s = time.monotonic() - began_s
                why = link.send(struct.pack("<d", now_s) + bytes(56))
                if why:
                    said.add(why.partition(": ")[2])
                else:
                    sent.append(now_s)
                link.receive(0.001)

        with pytest.raises(BaseError, match=r"tcp:127\.0\.0\.1:\d+: takes nothing for \d"):
            drive()
        assert said == {"does not take more"}
        link.close()
        other.settimeout(10)
        got = bytearray()
        with suppress(ConnectionResetError):
            while data := other.recv(1 << 16):
                got += data
    came = [struct.unpack_from("<d", got, at)[0] for at in range(0, len(got) - 7, 64)]
    assert came == sent[: len(came)]
    assert came[-1] < sent[-1]  # what waited here was thrown away
    assert time.monotonic() - began_s > STALLED_S


def test_a_serial_line():
    ours, theirs = pty.openpty()
    link = link_to(f"serial:{os.ttyname(theirs)}:57600")
    os.write(ours, b"\xfd\x00\x11\x13\r\n")  # as it is, also what a terminal would take for itself
    got = receive(link)
    while len(got) < 6:
        got += receive(link)
    assert got == b"\xfd\x00\x11\x13\r\n"
    assert link.send(b"\xfd\n\x03") == ""
    assert os.read(ours, 100) == b"\xfd\n\x03"
    assert termios.tcgetattr(theirs)[4:6] == [termios.B57600] * 2
    with pytest.raises(BaseError, match=r"cannot be opened: .*xclusive"):
        link_to(f"serial:{os.ttyname(theirs)}:57600")
    name = f"serial:{os.ttyname(theirs)}:57600"
    os.close(ours)
    assert gone(lambda: link.receive(0.1)) == f"{name}: is gone: Input/output error"
    link.close()
    os.close(theirs)


def test_what_a_serial_line_has_not_taken_is_thrown_away_at_the_end(monkeypatch):
    flushed: list[tuple[int, int]] = []
    monkeypatch.setattr(module.termios, "tcflush", lambda *how: flushed.append(how))
    ours, theirs = pty.openpty()
    link = link_to(f"serial:{os.ttyname(theirs)}:57600")
    line = link._handle.fileno()
    del flushed[:]  # when it was opened
    link.close()
    link.close()
    assert flushed == [(line, termios.TCOFLUSH)]
    with socket.create_server(("127.0.0.1", 0)) as server:
        link_to(f"tcp:127.0.0.1:{server.getsockname()[1]}").close()
    assert len(flushed) == 1
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("serial:/dev/no-such-line:57600", "No such file"),
        ("tcp:127.0.0.1:1", "refused"),
        ("udpin:192.0.2.1:14550", "assign"),
        ("udpout:no.such.host.invalid:14550", "[a-z]"),
    ],
)
def test_what_cannot_be_opened_is_one_line_that_names_the_address(text: str, why: str):
    with pytest.raises(BaseError, match=why) as told:
        link_to(text)
    assert str(told.value).startswith(f"{text}: cannot be opened: ")
    assert "\n" not in str(told.value)
