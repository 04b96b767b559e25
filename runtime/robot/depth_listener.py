"""A depth camera that is only looked at: nobody drives by it, and nothing is served."""

import threading
from functools import partial
from types import TracebackType
from typing import Any, Self

from runtime.clock import Clock, Deadline
from runtime.robot.dialects.choice import spoken
from runtime.robot.heard_topics import TF_TOPICS, heard_topics
from runtime.robot.optics import DepthSight
from runtime.robot.ros_node import RosNode
from runtime.robot.session import BusConfig, open_session
from runtime.robot.streams import SensorStreams
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import CameraConfig

HEARD = ("depth", "depth_info", "camera_info")


class DepthListener:
    """See the module. BusError where the bus cannot be opened."""

    def __init__(self, config: BusConfig, camera: CameraConfig, clock: Clock) -> None:
        self._clock, self._changed = clock, threading.Condition()
        self._streams = SensorStreams(config, clock, self._changed, False, camera)
        self._looked_at: RawMessage | None = None
        self._session: Any = open_session(config)
        self._node = RosNode(self._session, spoken(config), self._streams.count_bad)
        topics = heard_topics(config)
        for stream in HEARD:
            if stream in self._streams.topics:
                self._node.subscribe(topics[stream], partial(self._file, stream))
        for topic in TF_TOPICS:
            self._node.subscribe(topic, self._streams.file_transforms)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._node.close()
        self._session.close()

    def look(self, by: Deadline) -> DepthSight | None:
        """The next depth image as its camera saw it; None when none came in time, or its intrinsics
        are not known. SensorError as `SensorStreams.sight`."""
        last = self._looked_at
        with self._changed:
            while (depth := self._streams.newest_depth()) is last and not by.passed():
                self._clock.wait(self._changed, by.at_s)
            self._looked_at = depth
        return self._streams.look(depth) if depth is not None and depth is not last else None

    def _file(self, stream: str, name: str, payload: bytes) -> None:
        self._streams.file(stream, payload)
