"""Sensors of a robot that drives, which say what cannot be true, or say it too late."""

import math

import numpy as np
import pytest

from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import SafetyConfig
from runtime.core.types import Pose, Twist
from runtime.robot import wire
from runtime.robot.stamps import WINDOW_S
from runtime.robot.sync import RawMessage
from runtime.robot.vigilance import (
    FORGIVEN_S,
    NOTED_S,
    STILL_STAMPS,
    Vigilance,
)

EPOCH_NS = 1_700_000_000_000_000_000  # the robot's clock is another than ours
AHEAD = Twist(0.3, 0.0)
NOISE = np.random.default_rng(5)


class Robot:
    """Three streams; the base goes along x at 0.3 m/s unless a test holds what it tells. `packed`:
    depth is compressed, of which no two images are the same bytes."""

    def __init__(self, cfg: SafetyConfig | None = None, packed: bool = False) -> None:
        self.vigilance, self.packed = Vigilance(cfg or SafetyConfig(), packed=packed), packed
        self.seen_m: float | None = None  # depth's own bytes tell that, if not what is there
        self.now_s = 50.0
        self.frozen: set[str] = set()
        self.delay_s = {"odom": 0.0, "depth": 0.05, "color": 0.05}
        self.kept: dict[str, bytes] = {}
        self.at = lambda s: Pose(0.3 * s, 0.0, 0.0)
        self.sent = AHEAD
        self.halts: list[str] = []
        self.dated: dict[str, float] = {}

    def put(self, stream: str, pose: Pose | None = None) -> None:
        taken_s = self.now_s - self.delay_s[stream]
        stamp_ns = EPOCH_NS + round(taken_s * 1e9)
        here = pose or self.at(self.now_s - 50.0 if self.delay_s[stream] > 100 else taken_s - 50.0)
        if stream == "odom":
            payload = wire.encode_odometry(here, stamp_ns)
        elif stream == "depth":
            row = np.linspace(2.0, 9.0, 64) - here.x_m
            image = np.tile(row, (48, 1)).astype(np.float32)
            if self.seen_m is not None:
                image = np.full_like(image, self.seen_m)
            payload = wire.encode_depth(image, stamp_ns)
            if self.packed:
                payload = payload[:12] + NOISE.bytes(3000)
        else:
            rgb = NOISE.integers(0, 255, (48, 64, 3), dtype=np.uint8)
            payload = wire.encode_color(rgb, stamp_ns)
        if stream in self.frozen:
            payload = payload[:12] + self.kept.get(stream, payload)[12:]
        self.kept[stream] = payload
        raw = RawMessage(stamp_ns, payload, self.now_s)
        self.dated[stream] = self.vigilance.take(stream, raw, stream).arrival_s
        if stream == "depth":
            self.vigilance.looked(image, self.now_s)

    def live(self, seconds: float, images: bool = True) -> str:
        """Odometry 20 times a second, images 10 times; why the base was held last, "" if it is
        not."""
        for n in range(round(seconds * 20)):
            self.now_s += 0.05
            self.put("odom")
            if n % 2 and images:
                self.put("color")
                self.put("depth")
            halt = self.vigilance.doubt(self.now_s, self.sent)
            self.halts.append(f"{halt.kind}: {halt.reason}" if halt else "")
        return self.halts[-1]


def test_a_robot_that_drives_is_not_doubted():
    robot = Robot()
    robot.live(15.0)
    assert set(robot.halts) == {""}


def test_a_robot_that_stands_is_not_doubted_whatever_repeats():
    robot = Robot()
    robot.at, robot.sent = lambda s: Pose(0.0, 0.0, 0.0), STILL
    robot.live(15.0)
    assert set(robot.halts) == {""}


def test_a_base_that_is_told_to_move_and_cannot_is_not_taken_for_broken_odometry():
    robot = Robot()
    robot.at = lambda s: Pose(0.0, 0.0, 0.0)
    robot.live(5.0)
    assert set(robot.halts) == {""}


def test_depth_that_repeats_while_colour_lives_holds_the_base():
    robot = Robot()
    robot.live(2.0)
    robot.frozen.add("depth")
    assert robot.live(1.0).startswith("frame: depth repeats itself for ")
    robot.frozen.clear()
    assert robot.live(0.2) == ""


def test_odometry_that_repeats_while_the_camera_moves_holds_the_base_until_it_changes():
    robot = Robot()
    robot.live(2.0)
    robot.frozen.add("odom")
    assert robot.live(4.0).startswith("odometry: odometry repeats itself for ")
    robot.at, robot.sent = lambda s: Pose(2.0, 0.0, 0.0), STILL  # it stands: all repeats
    assert robot.live(3.0).startswith("odometry: ")
    robot.frozen.clear()
    assert robot.live(0.2).startswith("jump: ")  # to where it really is
    assert robot.live(NOTED_S + 0.2) == ""


def test_a_camera_without_noise_before_which_odometry_comes_back_is_not_taken_for_frozen():
    robot = Robot()
    robot.live(2.0)
    robot.frozen.add("odom")
    robot.live(0.9)
    held = robot.at(robot.now_s - 50.0)
    robot.at, robot.sent = lambda s: held, STILL
    assert robot.live(2.0).startswith("odometry: ")
    robot.frozen.clear()
    robot.live(0.2)
    assert robot.live(5.0) == ""


def test_odometry_that_goes_on_repeating_is_tried_again_after_a_while():
    robot = Robot()
    robot.live(1.0)
    robot.frozen.add("odom")
    robot.live(5.0)
    robot.at = lambda s: Pose(2.0, 0.0, 0.0)
    assert robot.live(FORGIVEN_S) == ""


def test_an_image_without_a_difference_in_it_is_no_frozen_camera():
    robot = Robot()
    robot.live(1.0)
    blank = wire.encode_depth(np.zeros((48, 64), np.float32), 0)
    robot.kept["depth"], robot.frozen = blank, {"depth"}
    assert robot.live(3.0) == ""


def test_compressed_depth_is_judged_by_what_it_shows_and_not_by_its_bytes():
    robot = Robot(packed=True)
    robot.live(2.0)
    assert set(robot.halts) == {""}
    robot.frozen.add("odom")  # the base is told to move, and the camera sees that it does
    assert robot.live(2.0).startswith("odometry: odometry repeats itself for ")
    blocked = Robot(packed=True)
    blocked.live(1.0)
    blocked.at = lambda s: Pose(0.3, 0.0, 0.0)  # told to move, it does not
    blocked.frozen.add("odom")
    assert blocked.live(3.0) == ""


def test_compressed_depth_that_repeats_itself_is_noticed_unless_nothing_is_in_it():
    robot = Robot(packed=True)
    robot.live(1.0)
    robot.frozen.add("depth")
    assert robot.live(2.0).startswith("frame: depth repeats itself for ")
    robot.frozen.clear()
    assert robot.live(1.0) == ""
    robot.seen_m = 0.0
    robot.live(0.2)
    robot.frozen.add("depth")
    assert robot.live(3.0) == ""


def test_every_glitch_of_odometry_is_noticed_though_the_next_message_is_right_again():
    robot = Robot()
    robot.live(1.0)
    for n in range(15):
        robot.put("odom", Pose(5.0 + n, 0.0, 0.0))
        robot.put("odom")
        halt = robot.vigilance.doubt(robot.now_s, AHEAD)
        assert halt is not None
        assert halt.kind == "jump"
        assert robot.live(NOTED_S + 0.2) == ""


def test_a_clock_that_goes_back_is_noticed_and_what_was_noticed_last_is_told():
    robot = Robot()
    robot.live(1.0)
    robot.put("odom", Pose(5.0, 0.0, 0.0))
    robot.delay_s["odom"] = 3600.0
    assert robot.live(0.05) == "clock: odometry's clock went back by 3599.95 s"
    assert robot.live(NOTED_S + 0.2) == ""


def test_images_that_come_seconds_late_hold_the_base():
    robot = Robot()
    robot.live(2.0)
    robot.delay_s |= {"depth": 2.5, "color": 2.5}
    robot.live(2.5, images=False)
    assert robot.live(0.2).startswith("frame: depth comes 2.5 s late by its stamps")
    assert robot.dated["depth"] == pytest.approx(robot.now_s - 2.5)


def test_images_that_are_late_from_the_beginning_are_known_by_odometry():
    robot = Robot()
    robot.delay_s |= {"depth": 2.5, "color": 2.5}
    assert robot.live(2 * WINDOW_S).startswith("frame: depth comes 2.5 s late by its stamps")


def test_odometry_that_begins_to_lag_holds_the_base():
    robot = Robot()
    robot.live(2.0)
    robot.delay_s["odom"] = 0.8
    robot.now_s += 0.8
    assert robot.live(0.2).startswith("odometry: odom comes 0.8 s late by its stamps")


def test_stamps_that_stand_still_are_said_once_and_age_is_told_by_arrival():
    said: list[str] = []
    vigilance = Vigilance(SafetyConfig(), tell=said.append)
    payload = wire.encode_odometry(Pose(0.0, 0.0, 0.0), 0)
    for n in range(50):
        raw = RawMessage(0, payload, 10.0 + n)
        assert vigilance.take("odom", raw, "base/odom") == raw
        assert vigilance.unstamped == ({"base/odom"} if n >= STILL_STAMPS - 1 else set())
        assert vigilance.doubt(10.0 + n, AHEAD) is None
    what = "base/odom: stamps stand still: its age is told by its arrival alone"
    assert said == [f"{what}; let the driver fill in header.stamp"]
    for n in range(10):  # a message that comes twice now and then is no such stream
        for _ in range(2):
            stamped = wire.encode_odometry(Pose(0.0, 0.0, 0.0), EPOCH_NS + n)
            vigilance.take("odom", RawMessage(EPOCH_NS + n, stamped, 60.0 + n), "base/odom")
        assert not vigilance.unstamped
    assert len(said) == 1


def test_a_base_that_leans_is_held():
    robot = Robot()
    robot.live(1.0)
    stamp_ns = EPOCH_NS + round(robot.now_s * 1e9)
    upright = wire.encode_odometry(Pose(0.3, 0.0, 0.0), stamp_ns)
    message = wire.decode(upright, wire.ODOMETRY, "odom")
    half = 0.5 * 0.5  # rad
    message.pose.pose.orientation.y = math.sin(half)
    message.pose.pose.orientation.w = math.cos(half)
    payload = wire.encode(message)
    robot.vigilance.take("odom", RawMessage(stamp_ns, payload, robot.now_s), "odom")
    halt = robot.vigilance.doubt(robot.now_s, AHEAD)
    assert halt is not None
    assert halt.reason == "the base leans by 29 degrees"


def test_outside_its_area_the_base_stays_held_and_anywhere_is_no_area():
    robot = Robot(SafetyConfig(area_m=1.0))
    assert robot.live(3.0) == ""
    assert robot.live(1.0).startswith("area: 1.")
    robot.at = lambda s: Pose(1.1, 0.0, 0.0)
    assert robot.live(5.0) == "area: 1.1 m from where it began, 1 m are its area: bring it back"
