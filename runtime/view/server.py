"""The page's server: HTTP and WebSockets on one address, and nothing on any other."""

import asyncio
import json
import os
import socket
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, ClassVar, Final

from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from runtime.errors import RfNavError
from runtime.view.access import HEADERS, Access
from runtime.view.conversation import MESSAGE_BYTES, SUBPROTOCOL, Around, Conversation
from runtime.view.feed import Feed
from runtime.view.hub import Hub, HubAudience
from runtime.view.listening import PARTED_S, http_settings, serve

PAGE: Final = Path(__file__).parent / "page"
SUFFIXES: Final = ("", ".html", ".js", ".css", ".svg", ".png", ".ico", ".webmanifest", ".woff2")
CONNECTIONS_MOST: Final = 64
PING_S, PONG_S = 5.0, 10.0  # a page that does not answer for so long is gone
WIRE_BYTES: Final = 128 << 10  # that wait in the kernel for one page: what is older is dropped here
STOPS_AT_ONCE, QUESTIONS_AT_ONCE = 2, 4


class PageWire(WebSocketsSansIOProtocol):
    """What is on its way to a page that does not take it is little, and is given up with it. A page
    that is sent away, and does not say that it goes, is not waited for."""

    parted_s: ClassVar[float] = PARTED_S
    _parting: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        wire = transport.get_extra_info("socket")
        if wire is not None:
            wire.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, WIRE_BYTES)

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        if self._parting is not None:
            self._parting.cancel()

    async def send(self, message: Any) -> None:
        await super().send(message)
        if message["type"] == "websocket.close" and not self.disconnected:
            self._parting = self.loop.call_later(self.parted_s, self.transport.abort)

    def keepalive_timeout(self) -> None:
        super().keepalive_timeout()
        self.transport.abort()


class Guarded:
    """ASGI: refuses what calls us by another name, or is of another page; adds what browsers are to
    keep to."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        why = self._refused(scope)
        if not why:
            await self._app(scope, receive, _with_headers(scope, send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": why})
        else:
            refused = PlainTextResponse(f"{why}\n", 403)
            await refused(scope, receive, _with_headers(scope, send))

    def _refused(self, scope: Scope) -> str:
        """Why; "" for what may come in."""
        headers, talks = Headers(scope=scope), scope["type"] == "websocket"
        host, origin = headers.get("host", ""), headers.get("origin", "")
        if not self._access.host_allowed(host):
            return "this server has another name: open it by the address that it told"
        only_reads = not talks and scope["method"] in ("GET", "HEAD")
        if not (only_reads or self._access.origin_allowed(origin, host)):
            return "only this server's own page may do that"
        if talks and SUBPROTOCOL not in scope["subprotocols"]:
            return f"speak {SUBPROTOCOL}"
        return ""


class PageFiles(StaticFiles):
    """Files of a page, and of no other kind."""

    def lookup_path(self, path: str) -> tuple[str, os.stat_result | None]:
        if Path(path).suffix not in SUFFIXES:
            return "", None
        return super().lookup_path(path)


def _with_headers(scope: Scope, send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers[name] = value
        await send(message)

    return sent if scope["type"] == "http" else send


def page_app(access: Access, feed: Feed, page: Path = PAGE) -> ASGIApp:
    """The application; the feed begins and ends with it."""
    hub = Hub(feed.tiles)
    usual = ThreadPoolExecutor(QUESTIONS_AT_ONCE, "page")
    hurried = ThreadPoolExecutor(STOPS_AT_ONCE, "stop")
    around = Around(access, hub, feed, usual, hurried)

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        loop = asyncio.get_running_loop()
        feed.start(HubAudience(hub, loop))
        try:
            yield
        finally:
            await loop.run_in_executor(None, feed.close)
            usual.shutdown(wait=False, cancel_futures=True)
            hurried.shutdown(wait=False, cancel_futures=True)

    async def talk(websocket: WebSocket) -> None:
        await Conversation(websocket, around).run()

    async def stop(request: Request) -> Response:
        if not access.bearer_right(request.headers.get("authorization", "")):
            await asyncio.sleep(1.0)
            return JSONResponse({"error": "the token is another"}, 401)
        loop = asyncio.get_running_loop()
        try:
            answer = await loop.run_in_executor(hurried, feed.ask, "stop", {})
        except (RfNavError, ValueError) as error:
            return JSONResponse({"error": str(error)}, 503)
        return Response(json.dumps(answer), media_type="application/json")

    routes = [
        WebSocketRoute("/ws", talk),
        Route("/stop", stop, methods=["POST"]),
        Mount("/", PageFiles(directory=page, html=True, check_dir=False)),
    ]
    return Guarded(Starlette(routes=routes, lifespan=lifespan), access)


def page_settings(access: Access) -> dict[str, Any]:
    """How uvicorn serves it: pages hang on one WebSocket each, of bounded messages."""
    return http_settings(CONNECTIONS_MOST, MESSAGE_BYTES) | {
        "ws": PageWire,
        "ws_max_size": MESSAGE_BYTES,
        "ws_ping_interval": PING_S,
        "ws_ping_timeout": PONG_S,
        "ws_per_message_deflate": False,
        "ssl_certfile": access.certificate,
        "ssl_keyfile": access.key,
    }


def serve_page(access: Access, feed: Feed, ready: Callable[[], None]) -> None:
    """See `listening.serve`."""
    serve(page_app(access, feed), access, page_settings(access), ready)
