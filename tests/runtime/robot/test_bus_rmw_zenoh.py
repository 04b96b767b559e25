"""The bus among nodes of rmw_zenoh: all that it hears and says, with a robot that encodes it by
itself."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import zenoh
from other_half import battery_state, flag, laser_scan, tf
from zenoh.ext import CacheConfig, MissDetectionConfig, declare_advanced_publisher

from hil_sim.driving.link import free_port
from hil_sim.driving.robot_wire import RobotWire
from runtime.clock import SystemClock
from runtime.core.types import Intrinsics, Pose, Twist
from runtime.robot import wire, wire_senses
from runtime.robot.base import DriveOrder
from runtime.robot.bus import Bus
from runtime.robot.session import BusConfig, open_session, session_settings
from runtime.robot.transforms import CameraConfig

PATIENCE_S = 10.0
K = Intrinsics(38.8, 38.8, 8.0, 6.0, 16, 12)
RGB = np.arange(12 * 16 * 3, dtype=np.uint8).reshape(12, 16, 3)
DEPTH = np.full((12, 16), 2.0, np.float32)
TF_HASH = "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
TF_KIND = "tf2_msgs::msg::dds_::TFMessage_"


class Robot:
    """`endpoint`: of a router, whose client it is; else it is a peer that listens."""

    def __init__(self, endpoint: str = "") -> None:
        self.endpoint = endpoint or f"tcp/127.0.0.1:{free_port()}"
        self.wire, self.mode = RobotWire("rmw_zenoh"), "client" if endpoint else "peer"
        where = (
            {"mode": "client", "connect": (endpoint,)} if endpoint else {"listen": (self.endpoint,)}
        )
        self.session: Any = open_session(BusConfig(**where))  # type: ignore[arg-type]
        self.heard: list[tuple[str, bytes, bytes]] = []
        for topic in ("rfnav/*", "cmd_vel"):
            self.session.declare_subscriber(self.wire.key(topic), self._hear)

    def _hear(self, sample: Any) -> None:
        topic = self.wire.topic(str(sample.key_expr))
        self.heard.append((topic, sample.payload.to_bytes(), sample.attachment.to_bytes()))

    def send(self, topic: str, payload: bytes) -> None:
        self.session.put(self.wire.key(topic), payload, attachment=self.wire.attachment())

    def bus(self, camera: CameraConfig = CameraConfig()) -> Bus:  # noqa: B008 -- immutable
        mode: Any = self.mode
        config = BusConfig(mode=mode, dialect="rmw_zenoh", connect=(self.endpoint,))
        return Bus(config, SystemClock(), camera=camera)


@pytest.fixture
def robot() -> Iterator[Robot]:
    robot = Robot()
    yield robot
    robot.session.close()


@pytest.fixture
def routed() -> Iterator[Robot]:
    """As with rmw_zenoh's own router, which is a Zenoh router with no more to it."""
    endpoint, config = f"tcp/127.0.0.1:{free_port()}", zenoh.Config()
    for name, value in session_settings(BusConfig(listen=(endpoint,))).items():
        config.insert_json5(name, json.dumps(value))
    config.insert_json5("mode", '"router"')
    router = zenoh.open(config)
    robot = Robot(endpoint)
    yield robot
    robot.session.close()
    router.close()


def until(what: Callable[[], Any]) -> Any:
    by_s = time.monotonic() + PATIENCE_S
    while not (found := what()):
        assert time.monotonic() < by_s
        time.sleep(0.01)
    return found


def test_a_frame_is_made_of_what_the_robot_sends(robot: Robot):
    with robot.bus() as bus:

        def frame() -> Any:
            stamp = time.time_ns()
            robot.send("camera/color/camera_info", wire.encode_camera_info(K, stamp))
            robot.send("odom", wire.encode_odometry(Pose(1, 2, 0.5), stamp))
            robot.send("camera/depth/image_raw", wire.encode_depth(DEPTH, stamp))
            robot.send("camera/color/image_raw", wire.encode_color(RGB, stamp, "lens"))
            return bus.next(0.2)

        observation = until(frame)
        np.testing.assert_array_equal(observation.rgb, RGB)
        assert observation.pose.x_m == 1
        assert bus.frame_of("odom", "?") == "odom"
        assert bus.frame_of("color", "?") == "lens"
        assert bus.health()["camera/color/image_raw"].received >= 1


def test_a_body_is_felt_and_a_hand_and_a_stop_are_heard(robot: Robot):
    with robot.bus() as bus:
        until(
            lambda: (
                robot.send("battery_state", battery_state(0.5, 1))
                or bus.condition().battery_percent
            )
        )
        assert bus.condition().battery_percent == 50.0
        until(lambda: robot.send("bumper", flag(True)) or bus.felt().contacts)
        until(lambda: robot.send("scan", laser_scan([1.0] * 9, 5)) or bus.health()["scan"].received)
        below = wire_senses.encode_range(0.5, 1, 1.0, "front_left")
        until(lambda: robot.send("cliff/front_left", below) or len(bus.felt().contacts) > 1)
        assert bus.felt().contacts[-1].sensor == "cliff front_left"
        until(lambda: robot.send("cmd_vel_teleop", wire.encode_twist(0, 0)) or bus.condition().hand)
        assert bus.condition().hand == "cmd_vel_teleop"
        until(lambda: robot.send("stop", flag(True)) or bus.doubt(Twist()))
        assert "stopped by stop" in bus.doubt(Twist()).reason  # type: ignore[union-attr]
        robot.send("rfnav/labels", wire.encode_json({"stamp_ns": 1, "boxes_px": "nonsense"}))
        until(lambda: (health := bus.health().get("rfnav/labels")) and health.bad)


@pytest.mark.parametrize("hashed", ["TypeHashNotSupported", "RIHS01_0"])
@pytest.mark.parametrize("kind", ["Bool", "Empty"])
def test_a_stop_of_another_type_or_distribution_stops_and_such_a_hand_is_a_hand(
    robot: Robot, kind: str, hashed: str
):
    """As what cannot be read on those topics does behind the bridge."""
    hurried: list[int] = []
    with robot.bus() as bus:
        bus.on_urgent = lambda: hurried.append(1)
        for topic, felt in (
            ("cmd_vel_teleop", lambda: bus.condition().hand),
            ("stop", lambda: bus.doubt(Twist())),
        ):
            key = f"0/{topic}/std_msgs::msg::dds_::{kind}_/{hashed}"
            until(lambda key=key, felt=felt: robot.session.put(key, flag(False)) or felt())
        assert bus.doubt(Twist()).kind == "stop"  # type: ignore[union-attr]
        assert hurried


@pytest.mark.parametrize("through", ["robot", "routed"])
def test_commands_and_reports_go_out_as_the_others_read_them(
    through: str, request: pytest.FixtureRequest
):
    robot = request.getfixturevalue(through)
    with robot.bus() as bus:

        def drive() -> Any:
            bus.drive(DriveOrder(Twist(0.2, 0.1), 0, time.monotonic() + 1.0))
            bus.publish_state({"state": "ready"})
            return {topic for topic, *_ in robot.heard} == {"cmd_vel", "rfnav/state"}

        until(drive)
        said = {topic: payload for topic, payload, _ in robot.heard}
        assert wire.decode_twist(said["cmd_vel"], "cmd_vel") == (0.2, 0.1)
        assert wire.decode_json(said["rfnav/state"], "state") == {"state": "ready"}
        assert {len(attachment) for *_, attachment in robot.heard} == {33}


def test_requests_are_plain_queries_in_this_dialect_too(robot: Robot):
    answers: list[Any] = []
    with robot.bus() as bus:

        def ask() -> None:
            while not answers:
                for reply in robot.session.get("rfnav/status", timeout=1.0):
                    answers.append(json.loads(reply.ok.payload.to_bytes()))

        asking = threading.Thread(target=ask)
        asking.start()
        until(bus.request).reply({"state": "ready"})
        asking.join(PATIENCE_S)
        while bus.request() is not None:
            pass
    assert answers[0] == {"state": "ready"}


@pytest.mark.parametrize("through", ["robot", "routed"])
def test_static_transforms_that_were_told_before_are_known(
    through: str, request: pytest.FixtureRequest
):
    robot = request.getfixturevalue(through)
    keeps = declare_advanced_publisher(
        robot.session,
        f"0/tf_static/{TF_KIND}/{TF_HASH}",
        cache=CacheConfig(1),
        publisher_detection=True,
        sample_miss_detection=MissDetectionConfig(heartbeat=None, sporadic_heartbeat=0.5),
    )
    told = tf(("base_link", "camera", (0.1, 0.0, 0.9), (-0.5, 0.5, -0.5, 0.5)))
    keeps.put(told, attachment=robot.wire.attachment())
    with robot.bus(CameraConfig(mount="tf", frame="camera")) as bus:
        until(lambda: bus.health().get("tf_static"))
        assert bus.health()["tf_static"].received == 1


def test_a_robot_of_another_distribution_is_told_of_once_and_counted(
    robot: Robot, capsys: pytest.CaptureFixture[str]
):
    key = "0/odom/nav_msgs::msg::dds_::Odometry_/TypeHashNotSupported"
    with robot.bus() as bus:

        def send() -> bool:
            robot.session.put(key, wire.encode_odometry(Pose(0, 0, 0), 5))
            return bus.health()["odom"].bad > 2

        until(send)
        assert bus.health()["odom"].received == 0
        assert 'set bus.distro = "humble"' in bus.health()["odom"].last_error
        until(lambda: send() and (halt := bus.doubt(Twist())) and halt.kind == "odometry")
    said = capsys.readouterr().err
    assert said.count('odom: comes with TypeHashNotSupported: set bus.distro = "humble"') == 1
