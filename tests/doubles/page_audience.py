"""Who hears what a feed tells."""

import json
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

PATIENCE_S = 15.0


class PageAudience:
    """Keeps it; all of it must be JSON."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.newest: dict[str, dict[str, Any]] = {}
        self.count: dict[str, int] = {}
        self.pictures: list[bytes] = []
        self.maps = 0

    def tell(self, kind: str, content: Mapping[str, Any]) -> None:
        with self.changed:
            self.newest[kind] = json.loads(json.dumps(content))
            self.count[kind] = self.count.get(kind, 0) + 1
            self.changed.notify_all()

    def picture(self, message: bytes) -> None:
        with self.changed:
            self.pictures.append(message)
            self.changed.notify_all()

    def mapped(self) -> None:
        with self.changed:
            self.maps += 1
            self.changed.notify_all()

    def wait(self, kind: str, like: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The newest of a kind, once it is like that."""
        with self.changed:
            until_s = time.monotonic() + PATIENCE_S
            while not (kind in self.newest and like(self.newest[kind])):
                left_s = until_s - time.monotonic()
                assert left_s > 0, (kind, self.newest.get(kind))
                self.changed.wait(left_s)
            return self.newest[kind]
