"""Connections that say nothing, or take nothing, are let go; others are not."""

import http.client
import socket
import ssl
import threading
import time
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from live_page import until
from page_client import PageClient
from page_server import HeldFeed, allowed, free_port, page_server
from websockets.exceptions import InvalidMessage, InvalidStatus

from runtime.errors import ConfigError
from runtime.view import conversation, listening
from runtime.view.listening import EACH_MOST, TimedHttp, TimedTls, http_settings, serve
from runtime.view.server import PageWire

PATIENCE_S = 20.0
SOON_S = 0.05
IN_TIME_S = 1.0  # for who speaks at once, on a busy computer
HUGE = 24 << 20  # bytes, more than the kernel holds for anybody
WAITED_S = 5.0  # less than a page that agrees has
UPGRADE = (
    "Connection: Upgrade",
    "Upgrade: websocket",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
    "Sec-WebSocket-Protocol: rfnav.1",
)
LEAST = ("GET / HTTP/1.1", "Host: 127.0.0.1:{port}")


def left_alone(port: int, said: bytes = b"", tls: ssl.SSLContext | None = None) -> bytes:
    """What comes until the server hangs up."""
    wire = socket.create_connection(("127.0.0.1", port), PATIENCE_S)
    with wire if tls is None else tls.wrap_socket(wire) as opened:
        opened.sendall(said)
        heard = b""
        with suppress(ConnectionResetError):
            while more := opened.recv(1 << 16):
                heard += more
        return heard


def request(port: int, *lines: str) -> bytes:
    return "\r\n".join((*LEAST, *lines)).format(port=port).encode()


@pytest.mark.parametrize("lines", [(), ("Accept: */*", "")])
def test_who_says_nothing_or_half_of_it_is_let_go(
    port: int, monkeypatch: pytest.MonkeyPatch, lines: tuple[str, ...]
):
    monkeypatch.setattr(TimedHttp, "asked_s", SOON_S)
    assert left_alone(port) == b""
    assert left_alone(port, request(port, *lines)) == b""


def test_whose_request_lacks_its_end_is_answered_and_let_go(
    port: int, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(TimedHttp, "asked_s", IN_TIME_S)
    heard = left_alone(port, request(port, "Content-Length: 9", "", "half"))
    assert heard.startswith(b"HTTP/1.1 200 ")


def test_whose_answer_takes_long_is_not(port: int, feed: HeldFeed, monkeypatch: pytest.MonkeyPatch):
    answered: list[int] = []
    asked, may = threading.Event(), threading.Event()

    def slow(what: str, body: object) -> dict[str, Any]:
        asked.set()
        assert may.wait(PATIENCE_S)
        return {"stopped": True}

    def stop() -> None:
        wire = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
        wire.request("POST", "/stop", headers={"Origin": f"http://127.0.0.1:{port}"})
        answered.append(wire.getresponse().status)
        wire.close()

    monkeypatch.setattr(TimedHttp, "asked_s", IN_TIME_S)
    monkeypatch.setattr(feed, "ask", slow)
    asking = threading.Thread(target=stop)
    asking.start()
    assert asked.wait(PATIENCE_S)
    left_alone(port)  # who came later has been let go
    may.set()
    asking.join(PATIENCE_S)
    assert answered == [200]


def test_who_talks_over_a_websocket_is_not(
    port: int, feed: HeldFeed, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(TimedHttp, "asked_s", IN_TIME_S)
    client = PageClient(port)
    client.wait("welcome")
    left_alone(port)
    assert client.ask(1, "resume")["answer"] == {"asked": "resume"}
    client.close()


def test_who_takes_nothing_is_let_go(feed: HeldFeed, page: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(TimedHttp, "taken_s", SOON_S)
    (page / "page.js").write_bytes(bytes(HUGE))
    port = free_port()
    with page_server(allowed(port), feed, page) as server, socket.socket() as wire:
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        wire.connect(("127.0.0.1", port))
        wire.sendall(request(port, "", "").replace(b"GET /", b"GET /page.js"))
        until(lambda: server.server_state.total_requests == 0 and server.server_state.tasks)
        until(lambda: not server.server_state.connections)
        until(lambda: not server.server_state.tasks)


def test_who_does_not_agree_on_tls_is_let_go(
    feed: HeldFeed, page: Path, pair: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(TimedTls, "agreed_s", SOON_S)
    port = free_port()
    access = replace(allowed(port), certificate=pair[0], key=pair[1])
    with page_server(access, feed, page):
        assert left_alone(port) == b""
        monkeypatch.setattr(TimedHttp, "asked_s", SOON_S)
        context = ssl.create_default_context(cafile=str(pair[0]))
        context.check_hostname = False
        assert left_alone(port, tls=context) == b""


def test_more_websockets_than_there_is_room_for_are_refused(feed: HeldFeed, page: Path):
    port = free_port()
    with page_server(allowed(port), feed, page, limit_concurrency=2) as server:
        client = PageClient(port)
        client.wait("welcome")
        with pytest.raises(InvalidMessage):
            PageClient(port)
        client.close()
        until(lambda: not server.server_state.connections)
        again = PageClient(port)
        again.wait("welcome")
        again.close()


# -- of one address ------------------------------------------------------------------------------


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who connects is of another computer."""
    monkeypatch.setattr(listening, "is_loopback", lambda host: False)


def kept(port: int) -> http.client.HTTPConnection:
    """A connection that was answered once, and may ask more."""
    wire = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
    wire.request("GET", "/page.js")
    assert wire.getresponse().read()
    return wire


@pytest.mark.usefixtures("elsewhere")
def test_more_connections_of_one_address_are_refused(feed: HeldFeed, page: Path):
    port = free_port()
    with page_server(allowed(port), feed, page) as server:
        clients = [PageClient(port) for _ in range(EACH_MOST)]
        for client in clients:
            client.wait("welcome")
        refused = left_alone(port, request(port, "", ""))
        assert refused.startswith(b"HTTP/1.1 429 ")
        assert refused.endswith(b"8 connections of your address are open, and no more may be: "
                                b"close a page\n")  # fmt: skip
        with pytest.raises(InvalidStatus, match="429"):
            PageClient(port)
        assert left_alone(port) == b""
        assert len(server.server_state.connections) == EACH_MOST  # others have their room
        clients.pop().close()
        until(lambda: len(server.server_state.connections) < EACH_MOST)
        clients.append(PageClient(port))
        clients[-1].wait("welcome")
        for client in clients:
            client.close()


@pytest.mark.usefixtures("elsewhere")
def test_one_that_was_answered_makes_room_for_another(port: int):
    wires = [kept(port) for _ in range(EACH_MOST + 2)]
    gone = 0
    for wire in wires:
        assert wire.sock is not None
        wire.sock.setblocking(False)
        with suppress(BlockingIOError):
            gone += wire.sock.recv(1) == b""
        wire.close()
    assert gone == 2


def test_this_computer_may_have_more(port: int):
    with ExitStack() as stack:
        for _ in range(EACH_MOST):
            stack.enter_context(socket.create_connection(("127.0.0.1", port)))
        kept(port).close()


@pytest.mark.parametrize(
    ("host", "here"),
    [("127.0.0.1", True), ("::1", True), ("::ffff:127.0.0.1", True), ("::ffff:10.0.0.1", False),
     ("192.168.1.7", False), ("fe80::1%eth0", False), ("", False)],
)  # fmt: skip
def test_which_addresses_are_this_computer(host: str, here: bool):
    assert listening.is_here(host) == here


# -- that ends -----------------------------------------------------------------------------------


@pytest.mark.parametrize("secure", [False, True])
def test_a_websocket_that_says_nothing_is_not_waited_for(
    feed: HeldFeed, page: Path, pair: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch,
    secure: bool,
):  # fmt: skip
    monkeypatch.setattr(conversation, "HELLO_S", SOON_S)
    monkeypatch.setattr(PageWire, "parted_s", SOON_S)
    port = free_port()
    certificate, key = pair if secure else (None, None)
    access = replace(allowed(port), certificate=certificate, key=key)
    origin = f"Origin: {access.scheme}://127.0.0.1:{port}"
    with page_server(access, feed, page) as server, ExitStack() as stack:
        wire = stack.enter_context(socket.create_connection(("127.0.0.1", port), PATIENCE_S))
        if certificate is not None:
            context = ssl.create_default_context(cafile=str(certificate))
            context.check_hostname = False
            wire = stack.enter_context(context.wrap_socket(wire))
        wire.sendall(request(port, *UPGRADE, origin, "", "").replace(b"GET /", b"GET /ws"))
        assert wire.recv(1 << 10).startswith(b"HTTP/1.1 101 ")
        left_s = time.monotonic() + WAITED_S
        while server.server_state.connections:
            assert time.monotonic() < left_s
            time.sleep(SOON_S)


def test_an_address_that_is_taken_is_told_in_a_line():
    async def nothing(*_: object) -> None:
        raise AssertionError

    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(ConfigError, match=f"--listen 127.0.0.1:{port}: cannot be listened on"):
            serve(nothing, allowed(port), http_settings(4, 1024), lambda: None)
