"""A page as a browser opens it: by the WebSocket that our server has, with what a browser sends."""

import json
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

from websockets.sync.client import ClientConnection, connect

PATIENCE_S = 10.0


class PageClient:
    """Speaks to the server on a port of this computer; `token` goes with the hello. What it is sent
    and does not ask for with `next` fills the wire: it is a slow one."""

    def __init__(
        self,
        port: int,
        token: str | None = None,
        origin: str | None = None,
        hello: Mapping[str, Any] | None = None,
    ) -> None:
        self._stack = ExitStack()
        opened = connect(
            f"ws://127.0.0.1:{port}/ws",
            origin=origin if origin is not None else f"http://127.0.0.1:{port}",  # type: ignore[arg-type]
            subprotocols=["rfnav.1"],  # type: ignore[list-item]
            compression=None,
            max_size=1 << 24,
            proxy=None,
        )
        self.socket: ClientConnection = self._stack.enter_context(opened)
        self.say(**(hello or {"kind": "hello", "v": 1, "token": token}))
        self.heard: dict[str, dict[str, Any]] = {}

    def say(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def say_raw(self, data: str | bytes) -> None:
        self.socket.send(data)

    def next(self, timeout_s: float = PATIENCE_S) -> dict[str, Any] | bytes:
        message = self.socket.recv(timeout=timeout_s)
        if isinstance(message, bytes):
            return message
        told: dict[str, Any] = json.loads(message)
        self.heard[told["kind"]] = told
        return told

    def wait(self, kind: str, **like: Any) -> dict[str, Any]:
        """The next message of a kind that has these values."""
        while True:
            told = self.next()
            wanted = {"kind": kind, **like}
            if isinstance(told, dict) and all(told.get(k) == v for k, v in wanted.items()):
                return told

    def binary(self, kind: int) -> bytes:
        while True:
            told = self.next()
            if isinstance(told, bytes) and told[0] == kind:
                return told

    def ask(self, n: int, what: str, **body: Any) -> dict[str, Any]:
        self.say(kind="do", n=n, what=what, body=body)
        return self.wait("done", n=n)

    def close(self) -> None:
        self._stack.close()
