"""What the loop tells a recorder, as messages of a recording. All of it is done in the recorder's
thread, on values that nobody changes any more.

Kinds without a special form are JSON on `/loop/KIND`; see `schemas` for what is on each topic.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from runtime.core.mapping.keyframes import NO_PARTS
from runtime.core.mapping.sights import halved
from runtime.core.optics.upright import upright_mount
from runtime.core.types import F32, Ballot, Decision, Detections
from runtime.core.voting.explain import in_words
from runtime.errors import SensorError
from runtime.recording.exact import as_json, exact
from runtime.recording.pictures import Picture, compressed, drawn, transforms
from runtime.robot import wire, wire_senses
from runtime.robot.session import PACKED, BusConfig, TopicsConfig
from runtime.robot.streams import ConsumedFrame, WireMessage
from runtime.robot.transforms import CameraConfig, peek_frame

LOOP: Final = "/loop/"  # before the topics that are ours
WITHOUT_STAMP: Final = (wire.TWIST, wire.STRING, wire.TF_MESSAGE, wire_senses.BOOL)


class Draft(NamedTuple):
    """A message that is to be written."""

    topic: str
    schema: str
    stamp_ns: int | None  # of its header
    payload: bytes


@dataclass
class Encoder:
    """Values by kind -> messages. `colour`: whether images are written at all, or what a detector
    saw of their parts, which is as telling."""

    bus: BusConfig
    camera: CameraConfig
    colour: bool
    map_frame: str = "odom"  # as odometry calls it

    @property
    def topics(self) -> TopicsConfig:
        return self.bus.topics

    def drafts(self, kind: str, value: Any) -> Iterator[Draft]:
        """The messages of one value, in the order in which they are to be written."""
        special: dict[str, Callable[[Any], Iterator[Draft]]] = {
            "wire": self._wire,
            "frame": self._frame,
            "detections": self._detections,
            "ballot": _ballot,
            "decision": _decision,
            "picture": self._picture,
        }
        if kind in special:
            yield from special[kind](value)
        else:
            yield _ours(kind, value)

    def _wire(self, message: WireMessage) -> Iterator[Draft]:
        stamped = message.kind not in WITHOUT_STAMP
        stamp_ns = wire.peek_stamp(message.payload, message.topic) if stamped else None
        if message.kind in (wire.ODOMETRY, wire.POSE_STAMPED):
            with suppress(SensorError):  # a damaged one is recorded as it came, too
                self.map_frame = peek_frame(message.payload, message.topic)
        yield Draft(slashed(message.topic), message.kind, stamp_ns, message.payload)

    def _frame(self, frame: ConsumedFrame) -> Iterator[Draft]:
        match, obs = frame.match, frame.observation
        camera = peek_frame(match.depth.payload, self.topics.depth)
        if self.camera.by_tf is None:
            frames = self.map_frame, self.camera.base_frame, camera
            mount = obs.mount or upright_mount(self.camera)
            placed = transforms(obs.pose, mount, match.stamp_ns, frames)
            yield Draft(f"{LOOP}tf", wire.TF_MESSAGE, match.stamp_ns, placed)
        if self.colour:
            topic, payload = color_topic(self.topics), self._color(frame, camera)
            yield Draft(topic, wire.COMPRESSED_IMAGE, match.color.stamp_ns, payload)
        depth = _compact(obs.depth_m, match.stamp_ns, camera)
        yield Draft(depth_topic(self.topics), wire.IMAGE, match.stamp_ns, depth)
        told = {
            "stamp_ns": obs.stamp_ns,
            "color_stamp_ns": match.color.stamp_ns,
            "arrival_s": match.arrival_s,
            "now_s": frame.now_s,
            "pose": obs.pose,
            "intrinsics": obs.intrinsics,
            "mount": obs.mount,
            "scan": obs.scan,
            "altered": frame.altered,
        }
        yield _ours("frame", told, obs.stamp_ns)

    def _detections(self, seen: Detections) -> Iterator[Draft]:
        """Parts of the image in half precision, as keyframes have them."""
        parts = halved(seen.features) if self.colour else NO_PARTS
        yield _ours("detections", {**vars(seen), "features": parts})

    def _color(self, frame: ConsumedFrame, camera: str) -> bytes:
        """A colour image as it came where that was compressed, else as a JPEG. `camera`: where its
        own frame has no name that is one."""
        color = frame.match.color
        if self.bus.is_packed("color") and not frame.altered:
            return color.payload
        with suppress(SensorError):
            camera = peek_frame(color.payload, self.topics.color)
        return compressed(frame.observation.rgb, color.stamp_ns, camera)

    def _picture(self, picture: Picture) -> Iterator[Draft]:
        for topic, schema, payload in drawn(picture, self.map_frame):
            yield Draft(f"{LOOP}{topic}", schema, picture.stamp_ns, payload)


def slashed(topic: str) -> str:
    """A topic's name in a recording, as ROS has it."""
    return f"/{topic.strip('/')}"


def color_topic(topics: TopicsConfig) -> str:
    """Where a recording has colour images, which are always compressed."""
    topic = slashed(topics.color)
    return topic if topic.endswith("/compressed") else f"{topic}/compressed"


def depth_topic(topics: TopicsConfig) -> str:
    """Where a recording has depth images, which are always raw."""
    topic = slashed(topics.depth)
    end = next((end for end in PACKED["depth"] if topic.endswith(end)), "")
    return topic.removesuffix(end)


def _compact(depth_m: F32, stamp_ns: int, frame: str) -> bytes:
    """A depth image as it was used, whatever it came as, without loss: metres that are whole
    millimetres take half the room as such."""
    mm = np.rint(depth_m * np.float32(1000))
    whole = mm.max(initial=0) < 65535 and np.array_equal(mm / np.float32(1000), depth_m)
    return wire.encode_depth(depth_m, stamp_ns, frame, "16UC1" if whole else "32FC1")


def _ours(kind: str, value: object, stamp_ns: int | None = None) -> Draft:
    return Draft(f"{LOOP}{kind}", f"rfnav.{kind.capitalize()}", stamp_ns, as_json(value))


def _ballot(told: tuple[Ballot, str]) -> Iterator[Draft]:
    ballot, rehearsal = told
    yield _ours("ballot", {**exact(ballot), "rehearsal": rehearsal})


def _decision(decision: Decision) -> Iterator[Draft]:
    yield _ours("decision", told_decision(decision), decision.stamp_ns)


def told_decision(decision: Decision) -> dict[str, Any]:
    """A decision without its ballot, which has a topic of its own."""
    told: dict[str, Any] = exact(decision)
    del told["ballot"]
    return told | {"in_words": exact(in_words(decision))}
