"""A bus for the actions of ROS 2 alone: a node that is on none, and requests that wait for whoever
answers them."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

from fake_node import FakeNode

from runtime.core.types import Pose
from runtime.errors import SensorError
from runtime.robot.requests import Requests


class ActionDesk:
    """An `ActionBus`."""

    def __init__(self) -> None:
        self.node: Any = FakeNode()
        self.distro = "jazzy"
        self.on_feedback: Callable[[Mapping[str, Any]], None] = lambda told: None
        self.requests = Requests(threading.Condition(), lambda topic: topic)

    def file(self, kind: str, query: Any) -> None:
        self.requests.file(kind, f"rfnav/{kind}", query)

    def placed(self, pose: Pose, frame: str) -> Pose:
        if frame:
            raise SensorError(f"frame_id: {frame!r:.80}")
        return pose

    def frame_of(self, stream: str, otherwise: str) -> str:
        return f"{stream} of its own"
