"""What nodes of rmw_zenoh send beside messages: keys, what goes along with requests, and requests
to an action."""

import io
import struct
from collections.abc import Callable
from contextlib import redirect_stderr
from typing import Any

from fibonacci import FIBONACCI, LE

from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.action_server import ActionServer
from runtime.robot.dialects.dialect import RosTopic
from runtime.robot.dialects.rmw_zenoh import RmwZenoh

ODOM, DIALECT = RosTopic("odom", wire.ODOMETRY), RmwZenoh("", 0, "jazzy")
ID = bytes(range(16))
KEYS = [DIALECT.publishes_on(ODOM).encode()]
ATTACHED = [DIALECT.attachment(5, 7, ID) or b""]
REQUESTS = {
    "send_goal": LE + ID + struct.pack("<i", 5),
    "cancel_goal": LE + ID + struct.pack("<iI", 3, 0),
    "get_result": LE + ID,
}


class _Node:
    def __init__(self) -> None:
        self.served: dict[str, Callable[[Any], None]] = {}

    def publisher(self, *_: Any) -> Any:
        return self

    def serve(self, service: Any, answer: Callable[[Any], None]) -> None:
        self.served[service.name.rpartition("/")[2]] = answer

    def put(self, payload: bytes) -> None:
        assert payload[:4] == LE


class _Call:
    def __init__(self, payload: bytes) -> None:
        self.payload, self.ended = payload, 0

    def reply(self, payload: bytes) -> None:
        assert payload[:4] == LE
        self.ended += 1

    def drop(self) -> None:
        self.ended += 1


def ros(data: bytes, refused: Callable[[str], None]) -> None:
    """By its first byte: a key, an attachment, or a request to an action that has a goal."""
    if not data:
        return
    number, told = data[0] % (2 + len(REQUESTS)), data[1:]
    if number == 0:
        key = "/".join(
            part or "x" for part in ("a/b/c/" + told.decode("utf-8", "replace")).split("/")
        )
        try:
            DIALECT.name_of(key, ODOM)
        except SensorError as error:
            refused(str(error))
    elif number == 1:
        reply = DIALECT.reply_attachment(told, 7)
        assert reply is None or len(reply) == 33
    else:
        _asked(list(REQUESTS)[number - 2], told, refused)


def _asked(what: str, payload: bytes, refused: Callable[[str], None]) -> None:
    node, call = _Node(), _Call(payload)
    owner = lambda goal, accept: accept(True), lambda goals, ending: ending(goals)
    server: Any = ActionServer(node, "fibonacci", FIBONACCI, *owner)  # type: ignore[arg-type]
    if what != "send_goal":
        node.served["send_goal"](_Call(REQUESTS["send_goal"]))
    with redirect_stderr(io.StringIO()) as told:
        node.served[what](call)
    if server.bad:
        refused(told.getvalue().strip())
    server.close()
    assert call.ended == 1


def seeds() -> list[bytes]:
    told = [*KEYS, *ATTACHED, *REQUESTS.values()]
    told[0] = told[0].removeprefix(b"0/odom/")
    return [bytes((number,)) + seed for number, seed in enumerate(told)]
