"""Our server for agents in a thread, on a free port, and the SDK's own client of it."""

import asyncio
import http.client
import json
import socket
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Any

import httpx2
import uvicorn
from agent_service import AgentService
from mcp import Client
from mcp.client.streamable_http import streamable_http_client

from hil_sim.driving.link import free_port
from runtime.agents.http import agent_app, agent_settings
from runtime.agents.robot import AgentParts, AgentRobot
from runtime.agents.server import AgentServer
from runtime.agents.tools import AgentLimits
from runtime.commands.map_picture import picture
from runtime.commands.running import running
from runtime.view.access import Access

PATIENCE_S = 20.0
ERAS = ("auto", "legacy")  # of the protocol: one POST each, and sessions
ONE_A_LOOP = "_shutdown_watcher"  # sse_starlette begins it with the first stream


def until(what: Callable[[], Any]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.01)


class Served:
    """`url`; `agents`: the server's inside; `tasks`: how many there are in its loop."""

    def __init__(self, service: AgentService, limits: AgentLimits, token: str) -> None:
        self.port, self.token = free_port(), token
        self.url = f"http://127.0.0.1:{self.port}/mcp"
        parts = AgentParts(lambda: running(service.bus), service.bus, picture, limits)
        self.robot = AgentRobot(parts)
        self.agents = AgentServer(self.robot, limits)
        names = frozenset({f"127.0.0.1:{self.port}", f"localhost:{self.port}"})
        app = agent_app(self.agents.server("1"), Access("127.0.0.1", self.port, names, token))
        self._uvicorn = uvicorn.Server(uvicorn.Config(app, **agent_settings()))
        self._loop: asyncio.AbstractEventLoop | None = None

    def tasks(self) -> int:
        assert self._loop is not None
        found: list[int] = []
        done = threading.Event()

        def count() -> None:
            names = [task.get_coro().__name__ for task in asyncio.all_tasks(self._loop)]
            found.append(len(names) - names.count(ONE_A_LOOP))
            done.set()

        self._loop.call_soon_threadsafe(count)
        assert done.wait(PATIENCE_S)
        return found[0]

    @contextmanager
    def up(self) -> Iterator["Served"]:
        async def serve(listening: socket.socket) -> None:
            self._loop = asyncio.get_running_loop()
            await self._uvicorn.serve(sockets=[listening])

        with socket.socket() as listening:
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.bind(("127.0.0.1", self.port))
            thread = threading.Thread(target=lambda: asyncio.run(serve(listening)), daemon=True)
            thread.start()
            try:
                until(lambda: self._uvicorn.started)
                yield self
            finally:
                self._uvicorn.should_exit = True
                thread.join(PATIENCE_S)
                self.robot.close()
                assert not thread.is_alive()

    @asynccontextmanager
    async def client(self, mode: str = "auto"):
        headers = {"authorization": f"Bearer {self.token}"} if self.token else {}
        async with httpx2.AsyncClient(headers=headers, timeout=PATIENCE_S) as http:
            wire = streamable_http_client(self.url, http_client=http)
            async with Client(wire, mode=mode, read_timeout_seconds=PATIENCE_S) as client:
                yield client

    def run(self, does: Callable[[Client], Awaitable[Any]], mode: str = "auto") -> Any:
        """What a client of its own makes of it."""

        async def work() -> Any:
            async with self.client(mode) as client:
                return await does(client)

        return asyncio.run(work())


class RawSession:
    """A session spoken by hand, over one connection."""

    def __init__(self, served: Served) -> None:
        self.wire = http.client.HTTPConnection("127.0.0.1", served.port, timeout=PATIENCE_S)
        self._headers = {
            "Content-Type": "application/json",
            "Accept": "application/json, text/event-stream",
            "Mcp-Protocol-Version": "2025-06-18",
        }
        info = {"name": "raw", "version": "1"}
        about = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": info}
        self.say("initialize", **about)
        told = self.wire.getresponse()
        self._headers["Mcp-Session-Id"] = told.headers["mcp-session-id"]
        told.read()

    def say(self, method: str, **params: Any) -> None:
        """A request; `wire` has its answer."""
        asked = {"jsonrpc": "2.0", "id": 1, "method": method, "params": params}
        self.wire.request("POST", "/mcp", json.dumps(asked), self._headers)


def facts(result: Any) -> dict[str, Any]:
    told: dict[str, Any] = result.structured_content["facts"]
    return told


def words(result: Any) -> dict[str, Any]:
    told: dict[str, Any] = result.structured_content["untrusted"]
    return told
