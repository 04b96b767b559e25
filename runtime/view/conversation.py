"""One page's WebSocket, from its hello on: what it may say, how much of that, and who answers."""

import asyncio
import time
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from runtime.errors import RfNavError
from runtime.robot.json_text import parse_json
from runtime.view.access import Access
from runtime.view.feed import Content, Feed
from runtime.view.hub import Hub, Page, encoded

SUBPROTOCOL: Final = "rfnav.1"
VERSION: Final = 1
MESSAGE_BYTES: Final = 16 << 10
HELLO_S: Final = 5.0
MESSAGES_A_S: Final = 60
OPEN_MOST: Final = 16  # questions of one page that wait for their answers
ANSWER_S: Final = 6.0
BAD_HELLO, NO_TOKEN, TOO_MUCH = 4400, 4401, 4429
STEERING: Final = ("teleop", "seek", "play")


@dataclass(frozen=True)
class Around:
    """What a conversation needs. `hurried`: where a stop is asked, which waits behind nothing."""

    access: Access
    hub: Hub
    feed: Feed
    usual: Executor
    hurried: Executor


class RefusedError(Exception):
    """A page is sent away: with this code, and why."""

    def __init__(self, code: int, why: str) -> None:
        super().__init__(why)
        self.code, self.why = code, why


class Conversation:
    """`run` returns when the page has gone or was sent away."""

    def __init__(self, socket: WebSocket, around: Around) -> None:
        self._socket, self._around = socket, around
        self._open: set[asyncio.Task[None]] = set()
        self._left, self._refilled_s = float(MESSAGES_A_S), time.monotonic()

    async def run(self) -> None:
        await self._socket.accept(subprotocol=SUBPROTOCOL)
        try:
            await self._greeted()
            await self._talk()
        except RefusedError as refused:
            if self._socket.application_state is WebSocketState.CONNECTED:
                with suppress(WebSocketDisconnect, RuntimeError):
                    await self._socket.close(refused.code, refused.why)
        except WebSocketDisconnect:
            pass

    async def _greeted(self) -> None:
        """Its first message, in time."""
        try:
            hello = await asyncio.wait_for(self._heard(), HELLO_S)
        except TimeoutError as error:
            raise RefusedError(BAD_HELLO, "no hello") from error
        if hello.get("kind") != "hello" or hello.get("v") != VERSION:
            raise RefusedError(BAD_HELLO, f"say hello, version {VERSION}")
        if not self._around.access.token_right(hello.get("token")):
            await asyncio.sleep(1.0)  # whoever guesses waits
            raise RefusedError(NO_TOKEN, "the token is another")
        if self._around.hub.full:
            raise RefusedError(TOO_MUCH, "too many pages are open")

    async def _talk(self) -> None:
        hub, feed = self._around.hub, self._around.feed
        page = hub.enter(feed.welcome())
        feed.attend(*hub.looking())
        sends = asyncio.create_task(page.send(self._socket))
        hears = asyncio.create_task(self._hear(page))
        try:
            done, _ = await asyncio.wait({sends, hears}, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in (sends, hears, *self._open):
                task.cancel()
            hub.leave(page)
            feed.gone(page.number)
            feed.attend(*hub.looking())

    async def _hear(self, page: Page) -> None:
        while True:
            self._obey(page, await self._heard())

    async def _heard(self) -> dict[str, Any]:
        """The next message; RefusedError for one that is none, or one too many."""
        message = await self._socket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1005))
        now_s = time.monotonic()
        gained = (now_s - self._refilled_s) * MESSAGES_A_S
        self._left, self._refilled_s = min(MESSAGES_A_S, self._left + gained) - 1, now_s
        if self._left < 0:
            raise RefusedError(TOO_MUCH, "too many messages")
        text = message.get("text")
        if text is None:
            raise RefusedError(BAD_HELLO, "send JSON as text")
        try:
            return parse_json(text, "page", MESSAGE_BYTES)
        except RfNavError as error:
            raise RefusedError(BAD_HELLO, str(error)[:100]) from error

    def _obey(self, page: Page, said: Content) -> None:
        kind, hub, feed = said.get("kind"), self._around.hub, self._around.feed
        if kind == "watch":
            missed = page.hidden and not said.get("hidden")
            page.camera, page.hidden = bool(said.get("camera")), bool(said.get("hidden"))
            if missed:
                hub.refresh(page)
            if page.hidden:
                feed.gone(page.number)  # nobody looks where it drives to
            feed.attend(*hub.looking())
        elif kind in STEERING:
            feed.steer(page.number, said)
        elif kind == "do":
            self._do(page, said)

    def _do(self, page: Page, said: Content) -> None:
        n, what = said.get("n"), said.get("what")
        if not isinstance(n, int) or not isinstance(what, str):
            raise RefusedError(BAD_HELLO, "do: needs n and what")
        if len(self._open) >= OPEN_MOST and what != "stop":
            page.answer(encoded("done", {"n": n, "error": "too many questions wait"}))
            return
        task = asyncio.create_task(self._answered(page, n, what, said.get("body") or {}))
        self._open.add(task)
        task.add_done_callback(self._open.discard)

    async def _answered(self, page: Page, n: int, what: str, body: object) -> None:
        around = self._around
        executor = around.hurried if what == "stop" else around.usual
        asking = asyncio.get_running_loop().run_in_executor(executor, around.feed.ask, what, body)
        told: dict[str, Any] = {"n": n}
        try:
            told["answer"] = await asyncio.wait_for(asking, ANSWER_S)
        except (RfNavError, ValueError) as error:
            told["error"] = str(error)
        except TimeoutError:
            told["error"] = f"{what}: no answer within {ANSWER_S:g} s"
        page.answer(encoded("done", told))
