"""What a page's server is fed by: a service that runs, or a recording."""

from collections.abc import Mapping
from typing import Any, Protocol

from runtime.view.tiles import TileMap

Content = Mapping[str, Any]


class Audience(Protocol):
    """Who is told; any thread may tell."""

    def tell(self, kind: str, content: Content) -> None:
        """A message to all pages: the newest of a kind is what counts."""
        ...

    def picture(self, message: bytes) -> None:
        """The newest image, as pages get it."""
        ...

    def mapped(self) -> None:
        """The map has changed."""
        ...


class Feed(Protocol):
    """`tiles`: the map. Any thread may call any of it; what `ask` returns may take seconds, all
    else returns at once."""

    tiles: TileMap

    def start(self, audience: Audience) -> None: ...

    def welcome(self) -> dict[str, Any]:
        """What a page is told first, beside its kind."""
        ...

    def attend(self, pages: int, cameras: int) -> None:
        """So many look now, and so many of them at the camera."""
        ...

    def ask(self, what: str, body: object) -> dict[str, Any]:
        """Have done what a page asks; the answer. ValueError or RfNavError, one line."""
        ...

    def steer(self, who: int, order: Content) -> None:
        """What a page says without an answer: `teleop`, `seek`, `play`. Nonsense is left out."""
        ...

    def gone(self, who: int) -> None:
        """A page has gone: what it held is let go."""
        ...

    def close(self) -> None: ...
