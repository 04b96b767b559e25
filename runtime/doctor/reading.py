"""What is kept of a robot's messages, beside what the runtime makes of them: when each came, and
how it describes itself. Bytes are read by the runtime's own decoders."""

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from runtime.config import Config
from runtime.core.geometry import wrap_angle
from runtime.core.types import Intrinsics, Observation
from runtime.doctor.hearing import (
    Arrival,
    HeardInfo,
    HeardPose,
    HeardTopic,
    Hearing,
    glimpse,
)
from runtime.errors import SensorError
from runtime.robot import wire, wire_senses
from runtime.robot.bounds import check_bytes
from runtime.robot.heard_topics import TF_TOPICS, heard_topics
from runtime.robot.images.camera_images import CameraImages
from runtime.robot.odometry import BaseOdometry
from runtime.robot.streams import IMAGES
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import TF, TF_STATIC

WAITING: Final = 4_000  # messages that are not read yet, of which the oldest are dropped
IMAGE_S: Final = 0.4  # between two images of a stream that are read here
GLIMPSE_S: Final = 0.1  # between two frames that are compared with each other
GLIMPSES: Final = 200  # that are kept
DEPTHS: Final = 8  # that are kept whole
SAME_RAD: Final = 1e-3
POSES: Final = 20_000
UNSTAMPED: Final = frozenset({"bumper", "stop", "teleop", TF, TF_STATIC})
SENSES: Final[Mapping[str, Callable[[bytes, str], object]]] = {
    "scan": wire_senses.decode_scan,
    "battery": wire_senses.decode_battery,
    "bumper": wire_senses.decode_flag,
    "cliff": wire_senses.decode_range,
    "hazards": wire_senses.decode_hazards,
    "teleop": wire_senses.check_sticks,
    TF: wire.decode_transforms,
    TF_STATIC: wire.decode_transforms,
}
"""What a robot may have, by the names of [bus.topics]."""


@dataclass(frozen=True)
class HeardMessage:
    """As it came; `stream`: by the names of [bus.topics]."""

    stream: str
    payload: bytes
    arrival: Arrival


def topics_heard(config: Config) -> dict[str, HeardTopic]:
    """By the names of [bus.topics], what is listened to: what a search needs first, then what a
    robot may have."""
    heard = heard_topics(config.bus)
    wanted = ["color", "depth", "camera_info", *SENSES]
    if not config.base.odometry:
        wanted.insert(3, "odom")
    found = {name: heard[name] for name in wanted if name in heard}
    if config.camera.mount == "tf":
        found |= {topic.name: topic for topic in TF_TOPICS}
    return {name: HeardTopic(topic.name, topic.kind) for name, topic in found.items()}


class Reading:
    """`file` is called in the bus's threads, `seen` and `hearing` by whoever owns the bus; `run`
    reads what was filed, in a thread of its own, until `close`."""

    def __init__(self, config: Config) -> None:
        self._streams = topics_heard(config)
        self._hearing = Hearing(0.0, self._streams)
        self._images, self._poses = CameraImages(config.bus, config.camera), PoseReader(config)
        self._changed = threading.Condition()
        self._waiting: deque[HeardMessage] = deque(maxlen=WAITING)
        self._refused: list[tuple[str, SensorError]] = []  # not even stamped, or too large
        self._image_s = dict.fromkeys(IMAGES, -math.inf)  # when the last that is read had come
        self._glimpse_s = -math.inf
        self._closed = False

    # -- in the bus's threads --------------------------------------------------------------------

    def file(self, name: str, payload: bytes) -> None:
        """Note a message; one that is to be read waits for that."""
        if (heard := self._streams.get(name)) is None:
            return
        arrival_s, wall_s = time.monotonic(), time.time()
        with self._changed:
            try:
                check_bytes(payload, heard.topic, name in IMAGES)
                stamped = name not in UNSTAMPED
                stamp_ns = wire.peek_stamp(payload, heard.topic) if stamped else None
            except SensorError as error:
                heard.received += 1
                self._refused.append((name, error))
                self._changed.notify_all()
                return
            arrival = Arrival(stamp_ns, arrival_s, wall_s, len(payload))
            heard.came(arrival)
            if name in IMAGES:
                if arrival_s - self._image_s[name] < IMAGE_S:
                    return
                self._image_s[name] = arrival_s
            self._waiting.append(HeardMessage(name, payload, arrival))
            self._changed.notify_all()

    # -- in the thread that reads ----------------------------------------------------------------

    def run(self) -> None:
        """Until it is closed and all is read."""
        while True:
            with self._changed:
                while not (self._closed or self._waiting or self._refused):
                    self._changed.wait(1.0)
                if self._closed and not (self._waiting or self._refused):
                    return
            self.read()

    def read(self) -> None:
        """All that waits."""
        with self._changed:
            waiting, refused = list(self._waiting), list(self._refused)
            self._waiting.clear()
            self._refused.clear()
        for name, error in refused:
            self._streams[name].failed(error)
        for message in waiting:
            heard = self._streams[message.stream]
            try:
                self._take(message, heard)
            except SensorError as error:
                heard.failed(error)
            else:
                heard.read += 1

    # -- for who owns the bus --------------------------------------------------------------------

    def seen(self, obs: Observation, now_s: float) -> None:
        """A frame that the runtime has made."""
        hearing = self._hearing
        hearing.frames += 1
        hearing.intrinsics, hearing.mount = obs.intrinsics, obs.mount
        if now_s - self._glimpse_s < GLIMPSE_S:
            return
        self._glimpse_s = now_s
        hearing.rgb = obs.rgb
        hearing.depths = [*hearing.depths, obs.depth_m][-DEPTHS:]
        glimpses = [*hearing.glimpses, glimpse(obs.stamp_ns, obs.rgb, obs.depth_m)]
        hearing.glimpses = glimpses[-GLIMPSES:]

    def close(self) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def hearing(self) -> Hearing:
        """After `run` has returned."""
        return self._hearing

    # -- inside ----------------------------------------------------------------------------------

    def _take(self, message: HeardMessage, heard: HeardTopic) -> None:
        name, payload, hearing = message.stream, message.payload, self._hearing
        if name in IMAGES:
            self._image(message, heard)
        elif name == "odom":
            told = self._poses.read(payload)
            heard.frame = shown(f"{told.frame} -> {told.child}" if told.child else told.frame)
            if len(hearing.odometry) < POSES:
                hearing.odometry.append(told)
        elif name == "camera_info":
            hearing.info = _info(payload, heard)
        else:
            SENSES[name](payload, heard.topic)

    def _image(self, message: HeardMessage, heard: HeardTopic) -> None:
        raw = RawMessage(message.arrival.stamp_ns or 0, message.payload, message.arrival.arrival_s)
        if message.stream == "color":
            height, width = self._images.color(raw).shape[:2]
        else:
            height, width = self._images.depth(raw).depth_m.shape
        told = wire.decode(message.payload, heard.kind, heard.topic)
        heard.frame = shown(str(told.header.frame_id).lstrip("/"))
        how = told.format if heard.kind == wire.COMPRESSED_IMAGE else told.encoding
        heard.what = f"{shown(str(how))} {width}x{height}"


class PoseReader:
    """Odometry, or the poses of a SLAM, as the runtime reads them, with the whole rotation that was
    told. Not for several threads."""

    def __init__(self, config: Config) -> None:
        topics = config.bus.topics
        self._topic, self._slam = topics.pose or topics.odom, bool(topics.pose)
        known = self._topic, self._slam, config.camera
        self._base = BaseOdometry(*known, tell=lambda line: None)

    def read(self, payload: bytes) -> HeardPose:
        """SensorError for what the runtime could not use."""
        stamp_ns = wire.peek_stamp(payload, self._topic)
        told = self._base.read(RawMessage(stamp_ns, payload, 0.0))[0].value
        kind = wire.POSE_STAMPED if self._slam else wire.ODOMETRY
        message = wire.decode(payload, kind, self._topic)
        q = (message.pose if self._slam else message.pose.pose).orientation
        norm = math.hypot(q.x, q.y, q.z, q.w)  # it was found to be about 1
        child = "" if self._slam else shown(str(message.child_frame_id).lstrip("/"))
        frame = shown(str(message.header.frame_id).lstrip("/"))
        xy = told.x_m, told.y_m
        heard = HeardPose(
            stamp_ns, frame, child, xy, (q.x / norm, q.y / norm, q.z / norm, q.w / norm)
        )
        if abs(wrap_angle(heard.yaw_rad - told.yaw_rad)) < SAME_RAD:
            return heard
        half = told.yaw_rad / 2  # it is another frame's, and was taken to the base
        return HeardPose(stamp_ns, frame, child, xy, (0.0, 0.0, math.sin(half), math.cos(half)))


def shown(text: str) -> str:
    """What others say, for a terminal."""
    return "".join(c for c in text if c.isprintable())[:60]


def _info(payload: bytes, heard: HeardTopic) -> HeardInfo:
    message: Any = wire.decode(payload, wire.CAMERA_INFO, heard.topic)
    heard.frame = shown(str(message.header.frame_id).lstrip("/"))
    intrinsics: Intrinsics = wire.decode_camera_info(payload, heard.topic).value
    heard.what = f"{intrinsics.width}x{intrinsics.height}"
    bent = tuple(float(value) for value in message.d)
    return HeardInfo(intrinsics, heard.frame, shown(str(message.distortion_model)), bent)
