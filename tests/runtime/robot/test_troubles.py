"""What is wrong with the streams is a reason to stand, in one line, as long as it goes on."""

import threading
from collections.abc import Iterable

import numpy as np
import pytest
from manual_clock import ManualClock

from runtime.clock import Deadline
from runtime.core.motion.safety import Halt, HaltKind
from runtime.core.types import Intrinsics, Pose
from runtime.robot import wire
from runtime.robot.session import BusConfig
from runtime.robot.streams import SensorStreams
from runtime.robot.transforms import FIXED
from runtime.robot.troubles import PATIENCE_S, SILENCE_S, UNMATCHED_S

K = Intrinsics(20.0, 20.0, 8.0, 6.0, 16, 12)
S = 1_000_000_000
COLOR, DEPTH, INFO = "camera/color/image_raw", "camera/depth/image_raw", "camera/color/camera_info"
STREAMS = ("camera_info", "color", "depth", "odom")
TICK_S = 0.1


class Robot:
    """Ten times a second a message of each stream that is `sending`, by one clock but for `off_s`;
    `bytes_of` has others than the good ones."""

    def __init__(self) -> None:
        self.clock, self.changed = ManualClock(100.0), threading.Condition()
        self.streams = SensorStreams(BusConfig(), self.clock, self.changed, False, FIXED)
        self.sending: Iterable[str] = STREAMS
        self.off_s = dict.fromkeys(STREAMS, 0.0)
        self.bytes_of: dict[str, bytes] = {}
        self.odom_every = 1
        self.sent = self.frames = 0

    def goes_on(self, seconds: float) -> Halt | None:
        """Publish, look for frames and ask what is wrong for so long; what is by then."""
        halt = None
        for _ in range(round(seconds / TICK_S)):
            self.clock.advance(TICK_S)
            self.sent += 1
            for stream in self.sending:
                if stream != "odom" or self.sent % self.odom_every == 0:
                    self.streams.file(stream, self.bytes_of.get(stream) or self.good(stream))
            with self.changed:
                match = self.streams.wait_for_match(Deadline.after(0.0, self.clock), lambda: True)
            if match is not None:
                self.frames += self.streams.observe(match) is not None
            with self.changed:
                halt = self.streams.trouble()
        return halt

    def good(self, stream: str) -> bytes:
        stamp_ns = round((self.clock.now_s() + self.off_s[stream]) * S)
        if stream == "color":
            return wire.encode_color(np.zeros((12, 16, 3), np.uint8), stamp_ns)
        if stream == "depth":
            return wire.encode_depth(np.full((12, 16), 2.0, np.float32), stamp_ns)
        if stream == "camera_info":
            return wire.encode_camera_info(K, stamp_ns)
        return wire.encode_odometry(Pose(0.0, 0.0, 0.0), stamp_ns)


def without(*streams: str) -> list[str]:
    return [stream for stream in STREAMS if stream not in streams]


def test_nothing_is_wrong_with_a_robot_that_is_well():
    robot = Robot()
    assert robot.goes_on(30.0) is None
    assert robot.frames > 290


@pytest.mark.parametrize(
    ("missing", "topics", "kind"),
    [
        (("color",), COLOR, HaltKind.FRAME),
        (("depth",), DEPTH, HaltKind.FRAME),
        (("camera_info",), INFO, HaltKind.FRAME),
        (("odom",), "odom", HaltKind.ODOMETRY),
        (STREAMS, f"{COLOR}, {DEPTH}, {INFO}, odom", HaltKind.FRAME),
    ],
)
def test_a_silent_topic_is_named_until_it_speaks(
    missing: tuple[str, ...], topics: str, kind: HaltKind
):
    robot = Robot()
    robot.sending = without(*missing)
    assert robot.goes_on(SILENCE_S - 2 * TICK_S) is None
    halt = robot.goes_on(3 * TICK_S)
    assert halt is not None
    assert halt.kind is kind
    assert halt.reason.startswith(f"{topics}: nothing received in 5 s: publish it, or set bus.")
    robot.sending = STREAMS
    assert robot.goes_on(2 * TICK_S) is None
    assert robot.frames
    robot.sending = without("depth")
    halt = robot.goes_on(SILENCE_S + TICK_S)
    assert halt is not None
    assert halt.reason.startswith(f"{DEPTH}: nothing received")


def test_odometry_by_another_wire_is_not_looked_for_on_the_bus():
    robot = Robot()
    given = BusConfig(), robot.clock, robot.changed, False, FIXED
    robot.streams = SensorStreams(*given, odometry=False)
    robot.sending = without("odom")
    assert robot.goes_on(SILENCE_S + 1.0) is None
    robot.sending = without("odom", "depth")
    halt = robot.goes_on(SILENCE_S + 1.0)
    assert halt is not None
    assert halt.reason.startswith(f"{DEPTH}: nothing received")


def test_intrinsics_that_came_once_suffice():
    robot = Robot()
    assert robot.goes_on(1.0) is None
    robot.sending = without("camera_info")
    assert robot.goes_on(20.0) is None


@pytest.mark.parametrize(
    ("stream", "topic", "payload", "told", "kind"),
    [
        ("color", COLOR, b"\0\1\0\0" + bytes(40), "not a CDR", HaltKind.FRAME),
        ("depth", DEPTH, wire.encode_color(np.zeros((12, 16, 3), np.uint8), 0), "", HaltKind.FRAME),
        ("depth", DEPTH, b"short", "not a stamped CDR message", HaltKind.FRAME),
        (
            "camera_info", INFO, wire.encode_camera_info(Intrinsics(0, 0, 0, 0, 16, 12), 0),
            "K is zero", HaltKind.FRAME,
        ),
        (
            "camera_info", COLOR,
            wire.encode_camera_info(Intrinsics(20.0, 20.0, 16.0, 12.0, 32, 24), 0),
            "image is 16x12 but camera/color/camera_info describes 32x24", HaltKind.FRAME,
        ),
        ("odom", "odom", b"\0\1\0\0" + bytes(40), "not a CDR", HaltKind.ODOMETRY),
    ],
)  # fmt: skip
def test_messages_that_cannot_be_used_are_told_of_when_it_goes_on_and_no_longer(
    stream: str, topic: str, payload: bytes, told: str, kind: HaltKind
):
    robot = Robot()
    images = len(payload) > 20 and stream != "camera_info"  # are matched by their own stamps
    stamp = slice(4, 12) if images else slice(0, 0)

    def bad(seconds: float) -> Halt | None:
        halt = None
        for _ in range(round(seconds / TICK_S)):
            whole = bytearray(payload)
            at_ns = round((robot.clock.now_s() + TICK_S) * S)
            whole[stamp] = wire.encode_camera_info(K, at_ns)[4:12] if stamp.stop else b""
            robot.bytes_of[stream] = bytes(whole)
            halt = robot.goes_on(TICK_S)
        return halt

    assert bad(PATIENCE_S) is None
    halt = bad(PATIENCE_S)
    assert halt is not None
    assert halt.kind is kind
    assert halt.reason.startswith(f"{topic}: ")
    assert told in halt.reason
    assert "\n" not in halt.reason
    robot.bytes_of.clear()
    frames = robot.frames
    assert robot.goes_on(3 * TICK_S) is None
    assert robot.frames > frames


def test_what_is_wrong_now_is_told_and_not_what_was_before_it():
    robot = Robot()
    robot.bytes_of = {"color": b"\0\1\0\0 none"}
    told = robot.goes_on(2 * PATIENCE_S)
    assert told is not None
    assert told.reason.startswith(f"{COLOR}: ")
    robot.bytes_of = {"depth": b"\0\1\0\0 none"}  # mended as the other breaks: no frame between
    assert robot.goes_on(PATIENCE_S / 2) is not None
    told = robot.goes_on(2 * PATIENCE_S)
    assert told is not None
    assert told.reason.startswith(f"{DEPTH}: ")
    robot.bytes_of = {}
    assert robot.goes_on(0.5) is None


def test_damage_now_and_then_is_none():
    robot = Robot()
    for _ in range(10):
        robot.bytes_of["color"] = b"\0\1\0\0 no image"
        assert robot.goes_on(TICK_S) is None
        robot.bytes_of.clear()
        assert robot.goes_on(2 * TICK_S) is None


def test_what_the_robot_may_do_without_holds_nothing():
    robot = Robot()
    robot.sending = (*STREAMS, "scan")
    robot.streams.topics["scan"] = "scan"
    robot.bytes_of["scan"] = b"\0\1\0\0 no scan"
    assert robot.goes_on(10.0) is None


@pytest.mark.parametrize(
    ("off_s", "told"),
    [
        ({"odom": -2.0}, f"odom is 2 s behind {DEPTH} by its stamps: synchronise the clocks"),
        ({"odom": 9.0}, f"s ahead of {DEPTH} by its stamps: synchronise the clocks"),
        ({"color": 0.03}, f"{COLOR} is 0.03 s ahead of {DEPTH} by its stamps: stamp both as one"),
        ({"color": -9.0}, f"{COLOR} is 9 s behind {DEPTH} by its stamps: stamp both as one"),
    ],
)
def test_stamps_that_do_not_fit_are_told_with_how_far_they_are_off(
    off_s: dict[str, float], told: str
):
    robot = Robot()
    robot.off_s |= off_s
    assert robot.goes_on(UNMATCHED_S) is None
    halt = robot.goes_on(4 * TICK_S)
    assert halt is not None
    assert told in halt.reason
    assert robot.frames == 0
    robot.off_s = dict.fromkeys(STREAMS, 0.0)
    assert robot.goes_on(1.0) is None


def test_odometry_with_gaps_is_told_with_the_rate_that_is_right():
    robot = Robot()
    robot.odom_every, robot.off_s["odom"] = 10, 0.03  # of no image's own stamp
    halt = robot.goes_on(UNMATCHED_S + 2.0)
    assert halt is not None
    assert halt.reason == "odom comes 1.00 s apart, at most 0.25 s: publish it at 8 Hz or more"
    robot.odom_every = 1
    assert robot.goes_on(1.0) is None
