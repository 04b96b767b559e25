"""Messages as other people's programs make them, and what is kept of them."""

import threading

import numpy as np
import pytest
from hearings import BEGAN_S, S
from other_half import battery_state, compressed_color, flag, hazards, laser_scan, slam_pose, tf

from runtime.config import Config, load
from runtime.core.types import Intrinsics, Observation, Pose
from runtime.doctor.hearing import Hearing
from runtime.doctor.reading import PoseReader, Reading, topics_heard
from runtime.errors import SensorError
from runtime.robot import wire

K = Intrinsics(100.0, 100.0, 80.0, 60.0, 160, 120)
RGB = np.zeros((120, 160, 3), np.uint8)
DEPTH = np.full((120, 160), 2.0, np.float32)
JUNK = b"\0\1\0\0" + b"\xff" * 40


class Reader:
    """Reads what it is told at once."""

    def __init__(self, *settings: str) -> None:
        self.reading = Reading(load(None, settings))
        self.streams = self.reading.hearing().streams

    def take(self, stream: str, *payloads: bytes) -> Hearing:
        for payload in payloads:
            self.reading.file(stream, payload)
        self.reading.read()
        return self.reading.hearing()


def stamp(at_s: float = 0.0) -> int:
    return round((BEGAN_S + at_s) * S)


def test_what_is_listened_to_is_what_is_configured():
    heard = topics_heard(Config())
    assert list(heard)[:4] == ["color", "depth", "camera_info", "odom"]
    assert "tf" not in heard
    slam = topics_heard(load(None, ["bus.topics.pose=slam", "camera.mount=tf", "bus.topics.scan="]))
    assert (slam["odom"].topic, slam["odom"].kind) == ("slam", wire.POSE_STAMPED)
    assert {"tf", "tf_static"} <= slam.keys()
    assert "scan" not in slam
    rover = ["base.kind=mavlink", "base.odometry=true"]
    assert "odom" not in topics_heard(load(None, rover))
    for setting in ("bus.topics.color=camera/rgb/compressed", "bus.compressed=['color']"):
        packed = topics_heard(load(None, [setting]))
        assert (packed["color"].kind, packed["depth"].kind) == (wire.COMPRESSED_IMAGE, wire.IMAGE)


def test_odometry_keeps_its_frames_and_its_whole_rotation():
    reader = Reader()
    told = wire.encode_odometry(Pose(1.0, 2.0, 0.5), stamp(), "odom", "base_link")
    (pose,) = reader.take("odom", told).odometry
    assert (pose.frame, pose.child, pose.xy, pose.stamp_ns) == (
        "odom", "base_link", (1, 2), stamp()
    )  # fmt: skip
    assert pose.yaw_rad == pytest.approx(0.5)
    assert reader.streams["odom"].frame == "odom -> base_link"
    (arrival,) = reader.streams["odom"].arrivals
    assert (arrival.stamp_ns, arrival.size) == (stamp(), len(told))
    slam = Reader("bus.topics.pose=slam").take("odom", slam_pose(Pose(0.0, 0.0, -1.0), stamp()))
    assert slam.odometry[0].yaw_rad == pytest.approx(-1.0)


def test_intrinsics_and_what_the_lens_does():
    info = Reader().take("camera_info", wire.encode_camera_info(K, stamp(), "optical")).info
    assert info is not None
    assert (info.intrinsics, info.frame, info.model) == (K, "optical", "plumb_bob")
    assert not any(info.distortion)


def test_images_are_described_and_only_some_are_read():
    reader = Reader()
    colors = [wire.encode_color(RGB, stamp(0.1 * n), "optical") for n in range(5)]
    reader.take("color", *colors)
    reader.take("depth", wire.encode_depth(DEPTH, stamp(), "optical", "16UC1"))
    color, depth = reader.streams["color"], reader.streams["depth"]
    assert (color.what, color.frame) == ("rgb8 160x120", "optical")
    assert (color.received, color.read) == (5, 1)
    assert depth.what == "16UC1 160x120"


def test_a_compressed_image_says_how():
    reader = Reader("bus.topics.color=camera/rgb/compressed")
    reader.take("color", compressed_color(RGB, stamp()))
    assert reader.streams["color"].what == "jpeg 160x120"


GOOD = {
    "scan": laser_scan([1.0] * 8, stamp()), "battery": battery_state(0.5, stamp()),
    "bumper": flag(True), "hazards": hazards([("bump", 1)], stamp()),
    "teleop": wire.encode_twist(0.1, 0.0),
}  # fmt: skip


@pytest.mark.parametrize("stream", GOOD)
def test_other_senses_are_read_as_the_runtime_reads_them(stream: str):
    reader = Reader()
    reader.take(stream, GOOD[stream])
    assert (reader.streams[stream].read, reader.streams[stream].bad) == (1, 0)
    reader.take(stream, b"\0\1")
    assert (reader.streams[stream].read, reader.streams[stream].bad) == (1, 1)


def test_tf_is_read_where_it_is_gone_by():
    reader = Reader("camera.mount=tf")
    reader.take("tf", tf(("base_link", "optical", (0, 0, 1), (0, 0, 0, 1))))
    assert (reader.streams["tf"].read, reader.streams["tf"].arrivals[0].stamp_ns) == (1, None)


@pytest.mark.parametrize("stream", ["odom", "camera_info", "color", "depth"])
@pytest.mark.parametrize("payload", [JUNK, b"", b"\0\1\0\0" + bytes(8) + b"\xff" * 200])
def test_what_cannot_be_read_is_counted_with_its_topic_and_ends_nothing(
    stream: str, payload: bytes
):
    reader = Reader()
    reader.take(stream, payload)
    assert reader.streams[stream].bad == 1
    assert reader.streams[stream].error.startswith(reader.streams[stream].topic)


def test_what_nobody_listens_to_is_left_alone():
    assert "strange" not in Reader().take("strange", JUNK).streams


def test_frames_are_counted_and_some_are_kept():
    reader = Reader()
    for n in range(10):
        obs = Observation(stamp(0.05 * n), RGB, DEPTH, Pose(0, 0, 0), K)
        reader.reading.seen(obs, 100.0 + 0.06 * n)
    heard = reader.reading.hearing()
    assert heard.frames == 10
    assert heard.intrinsics == K
    assert len(heard.glimpses) == len(heard.depths) == 5
    assert all(g.depth_m is not None and g.depth_m[0, 0] == 2.0 for g in heard.glimpses)


def test_it_reads_in_a_thread_of_its_own_until_it_is_closed():
    reader = Reader()
    thread = threading.Thread(target=reader.reading.run)
    thread.start()
    reader.reading.file("odom", wire.encode_odometry(Pose(0, 0, 0), stamp()))
    reader.reading.file("odom", b"")
    reader.reading.close()
    thread.join(10.0)
    assert not thread.is_alive()
    assert (reader.streams["odom"].read, reader.streams["odom"].bad) == (1, 1)


def test_reading_a_pose_raises_for_what_the_runtime_could_not_use():
    with pytest.raises(SensorError):
        PoseReader(Config()).read(wire.encode_odometry(Pose(float("nan"), 0.0, 0.0), stamp()))


def test_a_cameras_pose_is_taken_to_the_base_as_the_runtime_takes_it():
    config = load(None, ["camera.x_m=0.2", "camera.yaw_rad=0.3"])
    told = wire.encode_odometry(Pose(1.2, 2.0, 0.3), stamp(), "odom", "camera_link")
    pose = PoseReader(config).read(told)
    assert pose.child == "camera_link"
    assert pose.yaw_rad == pytest.approx(0.0, abs=1e-6)
    assert pose.xy == pytest.approx((1.0, 2.0), abs=1e-6)
