"""What the robot's side says on the bus: commands to the base, answers in lockstep, and reports."""

from collections.abc import Mapping
from typing import Final

from runtime.core.types import Action, Twist
from runtime.journal import plain
from runtime.record import Record, unrecorded
from runtime.robot import wire
from runtime.robot.dialects.dialect import Qos, RosTopic
from runtime.robot.ros_node import Publisher, RosNode, Sending
from runtime.robot.session import OWN_TOPICS, BusConfig
from runtime.robot.streams import WireMessage

__all__ = ["Publications"]

COMMANDS: Final = ("action", "cmd_vel")
REPORTS: Final = ("state", "decision", "feedback")


class Publications:
    """The publishers of one node. In `lockstep` every message blocks, all are of one priority,
    and the last answer is kept: it can be given again. In real time no message waits for a wire
    that is full, but the last velocity: of the others the next one follows in a twentieth of a
    second, and whoever sends them holds up control."""

    def __init__(
        self, node: RosNode, config: BusConfig, lockstep: bool, record: Record = unrecorded
    ) -> None:
        self._config = config
        self._record = record
        self._answer: tuple[int, bytes] | None = None  # to which observation, and what
        self._publishers = {
            name: self._declare(node, name, lockstep) for name in (*COMMANDS, *REPORTS)
        }

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
        kind = cmd_vel_topic(self._config).kind
        if kind == wire.TWIST:
            payload = wire.encode_twist(twist.v_mps, twist.w_radps)
        else:
            frame = self._config.cmd_vel_frame
            payload = wire.encode_twist_stamped(twist.v_mps, twist.w_radps, stamp_ns, frame)
        self._record("wire", WireMessage(self._config.topics.cmd_vel, kind, payload))
        self._publishers["cmd_vel"].put(payload, waits=last)

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

    def _declare(self, node: RosNode, name: str, lockstep: bool) -> Publisher:
        # In lockstep one priority for all: what was published first arrives first. So it is with
        # velocities: those that wait and those that do not are of one priority.
        urgent = name in COMMANDS and not lockstep
        sending = Sending(urgent=urgent, blocks=lockstep, may_wait=name == "cmd_vel")
        return node.publisher(_topic(name, self._config), sending)

    def _put(self, name: str, payload: bytes) -> None:
        self._publishers[name].put(payload)


def _topic(name: str, config: BusConfig) -> RosTopic:
    if name == "cmd_vel":
        return cmd_vel_topic(config)
    return RosTopic(OWN_TOPICS[name], wire.STRING)


def cmd_vel_topic(config: BusConfig) -> RosTopic:
    """What the base listens to: of commands only the newest is worth keeping."""
    kind = wire.TWIST if config.cmd_vel_type == "Twist" else wire.TWIST_STAMPED
    return RosTopic(config.topics.cmd_vel, kind, Qos(depth=1))
