"""How this computer listens for whom it talks to over HTTP: on one address, to a few at once, of
one other computer to fewer, and none of them holds a connection by saying nothing, or by taking
nothing of what it is told."""

import asyncio
import socket
from collections.abc import Callable
from typing import Any, ClassVar, Final

import uvicorn
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from runtime.errors import ConfigError
from runtime.robot.endpoints import is_loopback
from runtime.view.access import Access

ASKED_S: Final = 10.0  # in which TLS is agreed on, and then a request has come, whole
TAKEN_S: Final = 30.0  # in which what is told is taken
PARTED_S: Final = 2.0  # in which who is told that it is over agrees
EACH_MOST: Final = 8  # connections of one address that is not this computer's own
TURNED_AWAY_S: Final = 1.0  # in which one too many has asked, and is told that it is
MAPPED: Final = "::ffff:"  # before an address of IPv4 that came to one of IPv6
CROWDED: Final = PlainTextResponse(
    f"{EACH_MOST} connections of your address are open, and no more may be: close a page\n",
    429,
    {"connection": "close"},
)


def is_here(host: str) -> bool:
    """Whether an address that something came from is this computer's own."""
    return is_loopback(host.removeprefix(MAPPED))


def _host(connection: Any) -> str:
    """The address that one of uvicorn's connections came from; "" where it has gone."""
    return connection.client[0] if connection.client is not None else ""


class TimedHttp(H11Protocol):
    """HTTP, until a WebSocket is made of it."""

    asked_s: ClassVar[float] = ASKED_S
    taken_s: ClassVar[float] = TAKEN_S
    _asking: asyncio.TimerHandle | None = None
    _taking: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        crowded = self._crowded()
        if crowded:  # it counts for nothing, and is answered this
            self.connections.discard(self)
            self.app, self.ws_protocol_class = CROWDED, None
        self._await_request(TURNED_AWAY_S if crowded else self.asked_s)

    def _crowded(self) -> bool:
        """Whether it is one too many of its address. One of those that was answered, and is kept
        for what may be asked next, makes room for it."""
        host = _host(self)
        if is_here(host):
            return False
        alive = [other for other in self.connections if not other.transport.is_closing()]
        same = [other for other in alive if _host(other) == host]
        if len(same) <= EACH_MOST:
            return False
        for other in same:
            if isinstance(other, TimedHttp) and other.timeout_keep_alive_task is not None:
                other.timeout_keep_alive_handler()
                return False
        return True

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._asked()
        self.resume_writing()

    def handle_events(self) -> None:
        super().handle_events()
        cycle = self.cycle
        if cycle is not None and not cycle.more_body and not cycle.response_complete:
            self._asked()

    def handle_websocket_upgrade(self, event: Any) -> None:
        self._asked()
        if self.limit_concurrency is not None and len(self.connections) >= self.limit_concurrency:
            self.transport.abort()  # uvicorn counts only what stays HTTP
            return
        super().handle_websocket_upgrade(event)

    def on_response_complete(self) -> None:
        self._await_request(self.asked_s)
        super().on_response_complete()

    def pause_writing(self) -> None:
        super().pause_writing()
        self._taking = self.loop.call_later(self.taken_s, self.transport.abort)

    def resume_writing(self) -> None:
        super().resume_writing()
        if self._taking is not None:
            self._taking.cancel()

    def _await_request(self, within_s: float) -> None:
        self._asked()
        self._asking = self.loop.call_later(within_s, self.transport.abort)

    def _asked(self) -> None:
        if self._asking is not None:
            self._asking.cancel()


class TimedTls(asyncio.SelectorEventLoop):
    """A loop whose servers do not wait long for TLS to begin, or to end, of which uvicorn has no
    setting."""

    agreed_s: ClassVar[float] = ASKED_S
    parted_s: ClassVar[float] = PARTED_S

    async def create_server(self, *given: Any, **how: Any) -> asyncio.Server:
        if how.get("ssl") is not None:
            how["ssl_handshake_timeout"] = self.agreed_s
            how["ssl_shutdown_timeout"] = self.parted_s
        return await super().create_server(*given, **how)


def http_settings(connections: int, body_bytes: int) -> dict[str, Any]:
    """How uvicorn serves: bounded and silent."""
    return {
        "loop": f"{__name__}:{TimedTls.__name__}",
        "http": TimedHttp,
        "lifespan": "on",
        "log_level": "error",  # what strangers do wrong is told to them, and fills no log
        "access_log": False,
        "proxy_headers": False,
        "server_header": False,
        "date_header": False,
        "limit_concurrency": connections,
        "backlog": connections,
        "timeout_keep_alive": 5,
        "timeout_graceful_shutdown": 3,
        "h11_max_incomplete_event_size": body_bytes,
    }


def serve(
    app: ASGIApp, access: Access, settings: dict[str, Any], ready: Callable[[], None]
) -> None:
    """Until SIGTERM or Ctrl-C; ConfigError, one line, where the address cannot be had. `ready` is
    called once it is."""
    with _bound(access, settings["backlog"]) as listening:
        ready()
        uvicorn.Server(uvicorn.Config(app, **settings)).run(sockets=[listening])


def _bound(access: Access, backlog: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in access.host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((access.host, access.port))
        listening.listen(backlog)
    except OSError as error:
        listening.close()
        told = f"--listen {access.host}:{access.port}"
        raise ConfigError(f"{told}: cannot be listened on ({error.strerror})") from error
    return listening
