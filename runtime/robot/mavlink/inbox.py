"""What a link brought becomes messages. No thread, no clock, no socket."""

from typing import Any

from pymavlink.dialects.v20 import common as mavlink


class Inbox:
    """`bad`: messages that could not be read; those are dropped."""

    def __init__(self) -> None:
        self.bad = 0
        self._parser = _parser()

    def read(self, data: bytes, datagram: bool) -> list[Any]:
        """The messages in what came. A datagram is read on its own, so that what is broken in one
        takes no other with it."""
        if datagram:
            self.clear()
        found = self._parser.parse_buffer(data) or []
        messages = [message for message in found if message.get_type() != "BAD_DATA"]
        self.bad += len(found) - len(messages)
        return messages

    def clear(self) -> None:
        """What comes next is the beginning of another stream."""
        self._parser = _parser()


def _parser() -> Any:
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True  # what is broken is a message that says so, not an exception
    return parser
