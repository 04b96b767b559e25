"""Who looks: each page has what is newest of every kind waiting for it, and no more, however slow
it is. All but what `HubAudience` does is the event loop's."""

import asyncio
import json
import time
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, Final, Protocol

from runtime.view.feed import Content
from runtime.view.tiles import TileMap, TilesHeld

PAGES_MOST: Final = 8
ANSWERS_KEPT: Final = 32  # that wait for a slow page; of more the oldest are lost
HIDDEN_S: Final = 1.0  # between two states for a page that nobody sees
ORDER: Final = (
    "welcome", "stop", "state", "decision", "zones", "places", "timeline", "span", "at", "health",
    "names", "scene", "boxes",
)  # fmt: skip
"""Of what waits, what goes first."""
HIDDEN: Final = ("welcome", "stop", "state", "decision", "timeline", "span")
"""What a page gets that nobody sees."""


class PageSocket(Protocol):
    """The sending half of a WebSocket: each returns when the wire has room again."""

    async def send_text(self, data: str) -> None: ...

    async def send_bytes(self, data: bytes) -> None: ...


class Page:
    """One page: what waits to be sent to it."""

    def __init__(self, number: int, tiles: TileMap) -> None:
        self.number, self._tiles = number, tiles
        self.camera = self.hidden = False
        self._waiting: dict[str, str] = {}
        self._answers: deque[str] = deque(maxlen=ANSWERS_KEPT)
        self._picture: bytes | None = None
        self._mapped, self._seen = True, TilesHeld()
        self._stated_s = 0.0
        self._woken = asyncio.Event()

    def offer(self, kind: str, text: str) -> None:
        """The newest of a kind, in place of what waited of it."""
        if self.hidden and kind not in HIDDEN:
            return
        if self.hidden and kind == "state":
            if time.monotonic() - self._stated_s < HIDDEN_S:
                return
            self._stated_s = time.monotonic()
        self._waiting[kind] = text
        self._woken.set()

    def answer(self, text: str) -> None:
        """None of them takes the place of another."""
        self._answers.append(text)
        self._woken.set()

    def picture(self, message: bytes) -> None:
        """An image that was not sent when the next one comes never is."""
        if self.camera and not self.hidden:
            self._picture = message
            self._woken.set()

    def mapped(self) -> None:
        """There is more of the map."""
        self._mapped = True
        self._woken.set()

    async def send(self, socket: PageSocket) -> None:
        """Send what waits, for ever; whoever has its task ends it."""
        while True:
            await self._woken.wait()
            self._woken.clear()
            while (message := self._next()) is not None:
                if isinstance(message, bytes):
                    await socket.send_bytes(message)
                else:
                    await socket.send_text(message)

    def _next(self) -> str | bytes | None:
        if "welcome" not in self._waiting and self._answers:
            return self._answers.popleft()
        for kind in ORDER:
            if kind in self._waiting:
                return self._waiting.pop(kind)
        if self._waiting:
            return self._waiting.pop(next(iter(self._waiting)))
        if self._mapped and not self.hidden:
            found = self._tiles.since(self._seen)
            if found is not None:
                message, self._seen = found
                return message
            self._mapped = False
        picture, self._picture = self._picture, None
        return picture


class Hub:
    """`attend` is told how many look, and at the camera, whenever that changes."""

    def __init__(self, tiles: TileMap) -> None:
        self._tiles, self._pages = tiles, dict[int, Page]()
        self._newest: dict[str, str] = {}
        self._numbers = 0

    @property
    def full(self) -> bool:
        return len(self._pages) >= PAGES_MOST

    def enter(self, welcome: Content) -> Page:
        """Another page, which has all that is newest waiting."""
        self._numbers += 1
        page = Page(self._numbers, self._tiles)
        page.offer("welcome", encoded("welcome", {"v": 1, "you": page.number, **welcome}))
        self._pages[page.number] = page
        self.refresh(page)
        return page

    def leave(self, page: Page) -> None:
        self._pages.pop(page.number, None)

    def refresh(self, page: Page) -> None:
        """All that is newest, for a page that has missed some."""
        for kind, text in self._newest.items():
            page.offer(kind, text)
        page.mapped()

    def looking(self) -> tuple[int, int]:
        """How many pages there are, and how many of them show the camera."""
        cameras = sum(page.camera and not page.hidden for page in self._pages.values())
        return len(self._pages), cameras

    def put(self, kind: str, text: str) -> None:
        self._newest[kind] = text
        for page in self._pages.values():
            page.offer(kind, text)

    def picture(self, message: bytes) -> None:
        for page in self._pages.values():
            page.picture(message)

    def mapped(self) -> None:
        for page in self._pages.values():
            page.mapped()


class HubAudience:
    """An `Audience`: any thread may tell, and none of them waits."""

    def __init__(self, hub: Hub, loop: asyncio.AbstractEventLoop) -> None:
        self._hub, self._loop = hub, loop

    def tell(self, kind: str, content: Content) -> None:
        self._call(self._hub.put, kind, encoded(kind, content))

    def picture(self, message: bytes) -> None:
        self._call(self._hub.picture, message)

    def mapped(self) -> None:
        self._call(self._hub.mapped)

    def _call(self, what: Any, *given: Any) -> None:
        with suppress(RuntimeError):  # the loop has ended, and all pages with it
            self._loop.call_soon_threadsafe(what, *given)


def encoded(kind: str, content: Mapping[str, Any]) -> str:
    """A message as text; `t_s`: now, unless the content has its own. ValueError for a number that
    no browser reads."""
    told = {"t_s": round(time.time(), 3), **content, "kind": kind}
    return json.dumps(told, allow_nan=False, separators=(",", ":"))
