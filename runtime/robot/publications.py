"""What the robot's side says on the bus: commands to the base, answers in lockstep, and reports."""

from collections.abc import Mapping
from typing import Any, Final

import zenoh

from runtime.core.types import Action, Twist
from runtime.errors import BusError
from runtime.journal import plain
from runtime.record import Record, unrecorded
from runtime.robot import wire
from runtime.robot.session import OWN_TOPICS, BusConfig
from runtime.robot.streams import WireMessage

__all__ = ["Publications"]

COMMANDS: Final = ("action", "cmd_vel")
LAST: Final = "last cmd_vel"
REPORTS: Final = ("state", "decision", "feedback")


class Publications:
    """The publishers of one session. In `lockstep` every message blocks, all are of one priority,
    and the last answer is kept: it can be given again. In real time no message waits for a wire
    that is full, but the last velocity: of the others the next one follows in a twentieth of a
    second, and whoever sends them holds up control."""

    def __init__(
        self, session: Any, config: BusConfig, lockstep: bool, record: Record = unrecorded
    ) -> None:
        self._config = config
        self._record = record
        self._answer: tuple[int, bytes] | None = None  # to which observation, and what
        self._publishers: dict[str, Any] = {
            name: self._declare(session, name, lockstep) for name in (*COMMANDS, LAST, *REPORTS)
        }
        self._declared = list(self._publishers.values())

    def action(self, stamp_ns: int, action: Action, twist: Twist | None) -> None:
        """See `Bus.publish_action`."""
        answer: dict[str, object] = {"stamp_ns": stamp_ns, "action": action.value}
        if twist is not None:
            answer |= {"v_mps": twist.v_mps, "w_radps": twist.w_radps}
        payload = wire.encode_json(answer)
        self._answer = (stamp_ns, payload)
        self._put("action", payload)

    def twist(self, twist: Twist, stamp_ns: int, last: bool = False) -> None:
        """A velocity. The stamp, for a TwistStamped, is of the robot's own clock; `last`: none
        follows."""
        kind = wire.TWIST if self._config.cmd_vel_type == "Twist" else wire.TWIST_STAMPED
        if kind == wire.TWIST:
            payload = wire.encode_twist(twist.v_mps, twist.w_radps)
        else:
            frame = self._config.cmd_vel_frame
            payload = wire.encode_twist_stamped(twist.v_mps, twist.w_radps, stamp_ns, frame)
        self._record("wire", WireMessage(self._config.topics.cmd_vel, kind, payload))
        self._put(LAST if last else "cmd_vel", payload)

    def report(self, name: str, content: Mapping[str, object]) -> None:
        """One of `REPORTS`, as JSON."""
        self._put(name, wire.encode_json(plain(content)))

    def answer_again(self, stamp_ns: int) -> None:
        """An observation came twice, for a harness sends again what it got no answer to: a step is
        never taken twice, but an answer that was lost is given again."""
        if self._answer is not None and self._answer[0] == stamp_ns:
            self._put("action", self._answer[1])

    def forget_answer(self) -> None:
        self._answer = None

    def undeclare(self) -> None:
        """Idempotent. What is published afterwards is a BusError."""
        declared, self._declared = self._declared, []
        for publisher in declared:
            publisher.undeclare()

    def _declare(self, session: Any, name: str, lockstep: bool) -> Any:
        # In lockstep one priority for all: what was published first arrives first. So it is with
        # velocities: those that wait and those that do not are of one priority.
        urgent = name in (*COMMANDS, LAST) and not lockstep
        return session.declare_publisher(
            self._config.key(OWN_TOPICS.get(name, self._config.topics.cmd_vel)),
            congestion_control=zenoh.CongestionControl.BLOCK
            if lockstep or name == LAST
            else zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.INTERACTIVE_HIGH if urgent else zenoh.Priority.DATA,
            express=True,
        )

    def _put(self, name: str, payload: bytes) -> None:
        try:
            self._publishers[name].put(payload)
        except zenoh.ZError as error:
            raise BusError(f"{name}: cannot be published: {error}") from error
