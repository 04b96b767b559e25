"""What comes over the wire that no robot should send: counted, and the rest goes on."""

import threading

import numpy as np
import pytest
from camera_messages import compressed_depth, compressed_image, png
from manual_clock import ManualClock
from other_half import laser_scan, tf

from runtime.clock import Deadline
from runtime.core.motion.safety import SafetyConfig
from runtime.core.types import Intrinsics, Observation, Pose
from runtime.robot import wire
from runtime.robot.images import camera_images
from runtime.robot.session import BusConfig
from runtime.robot.steady import STEADY_S
from runtime.robot.streams import SensorStreams
from runtime.robot.transforms import FIXED, CameraConfig
from runtime.robot.vigilance import Vigilance

K = Intrinsics(20.0, 20.0, 8.0, 6.0, 16, 12)
S = 1_000_000_000
HERE = Pose(0.0, 0.0, 0.0)
DEPTH, ODOM = "camera/depth/image_raw", "odom"


class Camera:
    """The streams, and what is put into them."""

    def __init__(self, camera: CameraConfig = FIXED, bus: BusConfig | None = None) -> None:
        self.clock, self.changed = ManualClock(1.0), threading.Condition()
        told = bus or BusConfig()
        self.streams = SensorStreams(told, self.clock, self.changed, False, camera)
        self.streams.file("camera_info", wire.encode_camera_info(K, 0))

    def show(self, depth: bytes, at_s: float, pose: Pose = HERE) -> Observation | None:
        """A frame, between odometry of just before and just after."""
        stamp_ns = round(at_s * S)
        self.streams.file("color", wire.encode_color(np.zeros((12, 16, 3), np.uint8), stamp_ns))
        self.streams.file("depth", depth)
        for beside_ns in (-S // 100, S // 100):
            self.streams.file("odom", wire.encode_odometry(pose, stamp_ns + beside_ns))
        with self.changed:
            match = self.streams.wait_for_match(Deadline.after(0.0, self.clock), lambda: True)
        return self.streams.observe(match) if match is not None else None


def depth(values: float, at_s: float, encoding: str = "32FC1") -> bytes:
    image = np.full((12, 16), values, np.float32)
    if encoding == "16UC1" and values > 65:
        payload = wire.encode_depth(np.zeros_like(image), round(at_s * S), encoding=encoding)
        return payload[: -image.size * 2] + b"\xff" * (image.size * 2)
    return wire.encode_depth(image, round(at_s * S), encoding=encoding)


@pytest.mark.parametrize(
    ("value", "encoding"),
    [(np.nan, "32FC1"), (np.inf, "32FC1"), (-np.inf, "32FC1"), (-2.0, "32FC1"),
     (0.0, "16UC1"), (65.535, "16UC1")],
)  # fmt: skip
def test_depth_that_is_none_is_zero_and_counted(value: float, encoding: str):
    camera = Camera()
    obs = camera.show(depth(value, 5.0, encoding), 5.0)
    assert obs is not None
    assert not obs.depth_m.any()
    assert camera.show(depth(2.0, 5.2), 5.2) is not None
    assert camera.streams.health()[DEPTH].blank == 1


def test_time_that_goes_back_is_counted_and_what_comes_after_is_used():
    camera = Camera()
    assert camera.show(depth(2.0, 100.0), 100.0) is not None
    assert camera.show(depth(2.0, 50.0), 50.0) is None  # the odometry of then is not of its time
    again = camera.show(depth(2.0, 50.2), 50.2, Pose(0.4, 0.0, 0.0))
    assert again is not None
    assert again.pose == Pose(0.4, 0.0, 0.0)  # nothing of the other time is mixed in
    assert camera.streams.health()[ODOM].set_back == 1
    assert sum(h.set_back for h in camera.streams.health().values()) == 1


def test_stamps_that_are_0_degrade_a_search_as_others_that_stand_still_do():
    clock, vigilance = ManualClock(1.0), Vigilance(SafetyConfig(), tell=lambda line: None)
    told = BusConfig(), clock, threading.Condition(), False, FIXED
    streams = SensorStreams(*told, vigilance=vigilance)
    for stamp_ns, unstamped in ((0, {ODOM}), (S, set()), (S, {ODOM})):
        for n in range(9 if unstamped else 1):
            streams.file("odom", wire.encode_odometry(Pose(0.01 * n, 0.0, 0.0), stamp_ns))
            clock.advance(0.05)
        assert vigilance.unstamped == unstamped


def test_a_jump_of_5_m_is_used_when_it_has_stayed_there():
    camera, there = Camera(), Pose(5.0, 0.0, 0.0)
    assert camera.show(depth(2.0, 5.0), 5.0) is not None
    assert camera.show(depth(2.0, 5.2), 5.2, there) is None
    pose, _ = camera.streams.newest_pose()
    assert pose.value == there  # who drives is told all the same
    camera.clock.advance(STEADY_S)
    after = camera.show(depth(2.0, 5.4), 5.4, there)
    assert after is not None
    assert after.pose == there  # and of no place between
    assert camera.streams.health()[ODOM].jumped == 2


def test_single_messages_from_elsewhere_never_reach_an_image():
    camera = Camera()
    assert camera.show(depth(2.0, 4.8), 4.8) is not None
    for n in range(30):
        at_s = 5.0 + 0.2 * n
        camera.clock.advance(0.2)
        glitch = wire.encode_odometry(Pose(1000.0, 1000.0, 2.0), round(at_s * S) - 5)
        camera.streams.file("odom", glitch)
        obs = camera.show(depth(2.0, at_s), at_s)
        assert obs is not None
        assert obs.pose == HERE
    assert camera.streams.health()[ODOM].jumped == 30


@pytest.mark.parametrize(
    "wrong",
    [{"boxes": "none"}, {"scores": [0.5, 0.4]}, {"scores": [7.0]}, {"boxes": [[0, 0, 1e9, 1]]}],
)
def test_labels_that_cannot_be_read_are_counted_and_those_before_stay(wrong: dict):
    camera = Camera()
    good = {"stamp_ns": 5, "boxes": [[0, 0, 4, 4]], "names": ["bed"], "scores": [0.5], "room": None}
    for message in (good, good | wrong):
        camera.streams.file_labels("detections", wire.encode_json(message))
    at_once = Deadline.after(0.0, camera.clock)
    assert camera.streams.labels(5, at_once) == good
    health = camera.streams.health()["detections"]
    assert (health.received, health.bad) == (1, 1)
    assert health.last_error.startswith("detections: ")


def scans(camera: Camera, *at_s: float, payload: bytes = b"") -> None:
    for when in at_s:
        camera.streams.file("scan", payload or laser_scan([1.0, 2.0], round(when * S)))


def test_a_scan_goes_with_the_image_of_its_time_and_with_no_other():
    camera = Camera()
    assert camera.show(depth(2.0, 5.0), 5.0).scan is None
    scans(camera, 5.21)
    there = Pose(0.1, 0.2, 0.0)
    found = camera.show(depth(2.0, 5.2), 5.2, there).scan
    assert found.at_xy == (0.1, 0.2)
    assert found.ranges_m.tolist() == [1.0, 2.0]
    assert camera.show(depth(2.0, 5.4), 5.4).scan is None


def test_a_scan_that_cannot_be_read_costs_no_image():
    camera = Camera()
    for n, wrong in enumerate((laser_scan([], 5 * S), laser_scan([1.0], 5 * S)[:-30], b"\0\1")):
        scans(camera, 0, payload=wrong)
        obs = camera.show(depth(2.0, 5.0 + 0.01 * n), 5.0 + 0.01 * n)
        assert obs is not None
        assert obs.scan is None
    health = camera.streams.health()["scan"]
    assert (health.received, health.bad) == (3, 3)
    assert health.last_error.startswith("scan: ")


def test_where_tf_is_read_it_says_where_the_laser_is():
    camera = Camera(CameraConfig(mount="tf"))
    unit = (0.0, 0.0, 0.0, 1.0)
    optical = (-0.5, 0.5, -0.5, 0.5)
    told = tf(("base_link", "camera", (0.1, 0.0, 0.8), optical))
    camera.streams.file_transforms("tf_static", told)
    scans(camera, 5.0)
    obs = camera.show(depth(2.0, 5.0), 5.0)
    assert obs.scan is None  # nobody has told yet where that is
    assert "no way from base_link to laser" in camera.streams.health()["scan"].last_error
    told = tf(("base_link", "laser", (0.2, 0.0, 0.3), unit))
    camera.streams.file_transforms("tf_static", told)
    scans(camera, 5.2)
    assert camera.show(depth(2.0, 5.2), 5.2).scan.at_xy == (0.2, 0.0)


def test_a_frame_takes_the_depth_that_the_reflex_has_decoded(monkeypatch: pytest.MonkeyPatch):
    camera, decoded = Camera(), []
    real = camera_images.read_depth
    monkeypatch.setattr(
        camera_images, "read_depth", lambda *args: decoded.append(args) or real(*args)
    )
    camera.streams.file("depth", depth(2.0, 5.0))
    with camera.changed:
        newest = camera.streams.newest_depth()
    image = camera.streams.depth(newest)
    clean = image.solid()
    stamp_ns = 5 * S
    camera.streams.file("color", wire.encode_color(np.zeros((12, 16, 3), np.uint8), stamp_ns))
    camera.streams.file("odom", wire.encode_odometry(HERE, stamp_ns))
    with camera.changed:
        match = camera.streams.wait_for_match(Deadline.after(0.0, camera.clock), lambda: True)
    obs = camera.streams.observe(match)
    assert obs.depth_m is image.depth_m
    assert obs.solid_m is clean
    assert len(decoded) == 1
    alone = camera.show(depth(2.5, 5.2), 5.2)  # nobody drives: the reflex has not looked
    assert alone.solid_m is None
    assert (alone.depth_m == 2.5).all()


def test_depth_that_comes_packed_in_another_unit_is_read_as_configured():
    tenths = np.full((12, 16), 20_000, np.uint16)
    bus = BusConfig(compressed=("depth",))
    camera = Camera(CameraConfig(depth_unit_m=0.0001), bus)
    packed = compressed_image(*compressed_depth(png(tenths)), stamp_ns=5 * S)
    obs = camera.show(packed, 5.0)
    assert (obs.depth_m == 2.0).all()


@pytest.mark.parametrize(("lockstep", "frames"), [(False, 0), (True, 1)])
def test_a_unit_that_cannot_be_is_refused_but_under_a_harness(lockstep: bool, frames: int):
    camera = Camera()
    camera.streams = SensorStreams(BusConfig(), camera.clock, camera.changed, lockstep, FIXED)
    camera.streams.file("camera_info", wire.encode_camera_info(K, 0))
    stamp_ns = 5 * S
    camera.streams.file("color", wire.encode_color(np.zeros((12, 16, 3), np.uint8), stamp_ns))
    camera.streams.file("depth", depth(30.0, 5.0))
    camera.streams.file("odom", wire.encode_odometry(HERE, stamp_ns))
    with camera.changed:
        match = camera.streams.wait_for_match(Deadline.after(0.0, camera.clock), lambda: True)
    assert (camera.streams.observe(match) is not None) == frames
    error = camera.streams.health()[DEPTH].last_error
    assert ("set camera.depth_unit_m" in error) == (not lockstep)


def test_intrinsics_may_change_with_the_size_of_the_images():
    camera = Camera()
    assert camera.show(depth(2.0, 5.0), 5.0) is not None
    half = Intrinsics(10.0, 10.0, 4.0, 6.0, 8, 12)
    camera.streams.file("camera_info", wire.encode_camera_info(half, 5 * S))
    assert camera.show(depth(2.0, 5.2), 5.2) is None  # of the size before
    stamp_ns = round(5.4 * S)
    camera.streams.file("color", wire.encode_color(np.zeros((12, 8, 3), np.uint8), stamp_ns))
    camera.streams.file("depth", wire.encode_depth(np.full((12, 8), 2.0, np.float32), stamp_ns))
    camera.streams.file("odom", wire.encode_odometry(HERE, stamp_ns))
    with camera.changed:
        match = camera.streams.wait_for_match(Deadline.after(0.0, camera.clock), lambda: True)
    obs = camera.streams.observe(match)
    assert obs.intrinsics == half
    assert obs.depth_m.shape == (12, 8)


def live(camera: Camera, seconds: float, odom_hz: float, stamped=True) -> list[Observation]:
    """Images 10 times a second, 30 ms after they were taken, of a base that goes along x at 0.3
    m/s; the frames that come of it."""
    found: list[Observation] = []
    next_odom_s = next_image_s = camera.clock.now_s()
    until_s = camera.clock.now_s() + seconds
    while camera.clock.now_s() < until_s:
        camera.clock.advance(0.005)
        now_s = camera.clock.now_s()
        if now_s >= next_odom_s:
            next_odom_s += 1 / odom_hz
            pose, stamp_ns = Pose(0.3 * now_s, 0.0, 0.0), round(now_s * S) if stamped else 0
            camera.streams.file("odom", wire.encode_odometry(pose, stamp_ns))
        if now_s >= next_image_s:
            next_image_s += 0.1
            stamp_ns = round((now_s - 0.03) * S) if stamped else 0
            rgb = np.zeros((12, 16, 3), np.uint8)
            camera.streams.file("color", wire.encode_color(rgb, stamp_ns))
            image = np.full((12, 16), 2.0 + now_s / 100, np.float32)
            camera.streams.file("depth", wire.encode_depth(image, stamp_ns))
        with camera.changed:
            match = camera.streams.wait_for_match(Deadline.after(0.0, camera.clock), lambda: True)
        if match is not None and (obs := camera.streams.observe(match)) is not None:
            found.append(obs)
    return found


def test_odometry_at_3_hz_is_interpolated_once_it_is_known_how_often_it_comes():
    camera = Camera()
    live(camera, 3.0, odom_hz=3.0)
    frames = live(camera, 3.0, odom_hz=3.0)
    assert len(frames) >= 8  # those that an odometry message ends: the newest of three
    for obs in frames:
        assert obs.pose.x_m == pytest.approx(0.3 * obs.stamp_ns / S, abs=0.003)


def test_without_stamps_images_go_with_the_odometry_of_their_arrival(capsys):
    camera = Camera()
    frames = live(camera, 2.0, odom_hz=30.0, stamped=False)
    assert len(frames) > 15
    for obs in frames:
        seen_s = 100 * (float(obs.depth_m[0, 0]) - 2.0)  # when the image came
        assert obs.pose.x_m == pytest.approx(0.3 * seen_s, abs=0.02)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert all("header.stamp is 0: arrival is taken" in line for line in lines)


def test_colour_and_depth_go_together_by_arrival_only_as_long_as_they_have_no_stamps():
    camera = Camera()
    streams = camera.streams

    def frame(color_s: float, depth_s: float) -> bool:
        camera.clock.advance(0.1)
        rgb = np.zeros((12, 16, 3), np.uint8)
        streams.file("odom", wire.encode_odometry(HERE, round((color_s or 1) * S) - S // 100))
        streams.file("color", wire.encode_color(rgb, round(color_s * S)))
        camera.clock.advance(0.04)
        streams.file("depth", depth(2.0, depth_s))
        streams.file("odom", wire.encode_odometry(HERE, round((depth_s or 1) * S) + S // 10))
        with camera.changed:
            by = Deadline.after(0.0, camera.clock)
            return streams.wait_for_match(by, lambda: True) is not None

    streams.file("odom", wire.encode_odometry(HERE, 0))  # it may once have none, too
    assert not frame(10.0, 10.04)
    assert frame(0.0, 0.0)
    assert not frame(12.0, 12.04)
