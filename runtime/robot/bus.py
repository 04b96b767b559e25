"""The robot's side of the Zenoh bus: matched observations in, commands and state out, requests.

Zenoh's callbacks only put bytes into rings. One thread owns the Bus and calls `next` and
`request`; decoding happens there, for messages that are used and no others.
"""

import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Self

import zenoh

from runtime.clock import Clock, Deadline
from runtime.core.types import Action, Intrinsics, Observation, Pose, Twist
from runtime.errors import BusError, SensorError
from runtime.journal import plain
from runtime.robot import wire
from runtime.robot.requests import Request
from runtime.robot.session import BusConfig, TopicsConfig, open_session
from runtime.robot.sync import Match, RawMessage, Rings, interpolate

__all__ = ["Bus", "BusConfig", "Request", "StreamHealth", "TopicsConfig"]

QUERIES: Final = ("goal", "cancel", "status")


@dataclass
class StreamHealth:
    """What came on one topic."""

    received: int = 0
    bad: int = 0
    last_error: str = ""
    arrival_s: float | None = None  # monotonic, of the newest


class Bus:
    """See the module. In `lockstep` stamps are equal, nothing is lost and every message blocks."""

    def __init__(self, config: BusConfig, clock: Clock, lockstep: bool = False) -> None:
        self._config = config
        self._clock = clock
        self._changed = threading.Condition()
        self._rings = Rings(
            int(config.pair_tolerance_s * 1e9), int(config.odometry_gap_s * 1e9), lockstep
        )
        self._requests: deque[tuple[str, str, Any]] = deque()
        self._camera_info: RawMessage | None = None  # newest, not decoded yet
        self._intrinsics: Intrinsics | None = None
        self._intrinsics_error: SensorError | None = None
        self._lockstep = lockstep
        self._seen_frame = False
        self._delivered_ns = -1  # lockstep: the newest observation handed over
        self._delivered_s: float | None = None  # when the newest one handed over had arrived
        self._answer: tuple[int, bytes] | None = None  # lockstep: the action that it got
        self._labels: dict[str, Any] = {}  # newest message on `detections`
        self._frame_without_info_s: float | None = None
        topics = config.topics
        self._odom_topic = topics.pose or topics.odom
        inputs = {
            "color": topics.color,
            "depth": topics.depth,
            "camera_info": topics.camera_info,
            "odom": self._odom_topic,
        }
        self._health = {topic: StreamHealth() for topic in inputs.values()}
        self._session: Any = open_session(config)
        self._declared: list[Any] = []
        self._publishers: dict[str, Any] = {}
        for name in ("action", "cmd_vel", "state", "decision", "feedback"):
            self._publishers[name] = self._publisher(name, getattr(topics, name), lockstep)
        for stream, topic in inputs.items():
            self._subscribe(stream, topic)
        self._subscribe_labels(topics.detections)
        for kind in QUERIES:
            self._serve(kind, getattr(topics, kind))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- in ------------------------------------------------------------------------------------

    def next(self, timeout_s: float) -> Observation | None:
        """The next matched set; None when none came in time, or at once when a request waits.

        Until the first frame a SensorError is raised for what will not mend itself: a camera
        without intrinsics, or images of another size. After it, bad messages are only counted.
        """
        by = Deadline.after(timeout_s, self._clock)
        while True:
            with self._changed:
                match = self._wait_for_match(by)
            if match is None:
                return None
            if self._lockstep and match.stamp_ns <= self._delivered_ns:
                self._repeat(match.stamp_ns)
                continue
            observation = self._observe(match)
            if observation is not None:
                self._seen_frame = True
                self._delivered_ns = match.stamp_ns
                self._delivered_s = match.arrival_s
                return observation

    def wait_first(self, timeout_s: float | None = None) -> Observation | None:
        """Like `next`, but SensorError names the streams that stay silent for `timeout_s`."""
        limit_s = self._config.sensor_timeout_s if timeout_s is None else timeout_s
        by = Deadline.after(limit_s, self._clock)
        observation = self.next(limit_s)
        if observation is None and by.passed():
            raise SensorError(self._silence(limit_s))
        return observation

    def request(self) -> Request | None:
        """The oldest request that waits, or None. Bodies that are not JSON are refused here."""
        while True:
            with self._changed:
                if not self._requests:
                    return None
                kind, topic, query = self._requests.popleft()
            payload = query.payload.to_bytes() if query.payload is not None else b"{}"
            try:
                body = wire.parse_json(payload, topic)
            except SensorError as error:
                Request(kind, {}, query, self._config.key(topic)).reply(
                    {"accepted": False, "error": str(error)}
                )
                continue
            return Request(kind, body, query, self._config.key(topic))

    def pose(self) -> tuple[wire.Stamped[Pose], float] | None:
        """The odometry that came last and when it arrived (monotonic s); None before the first.
        Any thread may ask."""
        while True:
            with self._changed:
                raw = self._rings.odom[-1] if self._rings.odom else None
            if raw is None:
                return None
            pose = self._pose(raw)
            if pose is not None:
                return pose, raw.arrival_s

    def frame_arrival_s(self) -> float | None:
        """When the newest matched frame arrived, handed over or not; None before the first. Any
        thread may ask."""
        with self._changed:
            match = self._rings.peek() if self._intrinsics is not None else None
            return match.arrival_s if match is not None else self._delivered_s

    def delivered_s(self) -> float | None:
        """When the observation that `next` returned last had arrived."""
        return self._delivered_s

    def wait_request(self, timeout_s: float) -> None:
        """Return when a request waits, or after the timeout; frames are left alone."""
        by = Deadline.after(timeout_s, self._clock)
        with self._changed:
            while not self._requests and not by.passed():
                self._clock.wait(self._changed, by.at_s)

    def labels(self, stamp_ns: int, timeout_s: float) -> dict[str, Any] | None:
        """The message on `detections` of that stamp; None when it does not come in time."""
        by = Deadline.after(timeout_s, self._clock)
        with self._changed:
            while self._labels.get("stamp_ns") != stamp_ns and not by.passed():
                self._clock.wait(self._changed, by.at_s)
            return self._labels if self._labels.get("stamp_ns") == stamp_ns else None

    def flush(self) -> None:
        """Forget every sensor message that waits (a new goal in lockstep)."""
        with self._changed:
            self._rings.clear()
            self._delivered_ns, self._answer = -1, None

    def health(self) -> dict[str, StreamHealth]:
        """By topic: received, bad and the last error."""
        with self._changed:
            return {topic: StreamHealth(**vars(h)) for topic, h in self._health.items()}

    # -- out -----------------------------------------------------------------------------------

    def publish_action(self, stamp_ns: int, action: Action, twist: Twist | None = None) -> None:
        """The answer to the observation of that stamp; with a velocity, it is what is driven until
        the next, unless the action is stop."""
        answer: dict[str, object] = {"stamp_ns": stamp_ns, "action": action.value}
        if twist is not None:
            answer |= {"v_mps": twist.v_mps, "w_radps": twist.w_radps}
        payload = wire.encode_json(answer)
        self._answer = (stamp_ns, payload)
        self._put("action", payload)

    def publish_twist(self, forward_mps: float, turn_radps: float, stamp_ns: int = 0) -> None:
        """A velocity for the base. The stamp, for a TwistStamped, is of the robot's own clock."""
        if self._config.cmd_vel_type == "Twist":
            payload = wire.encode_twist(forward_mps, turn_radps)
        else:
            frame = self._config.cmd_vel_frame
            payload = wire.encode_twist_stamped(forward_mps, turn_radps, stamp_ns, frame)
        self._put("cmd_vel", payload)

    def publish_feedback(self, feedback: Mapping[str, object]) -> None:
        self._put("feedback", wire.encode_json(plain(feedback)))

    def publish_state(self, state: Mapping[str, object]) -> None:
        self._put("state", wire.encode_json(plain(state)))

    def publish_decision(self, decision: Mapping[str, object]) -> None:
        self._put("decision", wire.encode_json(plain(decision)))

    def close(self) -> None:
        """Undeclare everything, drop unanswered requests and close the session. Idempotent."""
        with self._changed:
            requests, self._requests = list(self._requests), deque()
        for _, _, query in requests:
            query.drop()
        declared, self._declared = self._declared, []
        for entity in declared:
            entity.undeclare()
        if not self._session.is_closed():
            self._session.close()

    # -- inside --------------------------------------------------------------------------------

    def _publisher(self, name: str, topic: str, lockstep: bool) -> Any:
        command = name in ("action", "cmd_vel")
        # In lockstep one priority for all: what was published first arrives first.
        urgent = command and not lockstep
        publisher = self._session.declare_publisher(
            self._config.key(topic),
            congestion_control=zenoh.CongestionControl.BLOCK
            if command or lockstep
            else zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.INTERACTIVE_HIGH if urgent else zenoh.Priority.DATA,
            express=True,
        )
        self._declared.append(publisher)
        return publisher

    def _put(self, name: str, payload: bytes) -> None:
        try:
            self._publishers[name].put(payload)
        except zenoh.ZError as error:
            raise BusError(f"{name}: cannot be published: {error}") from error

    def _repeat(self, stamp_ns: int) -> None:
        """An observation came twice, for a harness sends again what it got no answer to: a step is
        never taken twice, but an answer that was lost is given again."""
        if self._answer is not None and self._answer[0] == stamp_ns:
            self._put("action", self._answer[1])

    def _subscribe(self, stream: str, topic: str) -> None:
        def receive(sample: zenoh.Sample) -> None:
            self._receive(stream, topic, sample.payload.to_bytes())

        self._declared.append(self._session.declare_subscriber(self._config.key(topic), receive))

    def _subscribe_labels(self, topic: str) -> None:
        def receive(sample: zenoh.Sample) -> None:
            with self._changed:
                self._health.setdefault(topic, StreamHealth())
            try:
                labels = wire.decode_json(sample.payload.to_bytes(), topic)
            except SensorError as error:
                self._count(topic, error)
                return
            with self._changed:
                self._health[topic].received += 1
                self._labels = labels
                self._changed.notify_all()

        self._declared.append(self._session.declare_subscriber(self._config.key(topic), receive))

    def _serve(self, kind: str, topic: str) -> None:
        def receive(query: zenoh.Query) -> None:
            with self._changed:
                self._requests.append((kind, topic, query))
                self._changed.notify_all()

        self._declared.append(self._session.declare_queryable(self._config.key(topic), receive))

    def _receive(self, stream: str, topic: str, payload: bytes) -> None:
        """In Zenoh's threads: file the bytes and return."""
        arrival_s = self._clock.now_s()
        with self._changed:
            health = self._health[topic]
            health.received += 1
            health.arrival_s = arrival_s
            try:
                raw = RawMessage(wire.peek_stamp(payload, topic), payload, arrival_s)
            except SensorError as error:
                health.bad += 1
                health.last_error = str(error)
                return
            if stream == "camera_info":
                self._camera_info = raw
            else:
                self._rings.file(stream, raw)
            self._changed.notify_all()

    def _wait_for_match(self, by: Deadline) -> Match | None:
        """Holding `_changed`."""
        while True:
            self._read_camera_info()
            until_s = by.at_s
            if self._intrinsics is not None:
                match = self._rings.take()
                if match is not None:
                    return match
            elif self._rings.peek() is not None:
                until_s = min(until_s, self._await_camera_info())
            if self._requests or by.passed():
                return None
            self._clock.wait(self._changed, until_s)

    def _read_camera_info(self) -> None:
        raw, self._camera_info = self._camera_info, None
        if raw is None:
            return
        topic = self._config.topics.camera_info
        try:
            self._intrinsics = wire.decode_camera_info(raw.payload, topic).value
        except SensorError as error:
            self._count(topic, error)
            self._intrinsics_error = error

    def _await_camera_info(self) -> float:
        """Images wait for their intrinsics: until when? SensorError when that is in vain."""
        if self._intrinsics_error is not None:
            raise self._intrinsics_error
        if self._frame_without_info_s is None:
            self._frame_without_info_s = self._clock.now_s()
        until_s = self._frame_without_info_s + self._config.sensor_timeout_s
        if self._clock.now_s() >= until_s:
            self._frame_without_info_s = None
            raise SensorError(
                f"{self._config.topics.camera_info}: no intrinsics received in "
                f"{self._config.sensor_timeout_s:g} s although images come: publish camera_info"
            )
        return until_s

    def _observe(self, match: Match) -> Observation | None:
        """Decode a match; None when one of its messages is bad (and counted)."""
        topics, intrinsics = self._config.topics, self._intrinsics
        assert intrinsics is not None  # _wait_for_match returns no match before
        before = self._pose(match.before)
        after = before if match.after is match.before else self._pose(match.after)
        if before is None or after is None:
            return None
        compressed = topics.color.endswith("/compressed")
        decode_color = wire.decode_compressed_color if compressed else wire.decode_color
        topic = topics.color
        try:
            rgb = decode_color(match.color.payload, topic).value
            topic = topics.depth
            depth = wire.decode_depth(match.depth.payload, topic).value
        except SensorError as error:
            self._count(topic, error)
            return None
        for topic, image in ((topics.depth, depth), (topics.color, rgb)):
            try:
                wire.check_size(image.shape, topic, intrinsics, topics.camera_info)
            except SensorError as error:
                self._count(topic, error)
                if not self._seen_frame:
                    raise
                return None
        pose = interpolate(before, after, match.stamp_ns)
        return Observation(match.stamp_ns, rgb, depth, pose, intrinsics)

    def _pose(self, raw: RawMessage) -> wire.Stamped[Pose] | None:
        decode = wire.decode_pose if self._config.topics.pose else wire.decode_odometry
        try:
            return decode(raw.payload, self._odom_topic)
        except SensorError as error:
            self._count(self._odom_topic, error)
            with self._changed:
                self._rings.drop_odometry(raw)
            return None

    def _count(self, topic: str, error: SensorError) -> None:
        with self._changed:
            self._health[topic].bad += 1
            self._health[topic].last_error = str(error)

    def _silence(self, limit_s: float) -> str:
        health = self.health()
        errors = [h.last_error for h in health.values() if h.last_error]
        silent = [topic for topic, h in health.items() if not h.received]
        if silent:
            return (
                f"{', '.join(silent)}: nothing received in {limit_s:g} s: check the robot's topics"
            )
        if errors:
            return errors[0]
        topics = self._config.topics
        return (
            f"{topics.color}, {topics.depth}, {self._odom_topic}: no set with stamps within "
            f"{self._config.pair_tolerance_s:g} s in {limit_s:g} s: synchronise the clocks"
        )
