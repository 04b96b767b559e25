"""The bus over real Zenoh on loopback: bytes really move between two sessions."""

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import zenoh
from other_half import compressed_color, flag, slam_pose, tf
from zenoh.ext import CacheConfig, declare_advanced_publisher

from runtime.clock import SystemClock
from runtime.core.types import (
    Absence,
    Action,
    Intrinsics,
    Missing,
    Mount,
    Observation,
    Pose,
    Twist,
)
from runtime.errors import BusError, SensorError
from runtime.robot import wire, wire_senses
from runtime.robot.base import DriveOrder, Sent
from runtime.robot.bus import Bus, BusConfig, TopicsConfig
from runtime.robot.session import open_session
from runtime.robot.transforms import CameraConfig

PATIENCE_S = 10.0
K = Intrinsics(38.8, 38.8, 8.0, 6.0, 16, 12)
RGB = np.arange(12 * 16 * 3, dtype=np.uint8).reshape(12, 16, 3)
DEPTH = np.full((12, 16), 2.0, np.float32)
ALL = ("camera_info", "odom", "depth", "color")


class Robot:
    """The other side: publishes sensors, asks, and collects what the runtime says."""

    def __init__(self, config: BusConfig) -> None:
        self.config = config
        self.session: Any = open_session(config)
        self.publishers: dict[str, Any] = {}
        self.heard: list[tuple[str, dict[str, Any]]] = []
        self.changed = threading.Condition()
        self.session.declare_subscriber(config.key("rfnav/*"), self._hear)

    def _hear(self, sample: Any) -> None:
        with self.changed:
            key = str(sample.key_expr).rsplit("/", 1)[1]
            self.heard.append((key, wire.decode_json(sample.payload.to_bytes(), key)))
            self.changed.notify_all()

    def publisher(self, topic: str) -> Any:
        if topic not in self.publishers:
            self.publishers[topic] = self.session.declare_publisher(
                self.config.key(topic), congestion_control=zenoh.CongestionControl.BLOCK
            )
        return self.publishers[topic]

    def send(self, topic: str, payload: bytes) -> None:
        self.publisher(topic).put(payload)

    def publish(
        self,
        stamp_ns: int,
        what: tuple[str, ...] = ALL,
        k: Intrinsics = K,
        depth: np.ndarray = DEPTH,
        pose: Pose = Pose(1, 2, 0.5),  # noqa: B008 -- immutable
    ) -> None:
        topics = self.config.topics
        payloads = {
            "camera_info": wire.encode_camera_info(k, stamp_ns),
            "odom": wire.encode_odometry(pose, stamp_ns),
            "depth": wire.encode_depth(depth, stamp_ns),
            "color": wire.encode_color(RGB, stamp_ns),
        }
        for name in what:
            self.send(getattr(topics, name), payloads[name])

    def ask(self, topic: str, body: bytes) -> dict[str, Any]:
        replies = list(self.session.get(self.config.key(topic), payload=body, timeout=PATIENCE_S))
        answer: dict[str, Any] = json.loads(replies[0].ok.payload.to_bytes())
        return answer


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def meet(robot: Robot, bus: Bus) -> None:
    """Zenoh loses what is sent in the first milliseconds of a link, whatever `matching_status`
    says: as the harness does, ask for the status until it is answered."""
    answered = threading.Event()

    def ask() -> None:
        while not answered.is_set():
            if list(robot.session.get(robot.config.key("rfnav/status"), timeout=0.2)):
                answered.set()

    asking = threading.Thread(target=ask)
    asking.start()
    until = time.monotonic() + PATIENCE_S
    while not answered.is_set():
        assert time.monotonic() < until, "the two sides do not see each other"
        bus.next(0.02)
        request = bus.request()
        if request is not None:
            request.reply({"state": "ready"})
    asking.join(PATIENCE_S)
    while bus.request() is not None:
        pass  # asked twice


def pair(lockstep: bool, **options: Any) -> tuple[Robot, Bus]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    robot = Robot(BusConfig(listen=(endpoint,), **options))
    bus = Bus(BusConfig(connect=(endpoint,), **options), SystemClock(), lockstep)
    meet(robot, bus)
    return robot, bus


def received(bus: Bus, topic: str, count: int) -> None:
    until = time.monotonic() + PATIENCE_S
    while topic not in bus.health() or bus.health()[topic].received < count:
        assert time.monotonic() < until, f"{topic} has not come"
        time.sleep(0.005)


@pytest.fixture
def lockstep() -> Iterator[tuple[Robot, Bus]]:
    robot, bus = pair(lockstep=True)
    yield robot, bus
    bus.close()
    robot.session.close()


@pytest.fixture
def realtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Robot, Bus]]:
    monkeypatch.setattr("runtime.robot.troubles.PATIENCE_S", 0.15)
    robot, bus = pair(lockstep=False, prefix="/robot1/")
    yield robot, bus
    bus.close()
    robot.session.close()


def test_a_set_arrives_as_it_was_sent(lockstep: tuple[Robot, Bus]) -> None:
    robot, bus = lockstep
    robot.publish(5_000)
    observation = bus.next(PATIENCE_S)
    assert isinstance(observation, Observation)
    assert observation.stamp_ns == 5_000
    np.testing.assert_array_equal(observation.rgb, RGB)
    np.testing.assert_array_equal(observation.depth_m, DEPTH)
    assert observation.intrinsics == K
    assert observation.pose.x_m == 1
    assert observation.pose.yaw_rad == pytest.approx(0.5)
    assert bus.next(0.0) is None


def test_a_localisation_s_map_is_told_of_and_moves_nothing() -> None:
    robot, bus = pair(lockstep=False, map_frame="map")
    try:
        robot.publish(time.time_ns())
        assert bus.next(PATIENCE_S) is not None
        here = bus.pose()
        turned = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))
        robot.send("tf", tf(("map", "odom", (10.0, -1.0, 0.0), turned), stamp_ns=time.time_ns()))
        by_s = time.monotonic() + PATIENCE_S
        while not (robot.heard and "map" in robot.heard[-1][1]):
            assert time.monotonic() < by_s, "the state has no map"
            bus.request()
            bus.publish_state({"pose": [1.0, 2.0, 0.5], "toward_xy": (3.0, 0.0)})
            time.sleep(0.05)
        told = robot.heard[-1][1]
        assert (told["pose"], told["toward_xy"]) == ([1.0, 2.0, 0.5], [3.0, 0.0])
        on_map = told["map"]
        assert (on_map["frame"], on_map["pose"][:2]) == ("map", [8.0, 0.0])  # 10 - 2, -1 + 1
        assert on_map["toward_xy"] == [10.0, 2.0]
        fed: list[Mapping[str, Any]] = []
        bus.on_feedback = fed.append
        bus.publish_feedback({"id": "0a", "toward_xy": (3.0, 0.0)})
        assert (fed[0]["id"], fed[0]["map"]["toward_xy"]) == ("0a", [10.0, 2.0])
        there = bus.placed(Pose(10.0, 2.0, np.pi / 2), "map")
        assert (there.x_m, there.y_m, there.yaw_rad) == pytest.approx((3.0, 0.0, 0.0))
        assert bus.pose() == here
        assert bus.doubt(Twist()) is None
    finally:
        bus.close()
        robot.session.close()


def test_in_lockstep_no_set_is_lost(lockstep: tuple[Robot, Bus]) -> None:
    robot, bus = lockstep
    for stamp in range(1, 31):
        robot.publish(stamp)
    seen = [bus.next(PATIENCE_S) for _ in range(30)]
    assert [o.stamp_ns for o in seen if o is not None] == list(range(1, 31))


def test_what_is_published_arrives_in_its_order(lockstep: tuple[Robot, Bus]) -> None:
    robot, bus = lockstep
    bus.publish_state({"step": 1})
    bus.publish_decision({"frontier": 7, "far": np.inf, "missing": (Missing("sle", Absence.LATE),)})
    bus.publish_action(9, Action.TURN_LEFT)
    with robot.changed:
        assert robot.changed.wait_for(lambda: len(robot.heard) == 3, PATIENCE_S)
    assert robot.heard == [
        ("state", {"step": 1}),
        (
            "decision",
            {"frontier": 7, "far": None, "missing": [{"expert": "sle", "cause": "late"}]},
        ),
        ("action", {"stamp_ns": 9, "action": "turn_left"}),
    ]


def test_requests_reach_the_owner_and_are_answered(lockstep: tuple[Robot, Bus]) -> None:
    robot, bus = lockstep
    answers: list[dict[str, Any]] = []
    asking = threading.Thread(
        target=lambda: answers.append(robot.ask("rfnav/goal", b'{"goal": "toilet"}'))
    )
    asking.start()
    assert bus.next(PATIENCE_S) is None  # comes back early: a request waits
    request = bus.request()
    assert request is not None
    assert (request.kind, request.body) == ("goal", {"goal": "toilet"})
    request.reply({"accepted": True})
    asking.join(PATIENCE_S)
    assert answers == [{"accepted": True}]
    assert bus.request() is None


def test_a_request_that_is_not_json_is_refused_with_a_reason(lockstep: tuple[Robot, Bus]) -> None:
    robot, bus = lockstep
    answers: list[dict[str, Any]] = []
    asking = threading.Thread(target=lambda: answers.append(robot.ask("rfnav/goal", b"toilet")))
    asking.start()
    assert bus.next(PATIENCE_S) is None
    assert bus.request() is None
    asking.join(PATIENCE_S)
    assert answers[0]["accepted"] is False
    assert answers[0]["error"].startswith("rfnav/goal: not JSON")


def test_a_camera_without_intrinsics_is_reported_at_its_first_frame(
    lockstep: tuple[Robot, Bus],
) -> None:
    robot, bus = lockstep
    robot.publish(1, k=Intrinsics(0, 0, 0, 0, 16, 12))
    with pytest.raises(SensorError, match=r"^camera/color/camera_info: K is zero"):
        bus.next(PATIENCE_S)


def test_a_depth_image_of_another_size_is_reported_at_its_first_frame(
    lockstep: tuple[Robot, Bus],
) -> None:
    robot, bus = lockstep
    robot.publish(1, depth=np.ones((7, 8), np.float32))
    with pytest.raises(SensorError, match=r"image is 8x7 but camera/color/camera_info .* 16x12"):
        bus.next(PATIENCE_S)


def held(bus: Bus) -> str:
    """What the base is held for, once it is held for something; frames are asked for meanwhile."""
    until = time.monotonic() + PATIENCE_S
    while (halt := bus.doubt(Twist())) is None:
        assert time.monotonic() < until, "nothing is said"
        assert bus.next(0.02) is None
    return halt.reason


def test_images_without_camera_info_hold_the_base_until_it_comes(
    realtime: tuple[Robot, Bus], monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, bus = realtime
    monkeypatch.setattr("runtime.robot.troubles.SILENCE_S", 0.2)
    told, stamp = "", 0
    while "camera_info: nothing received in 0.2 s" not in told or "odom" in told:
        stamp += 1
        robot.publish(stamp, ("odom", "depth", "color"))
        told = held(bus)
    robot.publish(stamp + 1)
    assert bus.next(PATIENCE_S) is not None
    assert "camera_info" not in str(bus.doubt(Twist()))


@pytest.mark.parametrize(
    "nonsense", [Intrinsics(0, 0, 0, 0, 16, 12), replace(K, cx=1e300), replace(K, fx=1e-3)]
)
def test_intrinsics_of_no_camera_hold_the_base_until_those_of_one_come(
    realtime: tuple[Robot, Bus], nonsense: Intrinsics
) -> None:
    robot, bus = realtime
    topic = TopicsConfig().camera_info
    robot.send(topic, wire.encode_camera_info(nonsense, 1))
    received(bus, topic, 1)
    robot.publish(1, ("odom", "depth", "color"))
    assert held(bus).startswith(f"{topic}: ")
    assert bus.health()[topic].bad == 1
    robot.publish(2)
    assert bus.next(PATIENCE_S) is not None
    assert bus.doubt(Twist()) is None
    robot.send(topic, wire.encode_camera_info(nonsense, 3))  # and in the midst of it
    received(bus, topic, 3)
    robot.publish(3)
    obs = bus.next(PATIENCE_S)
    assert obs is not None
    assert obs.intrinsics == K


def test_images_of_another_size_hold_the_base_until_their_camera_info_comes(
    realtime: tuple[Robot, Bus],
) -> None:
    robot, bus = realtime
    info = TopicsConfig().camera_info
    robot.send(info, wire.encode_camera_info(replace(K, width=32, height=24), 1))
    received(bus, info, 1)
    robot.publish(1, ("odom", "depth", "color"))
    assert "image is 16x12 but camera/color/camera_info describes 32x24" in held(bus)
    robot.send(info, wire.encode_camera_info(K, 2))
    received(bus, info, 2)
    robot.publish(2, ("odom", "depth", "color"))
    assert bus.next(PATIENCE_S) is not None
    assert bus.doubt(Twist()) is None


def test_after_the_first_frame_bad_messages_are_counted_and_survived(
    lockstep: tuple[Robot, Bus],
) -> None:
    robot, bus = lockstep
    robot.publish(1)
    assert bus.next(PATIENCE_S) is not None
    robot.send("odom", b"\0\1\0\0 nonsense that goes on for a while")
    robot.send("camera/depth/image_raw", b"short")
    robot.publish(2, k=Intrinsics(0, 0, 0, 0, 16, 12))
    received(bus, "camera/color/camera_info", 2)
    observation = bus.next(PATIENCE_S)
    assert observation is not None
    assert observation.stamp_ns == 2
    assert observation.intrinsics == K
    robot.publish(3, depth=np.ones((7, 8), np.float32))
    robot.publish(4)
    observation = bus.next(PATIENCE_S)
    assert observation is not None
    assert observation.stamp_ns == 4
    assert bus.next(0.0) is None
    health = bus.health()
    assert health["camera/depth/image_raw"].bad == 2
    assert "8x7" in health["camera/depth/image_raw"].last_error
    assert health["camera/color/camera_info"].bad == 1
    assert health["odom"].bad == 1
    assert health["camera/color/image_raw"].bad == 0


def test_in_real_time_only_the_newest_set_is_handed_over(realtime: tuple[Robot, Bus]) -> None:
    robot, bus = realtime
    for stamp in range(1, 6):
        robot.publish(stamp * 1_000_000, pose=Pose(0.05 * stamp, 0, 0))
    for topic in ("camera/color/image_raw", "camera/depth/image_raw", "odom"):
        received(bus, topic, 5)
    observation = bus.next(PATIENCE_S)
    assert observation is not None
    assert observation.stamp_ns == 5_000_000
    assert bus.next(0.0) is None
    newest = bus.pose()
    assert newest is not None
    assert newest[0].value.x_m == 0.25
    assert 0 <= SystemClock().now_s() - newest[1] < PATIENCE_S
    frame_s = bus.frame_arrival_s()
    assert frame_s == bus.delivered_s()
    robot.publish(6_000_000, pose=Pose(0.3, 0, 0))
    received(bus, "camera/color/image_raw", 6)
    later = bus.frame_arrival_s()
    assert later is not None
    assert later > (frame_s or later)  # not taken yet, but there


def test_a_hand_silences_what_drives_and_sensors_are_heard_by_their_names(
    realtime: tuple[Robot, Bus],
) -> None:
    robot, bus = realtime
    heard: list[bytes] = []
    topics = robot.config.topics
    robot.session.declare_subscriber(
        robot.config.key(topics.cmd_vel), lambda sample: heard.append(sample.payload.to_bytes())
    )

    def drive() -> Sent:
        return bus.drive(DriveOrder(Twist(0.1, 0.0), 0, time.monotonic() + 1.0))

    until(lambda: drive().twist is not None and heard)
    until(lambda: robot.send(topics.teleop, wire.encode_twist(0.0, 0.0)) or bus.condition().hand)
    assert bus.condition().hand == robot.config.key(topics.teleop)
    time.sleep(0.1)  # what was sent before is there
    count, sent = len(heard), drive()
    assert sent == Sent(None, f"a hand has the sticks: {robot.config.key(topics.teleop)}")
    until(lambda: not bus.condition().hand)
    assert len(heard) == count
    assert drive().twist is not None
    below = wire_senses.encode_range(0.5, 1, 1.0, "front_left")
    until(lambda: robot.send("cliff/front_left", below) or bus.felt().contacts)
    assert bus.felt().contacts[0].sensor == "cliff front_left"
    assert bus.health()[robot.config.key("cliff/front_left")].received >= 1


class ByAnotherWay:
    """A query that is none of Zenoh's."""

    payload: Any = property(lambda self: self)

    def to_bytes(self) -> bytes:
        return b'{"id": "0a"}'

    def reply(self, key: str, said: str) -> None:
        assert json.loads(said) == {"ended": True}

    def drop(self) -> None:
        pass


def test_a_stop_and_a_cancel_hold_the_base_before_anybody_asks_for_requests(
    realtime: tuple[Robot, Bus],
) -> None:
    robot, bus = realtime
    urgent: list[str] = []
    bus.on_urgent = lambda: urgent.append("now")

    def held() -> str:
        halt = bus.doubt(Twist())
        return halt.kind if halt else ""

    assert held() == ""
    assert robot.ask("rfnav/stop", b"{}") == {"stopped": True}
    assert held() == "stop"
    robot.send("stop", flag(True))
    until(lambda: len(urgent) == 2)
    refused = robot.ask("rfnav/release", b"{}")
    assert refused == {"released": False, "error": "robot1/stop is still pressed"}
    robot.send("stop", flag(False))
    until(lambda: robot.ask("rfnav/release", b"{}")["released"])
    assert held() == ""
    robot.send("stop", b"no message")
    until(lambda: held() == "stop")
    robot.send("stop", flag(False))
    until(lambda: robot.ask("rfnav/release", b"{}")["released"])
    asking = threading.Thread(target=robot.ask, args=("rfnav/cancel", b"{}"))
    asking.start()
    until(lambda: held() == "cancel")
    request = bus.request()
    assert request is not None
    assert held() == "cancel"
    request.reply({"ended": False})
    asking.join(PATIENCE_S)
    assert held() == ""
    hurried = len(urgent)
    bus.file("cancel", ByAnotherWay())
    assert (held(), len(urgent)) == ("cancel", hurried + 1)
    request = bus.request()
    assert request is not None
    assert request.body == {"id": "0a"}
    request.reply({"ended": True})
    assert held() == ""


def test_what_every_message_of_odometry_says_is_judged(realtime: tuple[Robot, Bus]) -> None:
    robot, bus = realtime
    for n, x_m in enumerate((0.0, 5.0, 0.0)):
        stamp_ns = 1_000_000_000 + n * 1_000_000
        robot.publish(stamp_ns, ("odom",), pose=Pose(x_m, 0.0, 0.0))
    received(bus, "odom", 3)
    halt = bus.doubt(Twist())
    assert halt is not None
    assert halt.reason == "odometry jumped by 5.00 m, 0.00 rad"


def until(what: Callable[[], object]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.02)


def test_flush_forgets_what_waits(lockstep: tuple[Robot, Bus]) -> None:
    robot, bus = lockstep
    robot.publish(1)
    for topic in ("camera/color/image_raw", "camera/depth/image_raw", "odom"):
        received(bus, topic, 1)
    bus.flush()
    assert bus.next(0.0) is None


def test_in_lockstep_a_set_that_comes_twice_is_one_step(lockstep: tuple[Robot, Bus]) -> None:
    robot, bus = lockstep
    robot.publish(7)
    assert bus.next(PATIENCE_S) is not None
    robot.publish(7)  # the harness got no answer yet: still thinking
    received(bus, "camera/color/image_raw", 2)
    assert bus.next(0.1) is None
    assert robot.heard == []
    bus.publish_action(7, Action.TURN_LEFT)
    robot.publish(7)  # the answer got lost
    received(bus, "camera/color/image_raw", 3)
    assert bus.next(0.1) is None
    with robot.changed:
        assert robot.changed.wait_for(lambda: len(robot.heard) == 2, PATIENCE_S)
    assert robot.heard[0] == robot.heard[1]
    bus.flush()  # a new episode begins with the same stamps
    robot.publish(7)
    assert bus.next(PATIENCE_S) is not None


def test_a_slam_pose_and_compressed_colour_can_be_configured() -> None:
    topics = TopicsConfig(pose="slam/pose", color="camera/color/image_raw/compressed")
    robot, bus = pair(lockstep=True, topics=topics)
    try:
        robot.publish(7, ("camera_info", "depth"))
        robot.send("slam/pose", slam_pose(Pose(4, 5, 0), 7))
        robot.send(topics.color, compressed_color(RGB, 7))
        observation = bus.next(PATIENCE_S)
        assert observation is not None
        assert observation.pose == Pose(4, 5, 0)
        assert observation.rgb.shape == (12, 16, 3)
    finally:
        bus.close()
        robot.session.close()


def test_closing_twice_is_closing_once() -> None:
    robot, bus = pair(lockstep=False)
    bus.close()
    bus.close()
    robot.session.close()


@pytest.mark.parametrize(
    ("config", "wanted"),
    [
        (BusConfig(mode="boss"), "bus.mode: 'boss' is not a mode"),
        (BusConfig(listen=("tcp/127.0.0.1:x",)), "cannot be opened: invalid port value"),
    ],
)
def test_a_bus_that_cannot_be_opened_says_why(config: BusConfig, wanted: str) -> None:
    with pytest.raises(BusError, match=wanted) as caught:
        open_session(config)
    assert "\n" not in str(caught.value)


def test_keys_follow_the_namespace() -> None:
    assert BusConfig().key("odom") == "odom"
    assert replace(BusConfig(), prefix="/robot1/").key("/odom") == "robot1/odom"


def test_the_mount_is_taken_from_tf_also_from_what_was_published_before() -> None:
    endpoint, other = (f"tcp/127.0.0.1:{free_port()}" for _ in range(2))
    robot = Robot(BusConfig(listen=(endpoint,)))
    told = zenoh.Config()  # a publisher that keeps what it said, as those of tf_static do
    told.insert_json5("listen/endpoints", f'["{other}"]')
    told.insert_json5("scouting/multicast/enabled", "false")
    told.insert_json5("timestamping/enabled", "true")
    with zenoh.open(told) as session:
        kept = declare_advanced_publisher(session, "tf_static", cache=CacheConfig(1),
                                          publisher_detection=True)  # fmt: skip
        kept.put(tf(("mast", "camera", (0, 0, 0.1), (-0.5, 0.5, -0.5, 0.5))))
        config = BusConfig(connect=(endpoint, other))
        bus = Bus(config, SystemClock(), camera=CameraConfig(mount="tf"))
        try:
            meet(robot, bus)
            robot.publish(10**9)
            assert bus.next(0.2) is None
            assert "no way from base_link to camera" in bus.health()["tf"].last_error
            at = 2 * 10**9
            robot.send("tf", tf(("base_link", "mast", (0, 0, 0.8), (0, 0, 0, 1)), stamp_ns=at))
            received(bus, "tf", 1)
            received(bus, "tf_static", 1)
            robot.publish(at)
            observation = bus.next(PATIENCE_S)
            assert observation is not None
            assert observation.mount == Mount(z_m=0.9)
        finally:
            bus.close()
            kept.undeclare()
            robot.session.close()


def test_a_camera_that_tf_does_not_know_holds_the_base(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("runtime.robot.troubles.PATIENCE_S", 0.1)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    robot = Robot(BusConfig(listen=(endpoint,)))
    bus = Bus(BusConfig(connect=(endpoint,)), SystemClock(), camera=CameraConfig(mount="tf"))
    try:
        meet(robot, bus)
        robot.publish(10**9)
        received(bus, TopicsConfig().camera_info, 1)  # it may come after the images
        assert held(bus).startswith("tf: no way from base_link to camera; known are")
    finally:
        bus.close()
        robot.session.close()


def test_one_that_does_not_serve_answers_nobody_and_every_message_can_be_tapped() -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    robot = Robot(BusConfig(listen=(endpoint,)))
    heard: list[tuple[str, int]] = []
    bus = Bus(
        BusConfig(connect=(endpoint,)),
        SystemClock(),
        camera=CameraConfig(mount="tf"),
        serves=False,
        tap=lambda name, payload: heard.append((name, len(payload))),
    )
    try:
        by_s = time.monotonic() + PATIENCE_S
        names = {*ALL, "bumper", "tf", "scan"}
        while {name for name, _ in heard} != names and time.monotonic() < by_s:
            robot.publish(time.time_ns())
            robot.send("bumper", b"junk")
            robot.send("tf", b"")
            robot.send("scan", b"\xff" * 9)
            time.sleep(0.05)
        assert {name for name, _ in heard} == names
        assert ("scan", 9) in heard
        assert list(robot.session.get("rfnav/status", timeout=0.3)) == []
        assert list(robot.session.get("rfnav/stop", timeout=0.3)) == []
        assert bus.doubt(Twist()) is None
    finally:
        bus.close()
        robot.session.close()
