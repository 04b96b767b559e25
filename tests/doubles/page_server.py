"""Our page's server in a thread, on a free port, with a feed that a test holds in its hands."""

import socket
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import uvicorn

from runtime.errors import BusError
from runtime.view.access import Access
from runtime.view.feed import Audience
from runtime.view.server import page_app, page_settings
from runtime.view.tiles import TileMap

PATIENCE_S = 10.0


class HeldFeed:
    """Tells what a test tells, and remembers what was asked of it."""

    def __init__(self) -> None:
        self.tiles = TileMap()
        self.audience: Audience
        self.asked: list[tuple[str, object]] = []
        self.steered: list[tuple[int, Mapping[str, Any]]] = []
        self.looking = (0, 0)
        self.left: list[int] = []
        self.slow = threading.Event()
        self.slow.set()
        self.closed = False

    def start(self, audience: Audience) -> None:
        self.audience = audience

    def welcome(self) -> dict[str, Any]:
        return {"mode": "live"}

    def attend(self, pages: int, cameras: int) -> None:
        self.looking = pages, cameras

    def ask(self, what: str, body: object) -> dict[str, Any]:
        self.asked.append((what, body))
        if what == "goal":
            assert self.slow.wait(PATIENCE_S)
        if what == "pause":
            raise BusError("nobody answers: is rfnav run up?")
        if what == "zones":
            raise ValueError("zones: must have one of add")
        return {"asked": what}

    def steer(self, who: int, order: Mapping[str, Any]) -> None:
        self.steered.append((who, order))

    def gone(self, who: int) -> None:
        self.left.append(who)

    def close(self) -> None:
        self.closed = True


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def allowed(port: int, token: str = "") -> Access:
    return Access("127.0.0.1", port, frozenset({f"127.0.0.1:{port}", f"localhost:{port}"}), token)


@contextmanager
def page_server(access: Access, feed: Any, page: Path, **more: Any) -> Iterator[uvicorn.Server]:
    """Until that is left. `more`: settings of uvicorn."""
    settings = page_settings(access) | more
    server = uvicorn.Server(uvicorn.Config(page_app(access, feed, page), **settings))
    with socket.socket() as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((access.host, access.port))
        thread = threading.Thread(target=server.run, args=([listening],), daemon=True)
        thread.start()
        until_s = time.monotonic() + PATIENCE_S
        while not server.started and time.monotonic() < until_s:
            time.sleep(0.01)
        try:
            yield server
        finally:
            server.should_exit = True
            thread.join(PATIENCE_S)
