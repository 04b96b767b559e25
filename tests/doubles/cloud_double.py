"""An OpenAI-compatible server on loopback that behaves as it is told to, mostly badly."""

import json
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Self

PATIENCE_S = 20.0


def ids_of(body: dict[str, Any]) -> list[int]:
    """The frontiers that the request's schema admits."""
    form = body["response_format"]
    schema = form["json_schema"]["schema"] if "json_schema" in form else form["schema"]
    return list(schema["properties"]["frontiers"]["anyOf"][0]["items"]["enum"])


def completion(content: object, usage: object = None) -> dict[str, Any]:
    body: dict[str, Any] = {"choices": [{"message": {"role": "assistant", "content": content}}]}
    return body | ({"usage": usage} if usage is not None else {})


def answer(frontiers: object, reason: str = "it looks right") -> str:
    return json.dumps({"reason": reason, "frontiers": frontiers})


def vote(body: dict[str, Any]) -> tuple[int, Any]:
    """For the first frontier; what was used is said."""
    usage = {"prompt_tokens": 100, "completion_tokens": 10, "total_tokens": 110}
    return 200, completion(answer(ids_of(body)[:1]), usage)


class Server:
    """`behave` takes the request's JSON and returns (status, JSON or text), or is "hang" (never an
    answer), "drip" (a byte now and then, for ever), "flood" (bytes for ever) or "break"."""

    def __init__(self, behave: Callable[[dict[str, Any]], tuple[int, Any]] | str = vote) -> None:
        self.behave = behave
        self.headers: dict[str, str] = {}  # of the replies
        self.requests: list[dict[str, Any]] = []
        self.auth: list[str | None] = []
        self.asked = threading.Event()
        self._over = threading.Event()
        double = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self) -> None:
                double._serve(self)

            def log_message(self, *_: object) -> None:
                pass

        self._http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._http.daemon_threads = True
        self._thread = threading.Thread(target=self._http.serve_forever, args=(0.01,), daemon=True)

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self._http.server_address[1]}/v1"

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._http.shutdown()
        self._thread.join(PATIENCE_S)
        self._http.server_close()

    def _serve(self, handler: BaseHTTPRequestHandler) -> None:
        body = json.loads(handler.rfile.read(int(handler.headers["Content-Length"])))
        assert handler.path == "/v1/chat/completions"
        self.requests.append(body)
        self.auth.append(handler.headers.get("Authorization"))
        self.asked.set()
        if callable(self.behave):
            status, said = self.behave(body)
            data = said.encode() if isinstance(said, str) else json.dumps(said).encode()
            self._reply(handler, status, data)
            return
        handler.close_connection = True
        if self.behave == "hang":
            self._over.wait(PATIENCE_S)
        elif self.behave in ("drip", "flood"):
            self._endless(handler)

    def _reply(self, handler: BaseHTTPRequestHandler, status: int, data: bytes) -> None:
        handler.send_response(status)
        for name, value in {"Content-Type": "application/json", **self.headers}.items():
            handler.send_header(name, value)
        handler.send_header("Content-Length", str(len(data)))
        handler.end_headers()
        handler.wfile.write(data)

    def _endless(self, handler: BaseHTTPRequestHandler) -> None:
        piece = b"{" if self.behave == "drip" else b" " * 65536
        handler.send_response(200)
        handler.send_header("Content-Length", str(10**9))
        handler.end_headers()
        try:
            while not self._over.wait(0.02 if self.behave == "drip" else 0.0):
                handler.wfile.write(piece)
                handler.wfile.flush()
        except OSError:
            pass  # the client has had enough
