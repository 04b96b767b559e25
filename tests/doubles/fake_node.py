"""A node of ROS 2 that is on no bus: what is served is called here, what is published is kept."""

from collections.abc import Callable
from typing import Any

LE = b"\x00\x01\x00\x00"  # how CDR begins


class FakeNode:
    """`served`: by the last part of a service's name; `published`: payloads by a topic's."""

    def __init__(self) -> None:
        self.served: dict[str, Callable[[Any], None]] = {}
        self.published: dict[str, list[bytes]] = {}

    def publisher(self, topic: Any, *_: Any) -> Any:
        return _Publisher(self.published.setdefault(topic.name, []))

    def serve(self, service: Any, answer: Callable[[Any], None]) -> None:
        self.served[service.name] = answer

    def call(self, name: str, body: bytes) -> "FakeCall":
        """Ask a service; `body`: CDR without its head."""
        call = FakeCall(LE + body)
        self.served[name](call)
        return call


class FakeCall:
    """`replies`: without CDR's head."""

    def __init__(self, payload: bytes) -> None:
        self.payload, self.dropped, self.replies = payload, 0, list[bytes]()

    def reply(self, payload: bytes) -> None:
        assert payload[:4] == LE
        self.replies.append(payload[4:])

    def drop(self) -> None:
        self.dropped += 1


class _Publisher:
    def __init__(self, kept: list[bytes]) -> None:
        self._kept = kept

    def put(self, payload: bytes) -> None:
        assert payload[:4] == LE
        self._kept.append(payload[4:])
