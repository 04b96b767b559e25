"""A server of the operator's page that a test holds in its hands: it says what the test has it say,
by the page's protocol, and keeps what the page asked."""

import asyncio
import json
import struct
import threading
import zlib
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager
from typing import Any

import numpy as np
import uvicorn
from numpy.typing import NDArray
from places import ROOT
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from hil_sim.driving.link import free_port

PAGE = ROOT / "runtime/view/page"
SIDE = 64
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'"
)
WELCOME: dict[str, Any] = {
    "kind": "welcome",
    "v": 1,
    "mode": "live",
    "robot": {"radius_m": 0.18},
    "budgets": {},
    "max_v_mps": 0.5,
    "max_w_radps": 1.2,
    "can": {"teleop": True, "command": True, "camera": True},
    "file": None,
    "you": 1,
}
Message = dict[str, Any]


class PageDouble:
    """`answers`: by what is asked, the answer, or what makes it of the body; `token`: wanted of
    who comes; `asked` keeps everything that a page sent, in order."""

    def __init__(self, token: str | None = None) -> None:
        self.port = free_port()
        self.token, self.welcome = token, dict(WELCOME)
        self.answers: dict[str, Message | Callable[[Message], Message]] = {}
        self.asked: list[Message] = []
        self.posted = 0
        self.silent = False  # answers nothing any more
        self.full = False
        self._said: dict[str, bytes | str] = {}
        self._sockets: set[WebSocket] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ready = threading.Event()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}/"

    # -- what a test does ----------------------------------------------------------------------

    def say(self, kind: str, **told: Any) -> None:
        """To all pages, and to those that come later."""
        self._send(kind, json.dumps({"kind": kind, "t_s": 0.0, **told}))

    def show_map(
        self, cells: NDArray[np.uint8], rooms: NDArray[np.uint8], x0_m: float, y0_m: float
    ) -> None:
        """(R, C) cells and rooms at 0.05 m, the first row at the lowest y; whole."""
        tiles, inside = [], []
        for row in range(0, cells.shape[0], SIDE):
            for col in range(0, cells.shape[1], SIDE):
                tile = np.zeros((SIDE, SIDE), np.uint8)
                kinds = np.full((SIDE, SIDE), 255, np.uint8)
                part = cells[row : row + SIDE, col : col + SIDE]
                tile[: part.shape[0], : part.shape[1]] = part
                kinds[: part.shape[0], : part.shape[1]] = rooms[row : row + SIDE, col : col + SIDE]
                tiles.append(struct.pack("<ii", col // SIDE, row // SIDE))
                inside.append(tile.tobytes() + kinds.tobytes())
        head = struct.pack("<BBHIfddH", 1, 1, SIDE, 1, 0.05, x0_m, y0_m, len(tiles))
        self._send("map", head + b"".join(tiles) + zlib.compress(b"".join(inside)))

    def show_picture(self, jpeg: bytes, width: int, height: int) -> None:
        self._send("picture", struct.pack("<BBHHQ", 2, 1, width, height, 0) + jpeg)

    def did(self, what: str) -> list[Message]:
        """The bodies of what was asked of that kind."""
        return [m["body"] for m in self.asked if m.get("what") == what]

    def sent(self, kind: str) -> list[Message]:
        return [m for m in self.asked if m["kind"] == kind]

    def drop(self) -> None:
        """Ends all connections; a page may come again."""
        self._run(self._close_all())

    # -- in the server's thread ------------------------------------------------------------------

    def _send(self, kind: str, message: bytes | str) -> None:
        self._said[kind] = message
        self._run(self._send_all(message))

    def _run(self, work: Any) -> None:
        assert self._loop is not None
        asyncio.run_coroutine_threadsafe(work, self._loop).result(5.0)

    async def _send_all(self, message: bytes | str) -> None:
        for socket in list(self._sockets):
            await _put(socket, message)

    async def _close_all(self) -> None:
        for socket in list(self._sockets):
            await socket.close(1001)

    async def _stop(self, request: Request) -> Response:
        self.posted += 1
        if self.silent:
            return JSONResponse({"error": "nobody answers"}, 503)
        return JSONResponse({"stopped": True})

    async def _talk(self, socket: WebSocket) -> None:
        await socket.accept(subprotocol="rfnav.1")
        try:
            hello = await socket.receive_json()
            self.asked.append(hello)
            if self.token is not None and hello["token"] != self.token:
                await socket.close(4401)
                return
            if self.full:
                await socket.close(4429, "too many pages are open")
                return
            await socket.send_json(self.welcome)
            for message in list(self._said.values()):
                await _put(socket, message)
            self._sockets.add(socket)
            while True:
                await self._answer(socket, await socket.receive_json())
        except WebSocketDisconnect:
            return
        finally:
            self._sockets.discard(socket)

    async def _answer(self, socket: WebSocket, message: Message) -> None:
        self.asked.append(message)
        if message["kind"] != "do" or self.silent:
            return
        made = self.answers.get(message["what"], {"accepted": True})
        answer = made(message["body"]) if callable(made) else made
        await socket.send_json({"kind": "done", "n": message["n"], "answer": answer})

    def app(self) -> Starlette:
        files = StaticFiles(directory=PAGE, html=True)

        @asynccontextmanager
        async def life(app: Starlette) -> AsyncIterator[Mapping[str, Any]]:
            self._loop = asyncio.get_running_loop()
            self._ready.set()
            yield {}

        routes = [
            Route("/stop", self._stop, methods=["POST"]),
            WebSocketRoute("/ws", self._talk),
            Mount("/", _WithPolicy(files)),
        ]
        return Starlette(routes=routes, lifespan=life)

    def wait(self) -> None:
        assert self._ready.wait(10.0)


class _WithPolicy:
    """Files, with the headers that the real server gives them."""

    def __init__(self, files: StaticFiles) -> None:
        self._files = files

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        async def sent(message: Any) -> None:
            if message["type"] == "http.response.start":
                message["headers"].append((b"content-security-policy", POLICY.encode()))
            await send(message)

        await self._files(scope, receive, sent)


async def _put(socket: WebSocket, message: bytes | str) -> None:
    if isinstance(message, bytes):
        await socket.send_bytes(message)
    else:
        await socket.send_text(message)


@contextmanager
def serving(token: str | None = None) -> Iterator[PageDouble]:
    """A `PageDouble` that listens."""
    double = PageDouble(token)
    config = uvicorn.Config(
        double.app(),
        "127.0.0.1",
        double.port,
        log_level="error",
        ws="websockets-sansio",
        timeout_graceful_shutdown=2,
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    try:
        double.wait()
        while not server.started:
            threading.Event().wait(0.01)
        yield double
    finally:
        server.should_exit = True
        thread.join(10.0)
