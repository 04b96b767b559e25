"""What holds the base by hand: a stop, which stays until it is released, and a cancel that waits to
be answered. Both are heard in the threads of the bus, and ask no other thread."""

import threading
from collections.abc import Callable
from typing import Any

import zenoh

from runtime.core.motion.safety import Halt, HaltKind
from runtime.errors import SensorError
from runtime.robot import wire_senses
from runtime.robot.heard_topics import heard_topics
from runtime.robot.requests import Request
from runtime.robot.ros_node import RosNode
from runtime.robot.session import RELEASE, STOP, BusConfig

WAITS = Halt(HaltKind.CANCEL, "a cancel waits to be answered")


class Handbrake:
    """See the module. A button that is pressed cannot be released by anything else."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._by = ""  # who stopped it, "" when nobody
        self._pressed: dict[str, bool] = {}  # by topic: buttons
        self._cancels = 0  # that wait

    def stop(self, who: str) -> None:
        with self._lock:
            self._by = self._by or who

    def button(self, topic: str, pressed: bool) -> None:
        """A message of a button: letting go of it releases nothing."""
        with self._lock:
            self._pressed[topic] = pressed
            if pressed:
                self._by = self._by or topic

    def release(self) -> str:
        """Why it cannot be released; "" when it is."""
        with self._lock:
            pressed = sorted(topic for topic, down in self._pressed.items() if down)
            if pressed:
                return f"{pressed[0]} is still pressed"
            self._by = ""
            return ""

    def cancel(self, waits: bool) -> None:
        """One has come, or was answered."""
        with self._lock:
            self._cancels += 1 if waits else -1

    def halt(self) -> Halt | None:
        with self._lock:
            if self._by:
                return Halt(HaltKind.STOP, f"stopped by {self._by}: ask rfnav/release to go on")
            return WAITS if self._cancels > 0 else None


def serve_handbrake(
    session: Any, node: RosNode, config: BusConfig, brake: Handbrake, urgent: Callable[[], None]
) -> list[Any]:
    """Listen for a button, a stop and its release; what was declared of the latter. Each is
    answered where it is heard; `urgent` is called after a stop."""

    def press(topic: str, payload: bytes) -> None:
        try:
            pressed = wire_senses.decode_flag(payload, topic)
        except SensorError:
            pressed = True  # whoever says anything there does not mean that all is well
        brake.button(topic, pressed)
        if pressed:
            urgent()

    def stop(query: zenoh.Query) -> None:
        brake.stop(STOP)
        urgent()
        Request("stop", {}, query, config.key(STOP)).reply({"stopped": True})

    def release(query: zenoh.Query) -> None:
        why = brake.release()
        told: dict[str, object] = {"released": not why}
        if why:
            told["error"] = why
        Request("release", {}, query, config.key(RELEASE)).reply(told)

    button = heard_topics(config).get("stop")
    if button is not None:
        name = config.key(button.name)  # one of another type says no more than one that is broken
        node.subscribe(button, press, lambda: press(name, b""))
    return [
        session.declare_queryable(config.key(STOP), stop),
        session.declare_queryable(config.key(RELEASE), release),
    ]
