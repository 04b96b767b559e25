"""The robot's sensor streams: filed as they come, decoded where they are used and nowhere else."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from runtime.clock import Clock, Deadline
from runtime.core.motion.safety import Halt
from runtime.core.types import F32, U8, Observation, Pose, Scan, Twist
from runtime.errors import SensorError
from runtime.record import Record, unrecorded
from runtime.robot import wire, wire_senses
from runtime.robot.bounds import check_bytes
from runtime.robot.camera_info import SENSOR_TIMEOUT_S
from runtime.robot.images.camera_images import CameraImages, DepthImage
from runtime.robot.labels import read_labels
from runtime.robot.laser import ScanStream
from runtime.robot.messages import ConsumedFrame, StreamHealth, WireMessage
from runtime.robot.odometry import BaseOdometry
from runtime.robot.odometry_stream import GAP_S, OdometryStream
from runtime.robot.optics import DepthSight, Optics, Pair
from runtime.robot.pairing import Pairing
from runtime.robot.session import BusConfig, SensesConfig
from runtime.robot.stamps import STREAMS, StreamClocks
from runtime.robot.sync import Match, RawMessage, Rings, interpolate
from runtime.robot.told_frames import ToldFrames
from runtime.robot.transforms import TF, CameraConfig, Transforms, UnplacedError, peek_frame
from runtime.robot.troubles import Troubles
from runtime.robot.vigilance import Vigilance

__all__ = ["ConsumedFrame", "SensorStreams", "StreamHealth", "WireMessage"]

PAIR_TOLERANCE_S = 0.02  # between a colour image and its depth image
UNSTAMPED_S = 0.06  # the same by arrival
SENSES = SensesConfig()
IMAGES = frozenset({"color", "depth"})


class SensorStreams:
    """Colour, depth, intrinsics, odometry and what a detector elsewhere says, of one robot.

    `file` and `file_labels` are called in the threads of the bus, the rest by whoever reads.
    Whatever comes is told to those who wait on `changed`. `vigilance`: in real time, who looks at
    every message; asked holding `changed`. `odometry`: whether it comes over the bus.
    """

    def __init__(
        self,
        config: BusConfig,
        clock: Clock,
        changed: threading.Condition,
        lockstep: bool,
        camera: CameraConfig,
        record: Record = unrecorded,
        senses: SensesConfig = SENSES,
        vigilance: Vigilance | None = None,
        odometry: bool = True,
    ) -> None:
        self._config, self._vigilance = config, vigilance
        self._record, self._clock, self._changed = record, clock, changed
        self._transforms = Transforms(lambda error: self.count_bad(TF, error))
        self._depth: RawMessage | None = None  # newest, whether or not colour has come
        self._rings = Rings(int(PAIR_TOLERANCE_S * 1e9), int(GAP_S * 1e9), lockstep)
        self._images = CameraImages(config, camera)
        self._optics = Optics(camera, config.topics, self._transforms, self.count_bad)
        self._info, self._depth_info = self._optics.color, self._optics.depth
        self._lockstep, self._clocks = lockstep, StreamClocks()
        self._pairing = Pairing(self._optics, camera, config.topics, lockstep)
        self._unplaced_since_s: float | None = None
        self._seen_frame = self.altered = False  # altered: its images are not as they came
        self._labels: dict[str, Any] = {}  # newest message on `labels`
        topics, odom = config.topics, config.topics.pose or config.topics.odom
        told = BaseOdometry(odom, bool(topics.pose), camera, self._optics.known)
        self._odometry = OdometryStream(told, self._rings, lockstep)
        if vigilance is not None:
            vigilance.read = told.read
        self.frames = ToldFrames(config.map_frame, self._transforms, told)
        placed = partial(self._transforms.placed, camera.base_frame)
        self._laser = ScanStream(senses, topics.scan, placed if camera.mount == "tf" else None)
        self.topics = {
            "color": topics.color,
            "depth": topics.depth,
            "camera_info": topics.camera_info,
            "odom": odom,
        }
        if self._depth_info.topic != topics.camera_info:
            self.topics["depth_info"] = self._depth_info.topic
        if topics.scan:
            self.topics["scan"] = topics.scan
        self._health = {topic: StreamHealth() for topic in self.topics.values()}
        self._troubles = Troubles(self.topics, clock.now_s(), odometry)

    # -- in the bus's threads ------------------------------------------------------------------

    def file(self, stream: str, payload: bytes) -> None:
        """File a message of one of `topics` and return."""
        topic = self.topics[stream]
        arrival_s = self._clock.now_s()
        with self._changed:
            health = self._health[topic]
            health.received += 1
            health.arrival_s = arrival_s
            try:
                check_bytes(payload, topic, stream in IMAGES)
                raw = RawMessage(wire.peek_stamp(payload, topic), payload, arrival_s)
                if stream in STREAMS and not self._lockstep:
                    raw = self._clocks.restamped(stream, raw, topic)
                    apart_s = UNSTAMPED_S if self._clocks.unstamped & IMAGES else PAIR_TOLERANCE_S
                    self._rings.tolerance_ns = int(apart_s * 1e9)
                if self._vigilance is not None:
                    raw = self._vigilance.take(stream, raw, topic)
            except SensorError as error:
                self.count_bad(topic, error)
                return
            if stream == "depth":
                self._depth = raw
            kind = _recorded_as(stream, self._config)
            if kind:
                self._record("wire", WireMessage(topic, kind, payload))
            if stream == "odom" and not self._takes(raw, arrival_s, health):
                self._changed.notify_all()
                return
            if stream == "scan":
                self._laser.file(raw)
                return
            if stream == "camera_info":
                self._info.file(raw)
            elif stream == "depth_info":
                self._depth_info.file(raw)
            elif self._rings.file(stream, raw):
                health.set_back += 1
            self._changed.notify_all()

    def file_transforms(self, topic: str, payload: bytes) -> None:
        """File a message of `tf` or `tf_static`."""
        arrival_s = self._clock.now_s()
        with self._changed:
            health = self._health.setdefault(topic, StreamHealth())
            health.received += 1
            health.arrival_s = arrival_s
            try:
                check_bytes(payload, topic)
            except SensorError as error:
                self.count_bad(topic, error)
                return
            self._record("wire", WireMessage(topic, wire.TF_MESSAGE, payload))
        self._transforms.file(topic, payload)

    def file_labels(self, topic: str, payload: bytes) -> None:
        """What a detector elsewhere has seen: the newest is kept, of those that can be read."""
        with self._changed:
            self._health.setdefault(topic, StreamHealth())
        try:
            labels = wire.decode_json(payload, topic)
            read_labels(labels, (), ())
        except SensorError as error:
            self.count_bad(topic, error)
            return
        with self._changed:
            self._health[topic].received += 1
            self._labels = labels
            self._changed.notify_all()

    def count_bad(self, topic: str, error: SensorError) -> None:
        """A message that is none; any thread may say so."""
        with self._changed:
            self._health.setdefault(topic, StreamHealth()).bad += 1
            self._health[topic].last_error = str(error)
            self._troubles.note(topic, error, self._clock.now_s())

    # -- what is asked -------------------------------------------------------------------------

    def wait_for_match(self, by: Deadline, interrupted: Callable[[], bool]) -> Match | None:
        """The next match, not decoded; None after `by` or when `interrupted` holds. Holding
        `changed`. In lockstep SensorError for a camera that sends images without intrinsics."""
        while True:
            until_s = by.at_s
            if self._info.read() is not None:
                match = self._rings.take()
                if match is not None:
                    self._troubles.matched()
                    return match
            elif self._lockstep and self._rings.peek() is not None:
                until_s = min(until_s, self._info.awaited_until_s(self._clock.now_s()))
            if interrupted() or by.passed():
                return None
            self._clock.wait(self._changed, until_s)

    def observe(self, match: Match) -> Observation | None:
        """Decode a match; None when one of its messages is bad (and counted). In lockstep, before
        the first frame, SensorError for images that cannot be put together."""
        topics = self._config.topics
        self._depth_info.read()
        before = self._odometry.pose(match.before)
        after = before if match.after is match.before else self._odometry.pose(match.after)
        topic = topics.color
        try:
            rgb = self._images.color(match.color)
            topic = topics.depth
            depth = self._images.depth(match.depth)
            if not depth.depth_m.any():
                with self._changed:
                    self._health[topic].blank += 1
            frame = peek_frame(match.depth.payload, topic)
        except SensorError as error:
            self.count_bad(topic, error)
            return None
        pose = interpolate(before, after, match.stamp_ns)
        pair = self._paired(rgb, depth, frame, match.stamp_ns, pose)
        if pair is None:
            return None
        self._seen_frame, self.altered = True, pair.altered
        with self._changed:
            self._troubles.seen()
        seen = pair.rgb, pair.depth_m, pose, pair.intrinsics, pair.mount
        scan, solid_m = self._scan("map", match.stamp_ns), depth.solid_m
        return Observation(match.stamp_ns, *seen, scan, None if pair.altered else solid_m)

    def _paired(
        self, rgb: U8, depth: DepthImage, frame: str, stamp_ns: int, pose: Pose
    ) -> Pair | None:
        """None for images that are not to be mapped (and are counted). In lockstep, before the
        first frame, SensorError: where tf does not say, after a while."""
        try:
            return self._pairing.pair(rgb, depth, frame, stamp_ns, pose)
        except SensorError as error:
            name, now_s, patient = str(error).partition(":")[0], self._clock.now_s(), False
            known = name in self._health or name == TF
            self.count_bad(name if known else self._config.topics.depth, error)
            if isinstance(error, UnplacedError):
                since_s = self._unplaced_since_s = self._unplaced_since_s or now_s
                patient = now_s < since_s + SENSOR_TIMEOUT_S
            if self._lockstep and not self._seen_frame and not patient:
                raise
            return None

    def mounts(self, camera: CameraConfig) -> None:
        """From the next image on the camera is there."""
        self._pairing.mounts(camera)

    def newest_pose(self) -> tuple[wire.Stamped[Pose], float] | None:
        """The odometry that came last and when it arrived (monotonic s); None before the first."""
        with self._changed:
            return self._odometry.newest

    def drives(self, sent: Twist) -> None:
        """What the base was sent last. Any thread may say so."""
        with self._changed:
            self._odometry.sent = sent

    def here(self) -> Pose | None:
        """Where the base is by now; None before the first odometry. Any thread may ask."""
        with self._changed:
            return self._odometry.here(self._clock.now_s())

    def newest_depth(self) -> RawMessage | None:
        """The depth image that came last; None before the first. Holding `changed`."""
        return self._depth

    def depth(self, raw: RawMessage) -> DepthImage:
        """A depth image, decoded; SensorError for one that cannot be."""
        image = self._images.depth(raw)
        if self._vigilance is not None:
            with self._changed:
                self._vigilance.looked(image.depth_m, raw.arrival_s)
        return image

    def pose_at(self, stamp_ns: int, alone: bool = False) -> Pose | None:
        """See `OdometryStream.at`. Holding `changed`."""
        return self._odometry.at(stamp_ns, alone)

    def sight(self, depth: RawMessage, depth_m: F32) -> DepthSight | None:
        """A depth image as it was published, decoded -> upright and straight, as its own camera saw
        it; None before the intrinsics are known. SensorError where tf does not say where that is,
        or nothing how it lies to colour's."""
        frame = peek_frame(depth.payload, self._config.topics.depth)
        return self._optics.sight(depth_m, frame, depth.stamp_ns)

    def look(self, depth: RawMessage) -> DepthSight | None:
        """The same, without flying pixels, of an image that nobody drives by."""
        with self._changed:
            self._info.read()
            self._depth_info.read()
        return self.sight(depth, self.depth(depth).solid())

    def near_scan(self, stamp_ns: int) -> Scan | None:
        """What a laser met about the time of a depth image that nobody has matched; None where
        there is nothing new."""
        return self._scan("reflex", stamp_ns)

    def waiting_arrival_s(self) -> float | None:
        """When the matched frame that waits had arrived; None when none does. Holding `changed`."""
        match = self._rings.peek() if self._info.intrinsics is not None else None
        return match.arrival_s if match is not None else None

    def trouble(self) -> Halt | None:
        """What is wrong with what comes, as a reason to stand. Holding `changed`."""
        seeing = self._info.intrinsics is not None
        return self._troubles.halt(self._clock.now_s(), self._health, self._rings, seeing)

    def labels(self, stamp_ns: int, by: Deadline) -> dict[str, Any] | None:
        """The message on `labels` of that stamp; None when it does not come in time."""
        with self._changed:
            while self._labels.get("stamp_ns") != stamp_ns and not by.passed():
                self._clock.wait(self._changed, by.at_s)
            return self._labels if self._labels.get("stamp_ns") == stamp_ns else None

    def clear(self) -> None:
        """Forget every message that waits. Holding `changed`."""
        self._rings.clear()

    def health(self) -> dict[str, StreamHealth]:
        """By topic: received, bad and the last error."""
        with self._changed:
            return {topic: StreamHealth(**vars(h)) for topic, h in self._health.items()}

    # -- inside --------------------------------------------------------------------------------

    def _scan(self, by: str, stamp_ns: int) -> Scan | None:
        """What a laser met about the time of an image; None where there is none, or none that can
        be read and placed."""
        try:
            with self._changed:
                found = self._laser.take(by, stamp_ns, self._rings)
            return self._laser.read(found, self._odometry.pose) if found is not None else None
        except SensorError as error:
            self.count_bad(self._config.topics.scan, error)
            return None

    def _takes(self, raw: RawMessage, arrival_s: float, health: StreamHealth) -> bool:
        """Holding `changed`: whether odometry is used for images."""
        try:
            takes = self._odometry.takes(raw, arrival_s)
        except SensorError as error:
            self.count_bad(self.topics["odom"], error)
            return False
        self._troubles.over(self.topics["odom"])
        if not takes:
            health.jumped += 1
        return takes


def _recorded_as(stream: str, config: BusConfig) -> str:
    """The type of a stream that is recorded as it comes; "" for images: of those only what is
    consumed is."""
    if stream == "odom":
        return wire.POSE_STAMPED if config.topics.pose else wire.ODOMETRY
    told = {"camera_info": wire.CAMERA_INFO, "depth_info": wire.CAMERA_INFO}
    return (told | {"scan": wire_senses.LASER_SCAN}).get(stream, "")
