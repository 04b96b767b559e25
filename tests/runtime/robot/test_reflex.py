"""The thread that holds every depth image against the command."""

import threading
import time
from contextlib import contextmanager

import numpy as np
import pytest
from manual_clock import ManualClock

from runtime.clock import SystemClock
from runtime.config import load
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.safety import Halt, HaltKind
from runtime.core.types import Intrinsics, Mount, Pose, Scan, Twist
from runtime.errors import ConfigError, SensorError
from runtime.robot import wire
from runtime.robot.bounds import check_size
from runtime.robot.images.camera_images import DepthImage
from runtime.robot.images.reading import decode_depth
from runtime.robot.optics import DepthSight
from runtime.robot.reflex import POSE_S, Reflex, SweptBody
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import CameraConfig

CAMERA = Intrinsics(262.0, 262.0, 160.0, 120.0, 320, 240)
BODY = SweptBody(0.18, 1.0, 0.5, 5.0)
HERE, AHEAD = Pose(0.0, 0.0, 0.0), Twist(0.4, 0.0)
FREE_VIEW = np.full((240, 320), 4.0, np.float32)
BLOCKED = FREE_VIEW.copy()
BLOCKED[60:180, 120:200] = 0.18
PATIENCE_S = 20.0


class Streams:
    """What a test says that came."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.newest: RawMessage | None = None
        self.pose: Pose | None = HERE
        self.alone = False  # the odometry after the image does not come
        self.mount: Mount | SensorError | None = None
        self.intrinsics: Intrinsics | None = CAMERA
        self.scan: Scan | None = None
        self.clock = SystemClock()
        self._count = 0

    def newest_depth(self):
        return self.newest

    def depth(self, raw):
        return DepthImage(decode_depth(raw.payload, "depth").value, 1.0)

    def pose_at(self, stamp_ns, alone=False):
        return None if self.alone and not alone else self.pose

    def sight(self, depth, depth_m):
        if isinstance(self.mount, SensorError):
            raise self.mount
        if self.intrinsics is None:
            return None
        check_size(depth_m.shape, "depth", self.intrinsics, "info")
        return DepthSight(depth_m, self.intrinsics, self.mount)

    def near_scan(self, stamp_ns):
        return self.scan

    def show(self, depth_m):
        self.send(wire.encode_depth(depth_m, self._count + 1))

    def send(self, payload):
        with self.changed:
            self._count += 1
            self.newest = RawMessage(self._count, payload, self.clock.now_s())
            self.changed.notify_all()


@contextmanager
def reflex(streams, camera=CameraConfig(), urgent=lambda: None):  # noqa: B008 -- a value
    made = Reflex(streams, streams.changed, SystemClock(), BODY, camera, urgent=urgent)
    made.start()
    try:
        made.caution(AHEAD, HERE)  # somebody drives
        yield made
    finally:
        made.close()


def until(holds):
    end_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end_s
        time.sleep(0.005)


def test_what_stands_in_front_holds_from_the_first_image_and_lets_go_with_the_next_free_one():
    streams, hurried = Streams(), threading.Event()
    with reflex(streams, urgent=hurried.set) as made:
        assert made.caution(AHEAD, HERE) == FREE
        streams.show(BLOCKED)
        until(lambda: made.caution(AHEAD, HERE) != FREE)
        held = made.caution(AHEAD, HERE)
        assert held.kind is HaltKind.OBSTACLE
        assert held.allowed(AHEAD) == Twist(0.0, 0.0)
        until(hurried.is_set)  # by who is asked to drive on: before anything else is asked
        assert made.caution(Twist(0.0, 1.0), HERE) == FREE
        streams.show(FREE_VIEW)
        until(lambda: made.caution(AHEAD, HERE) == FREE)


def test_it_is_asked_from_where_the_base_is_by_now():
    streams = Streams()
    with reflex(streams) as made:
        streams.show(np.where(BLOCKED < 1, 0.7, FREE_VIEW).astype(np.float32))
        until(lambda: made.caution(AHEAD, Pose(0.5, 0.0, 0.0)) != FREE)
        assert made.caution(AHEAD, HERE) == FREE
        assert made.caution(AHEAD, Pose(0.5, 0.0, 3.0)) == FREE
        assert made.caution(AHEAD, None) == FREE


def test_a_robot_that_is_stopped_from_speed_brakes_to_the_end():
    """Told zero it rolls on for a while; what it may crawl by meanwhile, it may not roll by."""
    streams, clock = Streams(), ManualClock()
    made = Reflex(streams, streams.changed, clock, BODY)
    made.start()
    try:
        crawl = Twist(0.05, 0.0)
        made.caution(AHEAD, HERE)
        streams.show(np.where(BLOCKED < 1, 0.32, FREE_VIEW).astype(np.float32))
        until(lambda: made.caution(crawl, HERE) is not None and made.caution(AHEAD, HERE) != FREE)
        assert made.caution(AHEAD, HERE).most_mps == 0.0
        assert made.caution(crawl, HERE).allowed(crawl) == Twist(0.0, 0.0)
        clock.advance(AHEAD.v_mps / BODY.brake_mps2)
        assert made.caution(crawl, HERE).allowed(crawl) == crawl
    finally:
        made.close()


def test_late_odometry_is_replaced_by_the_newest():
    streams = Streams()
    streams.alone = True
    with reflex(streams) as made:
        streams.show(BLOCKED)
        until(lambda: made.caution(AHEAD, HERE) != FREE)


@pytest.mark.parametrize("what", ["payload", "shape", "tf", "intrinsics", "odometry"])
def test_an_image_that_cannot_be_used_changes_nothing(what):
    streams = Streams()
    with reflex(streams) as made:
        streams.show(BLOCKED)
        until(lambda: made.caution(AHEAD, HERE) != FREE)
        streams.mount = SensorError("tf: no way") if what == "tf" else None
        streams.intrinsics = None if what == "intrinsics" else CAMERA
        streams.pose = None if what == "odometry" else HERE
        if what == "payload":
            streams.send(b"\x00\x01\x00\x00nothing")
        else:
            streams.show(FREE_VIEW[:100] if what == "shape" else FREE_VIEW)
        time.sleep(0.3)  # there is nothing to wait for
        assert made.caution(AHEAD, HERE) != FREE
        streams.mount, streams.intrinsics, streams.pose = None, CAMERA, HERE
        streams.show(FREE_VIEW)
        until(lambda: made.caution(AHEAD, HERE) == FREE)


@contextmanager
def timed(streams):
    """A reflex by a clock that is set by hand, and has looked at one image."""
    streams.clock = clock = ManualClock(100.0)
    made = Reflex(streams, streams.changed, clock, BODY, stale_s=0.5)
    made.start()
    try:
        made.caution(AHEAD, HERE)
        assert made.doubt() is None  # that no image has come is told by whoever waits for a frame
        streams.show(BLOCKED)
        until(lambda: made.caution(AHEAD, HERE) != FREE)
        yield made, clock
    finally:
        made.close()


def test_what_was_looked_at_too_long_ago_holds_the_base_until_there_is_another_image():
    streams = Streams()
    with timed(streams) as (made, clock):
        clock.advance(0.5)
        assert made.doubt() is None
        clock.advance(0.1)
        what = "depth: the newest image that can be used is 0.6 s old"
        assert made.doubt() == Halt(HaltKind.FRAME, f"{what}, safety.depth_stale_s is 0.5")
        streams.show(FREE_VIEW)
        until(lambda: made.doubt() is None)


def test_an_image_that_is_late_by_its_stamp_is_as_old_as_that():
    streams = Streams()
    with timed(streams) as (made, clock):
        with streams.changed:
            late = wire.encode_depth(FREE_VIEW, 2)
            streams.newest = RawMessage(2, late, clock.now_s() - 0.7)  # as vigilance dates it
            streams.changed.notify_all()
        until(lambda: made.doubt() is not None)
        assert "is 0.7 s old" in made.doubt().reason


@pytest.mark.parametrize("what", ["payload", "shape", "tf", "intrinsics"])
def test_images_that_cannot_be_used_make_nothing_newer(what):
    streams = Streams()
    with timed(streams) as (made, clock):
        streams.mount = SensorError("tf: no way") if what == "tf" else None
        streams.intrinsics = None if what == "intrinsics" else CAMERA
        clock.advance(0.6)
        made.caution(AHEAD, HERE)
        if what == "payload":
            streams.send(b"\x00\x01\x00\x00nothing")
        else:
            streams.show(FREE_VIEW[:100] if what == "shape" else FREE_VIEW)
        time.sleep(0.3)  # there is nothing to wait for
        assert made.doubt() is not None


def test_images_without_a_reading_are_not_driven_by_but_turned_away_from():
    """Whatever stands there, it may be too near to be seen."""
    streams = Streams()
    with timed(streams) as (made, clock):
        for _ in range(3):
            clock.advance(0.2)
            made.caution(AHEAD, HERE)
            streams.show(np.zeros_like(FREE_VIEW))
        until(lambda: made.doubt() is None)
        blind = made.caution(AHEAD, HERE)
        assert blind == Caution(HaltKind.FRAME, "depth: without a single reading for 0.6 s", 0.0)
        assert made.caution(Twist(0.0, 0.5), HERE) == FREE
        streams.show(FREE_VIEW)
        until(lambda: made.caution(AHEAD, HERE) == FREE)
        clock.advance(0.6)
        assert made.doubt() is not None  # no image at all is another thing


def test_images_without_odometry_are_told_of_by_who_waits_for_odometry():
    streams = Streams()
    with timed(streams) as (made, clock):
        streams.pose = None
        clock.advance(0.6)
        made.caution(AHEAD, HERE)
        assert made.doubt() is not None
        streams.show(FREE_VIEW)
        until(lambda: clock.advance(POSE_S) or made.doubt() is None)  # it waits for odometry


def test_the_mount_is_as_configured_or_as_tf_says():
    """A camera that looks up sees what is higher than the body."""
    streams = Streams()
    up = CameraConfig(pitch_rad=-0.9)
    with reflex(streams, up) as made:
        streams.show(np.full_like(FREE_VIEW, 0.6))
        streams.mount = Mount()
        streams.show(BLOCKED)
        until(lambda: made.caution(AHEAD, HERE) != FREE)


def test_a_goal_may_bring_another_body_and_camera():
    streams = Streams()
    with reflex(streams) as made:
        made.sweeps(SweptBody(0.18, 0.5, 0.5, 5.0), CameraConfig(z_m=1.4))
        streams.show(BLOCKED)  # higher than that body
        streams.show(np.where(BLOCKED < 1, 0.18, 3.9).astype(np.float32))
        time.sleep(0.3)  # there is nothing to wait for
        assert made.caution(AHEAD, HERE) == FREE
        made.sweeps(BODY, CameraConfig())
        streams.show(BLOCKED)
        until(lambda: made.caution(AHEAD, HERE) != FREE)


def test_what_a_laser_met_holds_too():
    streams = Streams()
    with reflex(streams) as made:
        streams.scan = Scan((0.0, 0.0), np.array([0.0, 0.1]), np.array([0.3, 0.3], np.float32))
        streams.show(FREE_VIEW)
        until(lambda: made.caution(AHEAD, HERE) != FREE)
        streams.scan = Scan((0.0, 0.0), np.array([0.0, 0.1]), np.array([3.0, 3.0], np.float32))
        streams.show(FREE_VIEW)
        until(lambda: made.caution(AHEAD, HERE) == FREE)


def test_what_ends_it_is_raised_where_it_is_asked():
    streams = Streams()
    with reflex(streams) as made:
        streams.sight = lambda depth, depth_m: 1 / 0
        streams.show(BLOCKED)

        def raised():
            try:
                made.caution(AHEAD, HERE)
            except ZeroDivisionError:
                return True
            return False

        until(raised)


def test_a_speed_that_the_camera_does_not_allow_is_refused_with_the_one_that_it_does():
    with pytest.raises(ConfigError, match=r"control.max_speed_mps: is 2; .* from 1\.2 m/s: set"):
        load(None, ("control.max_speed_mps=2.0",))
    load(None, ("control.max_speed_mps=1.2",))
    with pytest.raises(ConfigError, match=r"braking with 0.1 m/s\^2"):
        load(None, ("control.max_speed_mps=1.2", "control.brake_mps2=0.1"))
