"""A query to the runtime, to be answered by the thread that owns the bus."""

import json
from collections.abc import Callable, Mapping
from typing import Any

import zenoh

from runtime.journal import plain


class Request:
    """A query to the runtime. Reply once, which calls `answered`; a reply to a querier that has
    gone is lost quietly."""

    def __init__(
        self,
        kind: str,
        body: dict[str, Any],
        query: Any,
        key: str,
        answered: Callable[[], None] = lambda: None,
    ) -> None:
        self._answered = answered
        self.kind = kind
        self.body = body
        self._query = query
        self._key = key

    def reply(self, answer: Mapping[str, object]) -> None:
        try:
            self._query.reply(self._key, json.dumps(plain(answer)))
        except zenoh.ZError:
            pass  # the session that asked has closed
        finally:
            self._query.drop()
            self._answered()
