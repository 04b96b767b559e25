"""The action that ROS 2's own examples have, and a client of it over plain Zenoh: what it sends and
reads is made of `struct` alone."""

import struct
import threading
from typing import Any

from runtime.robot.action_types import ActionType

FIBONACCI = ActionType.define(
    "example_interfaces/action/Fibonacci", "int32 order", "int32[] sequence", "int32[] sequence"
)
LE = b"\x00\x01\x00\x00"
KEYS = {
    "ros2dds": "fibonacci/_action/{0}",
    "rmw_zenoh": "0/fibonacci/_action/{0}/{1}",
}
KINDS = {  # as rmw_zenoh_cpp names them for Jazzy
    "send_goal": "example_interfaces::action::dds_::Fibonacci_SendGoal_/"
    "RIHS01_d1a57fb2a4afe8c21e34fb10db206f16ce6729b28531141472df92277c55b557",
    "get_result": "example_interfaces::action::dds_::Fibonacci_GetResult_/"
    "RIHS01_1b0de0d5d29dc955d92f546706568428632771db13ec84c15ec1c1a59f424a57",
    "feedback": "example_interfaces::action::dds_::Fibonacci_FeedbackMessage_/"
    "RIHS01_c1de71afd52e49a89c53d8262366884185bc0a02f78ce051c4e46b0a7fe59bb2",
    "cancel_goal": "action_msgs::srv::dds_::CancelGoal_/"
    "RIHS01_573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
    "status": "action_msgs::msg::dds_::GoalStatusArray_/"
    "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
}


def sequence(order: int) -> list[int]:
    numbers = [0, 1]
    while len(numbers) <= order:
        numbers.append(numbers[-1] + numbers[-2])
    return numbers


class FibonacciClient:
    """Of one dialect."""

    def __init__(self, session: Any, spoken: str) -> None:
        self.session, self.spoken, self._count = session, spoken, 0
        self.fed: list[tuple[bytes, list[int]]] = []
        self.statuses: list[list[tuple[bytes, int]]] = []
        self.changed = threading.Condition()
        session.declare_subscriber(self.key("feedback"), self._feedback)
        session.declare_subscriber(self.key("status"), self._status)

    def key(self, what: str) -> str:
        return KEYS[self.spoken].format(what, KINDS[what])

    def send_goal(self, id: bytes, order: int) -> bool:
        reply = self._ask("send_goal", id + struct.pack("<i", order))
        return bool(reply[4])

    def get_result(self, id: bytes) -> tuple[int, list[int]]:
        """Status, and the sequence."""
        reply = self._ask("get_result", id)
        return reply[4], _ints(reply, 8)

    def cancel(self, id: bytes, sec: int = 0, nanosec: int = 0) -> tuple[int, int]:
        """Return code, and how many goals are being ended."""
        reply = self._ask("cancel_goal", id + struct.pack("<iI", sec, nanosec))
        return reply[4], struct.unpack_from("<I", reply, 8)[0]

    def _ask(self, what: str, body: bytes) -> bytes:
        self._count += 1
        goes_along = None
        if self.spoken == "rmw_zenoh":
            goes_along = struct.pack("<qqB16s", self._count, 5, 16, b"a fine client...")
        found = list(
            self.session.get(self.key(what), payload=LE + body, attachment=goes_along, timeout=30.0)
        )
        (reply,) = found
        if goes_along is not None:
            number, _, _, gid = struct.unpack("<qqB16s", reply.ok.attachment.to_bytes())
            assert (number, gid) == (self._count, b"a fine client...")
        payload: bytes = reply.ok.payload.to_bytes()
        assert payload[:4] == LE
        return payload

    def _feedback(self, sample: Any) -> None:
        payload = sample.payload.to_bytes()
        with self.changed:
            self.fed.append((payload[4:20], _ints(payload, 20)))
            self.changed.notify_all()

    def _status(self, sample: Any) -> None:
        payload = sample.payload.to_bytes()
        count, at, told = struct.unpack_from("<I", payload, 4)[0], 8, []
        for _ in range(count):
            id, at = payload[at : at + 16], at + 16
            at += -at % 4 + 8  # when it was accepted
            told.append((id, payload[at]))
            at += 1
        with self.changed:
            self.statuses.append(told)
            self.changed.notify_all()


def _ints(payload: bytes, at: int) -> list[int]:
    (count,) = struct.unpack_from("<I", payload, at)
    return list(struct.unpack_from(f"<{count}i", payload, at + 4))
