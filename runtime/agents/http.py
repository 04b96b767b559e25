"""The protocol over HTTP, on this computer alone."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import anyio
from mcp.server.lowlevel import Server
from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from runtime.errors import ConfigError
from runtime.robot.endpoints import is_loopback
from runtime.view.access import Access, access
from runtime.view.listening import http_settings, serve

PATH: Final = "/mcp"
BODY_BYTES: Final = 64 << 10
CONNECTIONS_MOST, SESSIONS_MOST = 32, 16
IDLE_S: Final = 300.0  # after which a session that asks nothing is forgotten
WRONG_S: Final = 1.0  # that each token which is wrong takes


def agent_access(listen: str, token_file: Path | None) -> Access:
    """ConfigError, one line, for an address beyond this computer, or what is none."""
    host = listen.rpartition(":")[0].removeprefix("[").removesuffix("]")
    if host and not is_loopback(host):
        raise ConfigError(
            f"--listen {listen}: is not this computer; from another one go through ssh -L"
        )
    return access(listen, None, None, token_file)


class AgentGate:
    """ASGI: refuses what calls us by another name, comes from a page of a browser, or lacks the
    token."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        status, why = self._refused(scope)
        if not why:
            await self._app(scope, receive, send)
            return
        if status == 401:
            await anyio.sleep(WRONG_S)
        await PlainTextResponse(f"{why}\n", status)(scope, receive, send)

    def _refused(self, scope: Scope) -> tuple[int, str]:
        """The status and why; "" for what may come in."""
        if scope["type"] != "http":
            return 403, "speak HTTP"
        headers = Headers(scope=scope)
        host, origin = headers.get("host", ""), headers.get("origin")
        if not self._access.host_allowed(host):
            return 403, "this server has another name: use the address that it told"
        if origin is not None and not self._access.origin_allowed(origin, host):
            return 403, "no page of another origin may ask"
        if not self._access.bearer_right(headers.get("authorization", "")):
            return 401, "the token is another: Authorization: Bearer TOKEN"
        return 200, ""


def agent_app(server: Server[Any], allowed: Access) -> ASGIApp:
    """The application."""
    app = server.streamable_http_app(
        streamable_http_path=PATH,
        max_request_body_size=BODY_BYTES,
        session_idle_timeout=IDLE_S,
        max_sessions=SESSIONS_MOST,
    )
    return AgentGate(app, allowed)


def agent_settings() -> dict[str, Any]:
    """How uvicorn serves it: without WebSockets."""
    return http_settings(CONNECTIONS_MOST, BODY_BYTES) | {"ws": "none"}


def serve_http(server: Server[Any], allowed: Access, ready: Callable[[], None]) -> None:
    """See `listening.serve`."""
    serve(agent_app(server, allowed), allowed, agent_settings(), ready)
