"""The robot's side of the Zenoh bus: matched observations in, commands and state out, requests.

Zenoh's callbacks only put bytes into rings. One thread owns the Bus and calls `next` and
`request`; decoding happens there, for messages that are used and no others.
"""

import threading
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final, Self

from runtime.clock import Clock, Deadline
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.contact import Felt
from runtime.core.motion.safety import Halt, SafetyConfig
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Observation, Pose, Twist
from runtime.errors import SensorError
from runtime.log import say
from runtime.record import Record, unrecorded
from runtime.robot import wire
from runtime.robot.base import BaseCondition, DriveOrder, Sent
from runtime.robot.body_senses import BodySenses
from runtime.robot.dialects.choice import spoken
from runtime.robot.dialects.dialect import RosTopic
from runtime.robot.frame_names import FrameNames
from runtime.robot.handbrake import Handbrake, serve_handbrake
from runtime.robot.heard_topics import LABELS_TOPIC, TF_TOPICS, heard_topics
from runtime.robot.publications import Publications
from runtime.robot.reflex import Reflex, swept
from runtime.robot.requests import QUERIES, Request, Requests
from runtime.robot.ros_node import Publisher, RosNode, Sending
from runtime.robot.session import (
    LABELS,
    BusConfig,
    SensesConfig,
    TopicsConfig,
    open_session,
)
from runtime.robot.streams import SENSES, ConsumedFrame, SensorStreams, StreamHealth
from runtime.robot.transforms import FIXED, CameraConfig
from runtime.robot.vigilance import Vigilance

__all__ = ["Bus", "BusConfig", "Request", "StreamHealth", "TopicsConfig"]

SAFETY: Final = SafetyConfig()


class Bus:
    """See the module. In `lockstep` stamps are equal, nothing is lost and every message blocks.
    Without `odometry` that is not listened for: `file_odometry` brings it. `reflex`: the body that
    it keeps from touching anything; without one there is no reflex. One that does not `serve` only
    listens. `tap` is told of every message, by stream or sense, in the bus's threads. `node`: what
    the bus is to others, until it is closed."""

    def __init__(
        self,
        config: BusConfig,
        clock: Clock,
        lockstep: bool = False,
        camera: CameraConfig = FIXED,
        record: Record = unrecorded,
        odometry: bool = True,
        senses: SensesConfig = SENSES,
        safety: SafetyConfig = SAFETY,
        reflex: NavigateConfig | None = None,
        serves: bool = True,
        tap: Callable[[str, bytes], None] = lambda name, payload: None,
    ) -> None:
        self._config, self.distro, self._brake = config, config.distro, Handbrake()
        self._vigilance = None if lockstep else Vigilance(safety, packed=config.is_packed("depth"))
        self._record, self._tap = record, tap
        self._clock, self._lockstep = clock, lockstep
        self._changed = threading.Condition()
        self._requests = Requests(self._changed, config.key, self._answered, clock.now_s)
        around = config, clock, self._changed, lockstep, camera, record, senses
        self._streams = SensorStreams(*around, self._vigilance, odometry)
        self.on_urgent: Callable[[], None] = lambda: None  # called when motion must end at once
        self.on_feedback: Callable[[Mapping[str, Any]], None] = lambda told: None
        self._reflex = self._begun(reflex, camera, safety) if reflex is not None else None
        self._body = BodySenses(config.topics, senses, clock, record)
        self._delivered_ns = -1  # lockstep: the newest observation handed over
        self._delivered_s: float | None = None  # when the newest one handed over had arrived
        self._session: Any = open_session(config)
        self._declared: list[Any] = []
        self._strangers: set[str] = set()  # topics on which something of another type came
        self._frames = FrameNames()
        self.node = RosNode(self._session, spoken(config), self._strange)
        self._out = Publications(self.node, config, lockstep, record)
        self._listen(odometry, camera.mount == "tf" or bool(config.map_frame))
        for kind in QUERIES if serves else ():
            asked = config.key(f"rfnav/{kind}"), partial(self.file, kind)
            self._declared.append(self._session.declare_queryable(*asked))
        if serves and not lockstep:
            brake = self._session, self.node, config, self._brake, lambda: self.on_urgent()
            self._declared.extend(serve_handbrake(*brake))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- in ------------------------------------------------------------------------------------

    def next(self, timeout_s: float) -> Observation | None:
        """The next matched set; None when none came in time, or at once when a request waits.

        In lockstep, until the first frame, a SensorError is raised for what will not mend itself:
        a camera without intrinsics, or images of another size. Other bad messages are counted; in
        real time `doubt` says what is wrong with them where that goes on.
        """
        by = Deadline.after(timeout_s, self._clock)
        while True:
            with self._changed:
                match = self._streams.wait_for_match(by, self._requests.wait)
            if match is None:
                return None
            if self._lockstep and match.stamp_ns <= self._delivered_ns:
                self._out.answer_again(match.stamp_ns)
                continue
            observation = self._streams.observe(match)
            if observation is not None:
                self._delivered_ns = match.stamp_ns
                self._delivered_s = match.arrival_s
                now_s = self._clock.now_s()
                told = ConsumedFrame(match, observation, now_s, self._streams.altered)
                self._record("frame", told)
                return observation

    def request(self) -> Request | None:
        """The next request that waits, or None; see `Requests`."""
        self._streams.frames.update(self._clock.now_s())
        request = self._requests.take()
        if request is not None:
            told = {"kind": request.kind, "body": request.body, "now_s": self._clock.now_s()}
            self._record("request", told)
        return request

    def file(self, kind: str, query: Any) -> None:
        """Have a query wait to be answered, whatever way it came; any thread may bring it."""
        if kind == "cancel":
            self._brake.cancel(True)
            self.on_urgent()
        self._requests.file(kind, f"rfnav/{kind}", query)

    def file_odometry(self, pose: Pose, stamp_ns: int) -> None:
        """Odometry that came by another wire: in the map frame, stamped as the images are. Any
        thread may bring it."""
        self._streams.file("odom", wire.encode_odometry(pose, stamp_ns))

    def pose(self) -> tuple[wire.Stamped[Pose], float] | None:
        """The odometry that came last and when it arrived (monotonic s); None before the first.
        Any thread may ask."""
        return self._streams.newest_pose()

    def frame_arrival_s(self) -> float | None:
        """When the newest matched frame came, used or not; None before one; any thread may ask."""
        with self._changed:
            waiting_s = self._streams.waiting_arrival_s()
            return waiting_s if waiting_s is not None else self._delivered_s

    def delivered_s(self) -> float | None:
        """When the observation that `next` returned last had arrived."""
        return self._delivered_s

    def wait_request(self, timeout_s: float) -> None:
        """Return when a request waits, or after the timeout; frames are left alone."""
        by = Deadline.after(timeout_s, self._clock)
        with self._changed:
            while not self._requests.wait() and not by.passed():
                self._clock.wait(self._changed, by.at_s)

    def labels(self, stamp_ns: int, timeout_s: float) -> dict[str, Any] | None:
        """The message on `labels` of that stamp; None when it does not come in time."""
        found = self._streams.labels(stamp_ns, Deadline.after(timeout_s, self._clock))
        self._record("heard", {"name": "labels", "value": found})
        return found

    def flush(self) -> None:
        """Forget every sensor message that waits (a new goal in lockstep)."""
        with self._changed:
            self._streams.clear()
            self._delivered_ns = -1
            self._out.forget_answer()

    def felt(self) -> Felt:
        """What the robot's body feels; any thread may ask."""
        return self._body.felt()

    def cliffs_watched(self) -> bool:
        """Whether cliff sensors look ahead, and all that ever spoke do."""
        watched = self._body.felt().cliffs_watched
        if watched:
            self._record("heard", {"name": "cliffs_watched", "value": True})
        return watched

    def doubt(self, sent: Twist) -> Halt | None:
        """See `RobotSenses`; any thread may ask."""
        self._streams.drives(sent)
        if held := self._brake.halt():
            return held
        if self._vigilance is None:
            return None
        with self._changed:
            noticed = self._vigilance.doubt(self._clock.now_s(), sent) or self._streams.trouble()
        return noticed or (self._reflex.doubt() if self._reflex is not None else None)

    def caution(self, twist: Twist) -> Caution:
        """What the newest depth image leaves of a velocity; see `RobotSenses`."""
        if self._reflex is None:
            return FREE
        return self._reflex.caution(twist, self._streams.here())

    def unstamped(self) -> tuple[str, ...]:
        """Topics of which the stamps stand still."""
        with self._changed:
            return tuple(sorted(self._vigilance.unstamped)) if self._vigilance else ()

    def sweeps(self, config: NavigateConfig, camera: CameraConfig) -> None:
        """What drives from now on, and where its camera is: a goal may bring its own."""
        self._streams.mounts(camera)
        if self._reflex is not None:
            self._reflex.sweeps(swept(config), camera)

    def health(self) -> dict[str, StreamHealth]:
        """By topic: received, bad, the last error; of what is not needed, where it is there."""
        return self._streams.health() | self._body.health()

    # -- out -----------------------------------------------------------------------------------

    def publish_action(self, stamp_ns: int, action: Action, twist: Twist | None = None) -> None:
        """The answer to the observation of that stamp; with a velocity, it is what is driven until
        the next, unless the action is stop."""
        self._out.action(stamp_ns, action, twist)

    def drive(self, order: DriveOrder) -> Sent:
        """See `Base`: a velocity for a base that listens to `cmd_vel`."""
        if who := self._body.hand():
            return Sent(None, f"a hand has the sticks: {who}")
        if late := order.late(self._clock.now_s()):
            return Sent(None, late)
        self._out.twist(order.twist, order.stamp_ns, order.last)
        return Sent(order.twist)

    def condition(self) -> BaseCondition:
        """See `Base`."""
        return BaseCondition("", self._body.hand(), self._body.battery_percent())

    def charging(self) -> bool:
        """Whether the robot's battery charges; any thread may ask."""
        return self._body.charging()

    def publish_feedback(self, feedback: Mapping[str, object]) -> None:
        told = self._streams.frames.told(feedback, self._clock.now_s())
        self._out.report("feedback", told)
        self.on_feedback(told)

    def publish_state(self, state: Mapping[str, object]) -> None:
        self._out.report("state", self._streams.frames.told(state, self._clock.now_s()))

    def publish_decision(self, decision: Mapping[str, object]) -> None:
        self._out.report("decision", decision)

    def publisher(self, topic: RosTopic) -> Publisher:
        """One more topic, that others go before; undeclared with the bus."""
        return self.node.publisher(topic, Sending())

    def frame_of(self, stream: str, otherwise: str) -> str:
        """The frame that the newest message of "odom" or "color" names; any thread may ask."""
        return self._frames.of(stream, otherwise)

    def placed(self, pose: Pose, frame: str) -> Pose:
        """A pose in odometry's frame, also "", or on a localisation's map -> in odometry's.
        SensorError for another frame."""
        return self._streams.frames.taken(pose, frame, self._clock.now_s())

    def origin_xy(self) -> tuple[float, float]:
        """Where the map begins in odometry's frame, m; any thread may ask."""
        return self._streams.frames.origin_xy

    def close(self) -> None:
        """Undeclare everything, drop unanswered requests and close the session. Idempotent."""
        if self._reflex is not None:
            self._reflex.close()
        self._requests.close()
        self.node.close()
        declared, self._declared = self._declared, []
        for entity in declared:
            entity.undeclare()
        if not self._session.is_closed():
            self._session.close()

    # -- inside --------------------------------------------------------------------------------

    def _begun(self, config: NavigateConfig, camera: CameraConfig, safety: SafetyConfig) -> Reflex:
        seen = self._streams, self._changed, self._clock, swept(config), camera
        told = self._config.topics.depth, lambda: self.on_urgent(), safety.depth_stale_s
        reflex = Reflex(*seen, *told)
        reflex.start()
        return reflex

    def _listen(self, odometry: bool, transforms: bool) -> None:
        heard, streams = heard_topics(self._config), self._streams
        for stream in streams.topics:
            if stream != "odom" or odometry:
                self._hear(heard[stream], stream, self._filed(stream))
        for sense in self._body.topics:
            self._hear(heard[sense], sense, partial(self._body.file, sense))
        for topic in TF_TOPICS if transforms else TF_TOPICS[1:]:  # what never moves, always
            self._hear(topic, topic.name, _unnamed(partial(streams.file_transforms, topic.name)))
        self.node.subscribe(LABELS_TOPIC, _unnamed(partial(streams.file_labels, LABELS)))

    def _filed(self, stream: str) -> Callable[[str, bytes], None]:
        framed = stream in ("odom", "color")

        def receive(name: str, payload: bytes) -> None:
            if framed:
                self._frames.note(stream, payload)
            self._streams.file(stream, payload)

        return receive

    def _hear(self, topic: RosTopic, stream: str, file: Callable[[str, bytes], None]) -> None:
        def receive(name: str, payload: bytes) -> None:
            self._tap(stream, payload)
            file(name, payload)

        # Whatever comes there is of a hand, even where what it says cannot be read.
        name, hand = self._config.key(topic.name), stream == "teleop"
        self.node.subscribe(topic, receive, lambda: file(name, b"") if hand else None)

    def _strange(self, topic: str, error: SensorError) -> None:
        """A message of another type than is read there: told of once, for it goes on coming."""
        self._streams.count_bad(topic, error)
        if topic not in self._strangers:
            self._strangers.add(topic)
            say(str(error))

    def _answered(self, kind: str) -> None:
        if kind == "cancel":
            self._brake.cancel(False)


def _unnamed(file: Callable[[bytes], None]) -> Callable[[str, bytes], None]:
    """For who knows the topic's name already."""
    return lambda name, payload: file(payload)
