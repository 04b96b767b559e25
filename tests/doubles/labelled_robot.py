"""A robot in the flat-land apartment whose camera is told what it sees: labels go ahead of each
image, for a runtime with `research.detector_source = "topic"`."""

import struct
from typing import Any

from apartment import TWO_ROOMS, Apartment
from robot_double import RobotDouble

from runtime.core.types import Pose
from runtime.robot import wire
from runtime.robot.session import LABELS, BusConfig

CHAIR = {"chair": (1.25, 4.25, 0.3)}
STAMP = struct.Struct("<iI")  # at byte 4 of a message with a header


class LabelledRobot(RobotDouble):
    """It has a chair to find, three metres behind it."""

    def __init__(self, config: BusConfig, **more: Any) -> None:
        home = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, -0.5))
        home.things = dict(CHAIR)
        super().__init__(home, config, **more)
        self.filmed = self._labelled

    def _labelled(self, stream: str, payload: bytes) -> bytes:
        if stream == "camera_info":  # the first of an image
            seconds, ns = STAMP.unpack_from(payload, 4)
            names = tuple(self.home.things)
            seen = self.home.detect(names, list(self.home.shown.values())[-1])
            told = {
                "stamp_ns": seconds * 10**9 + ns,
                "boxes": seen.boxes_px.tolist(),
                "names": [names[label] for label in seen.labels],
                "scores": seen.scores.tolist(),
                "room": None,
            }
            self.session.put(LABELS, wire.encode_json(told))
        return payload
