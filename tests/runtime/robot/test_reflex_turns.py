"""The reflex step by step, in no thread and on a clock that a test sets."""

import threading
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from runtime.config import load
from runtime.core.mapping.near_memory import Nearby
from runtime.core.mapping.near_points import NearPoints
from runtime.core.motion.caution import FREE, Caution
from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import Halt, HaltKind
from runtime.core.types import Intrinsics, Mount, Pose, Scan, Twist
from runtime.errors import ConfigError, SensorError
from runtime.robot import reflex as module
from runtime.robot import wire
from runtime.robot.bounds import check_size
from runtime.robot.images.camera_images import DepthImage
from runtime.robot.images.reading import decode_depth
from runtime.robot.optics import DepthSight
from runtime.robot.reflex import IDLE_S, POSE_S, Reflex, SweptBody, check, swept
from runtime.robot.sync import RawMessage
from runtime.robot.transforms import CameraConfig

BODY = SweptBody(0.2, 1.1, 0.5, 4.0)
CAMERA = Intrinsics(20.0, 20.0, 8.0, 6.0, 16, 12)
HERE, AHEAD = Pose(1.0, 2.0, 0.3), Twist(0.4, 0.1)
LEG = Caution(HaltKind.OBSTACLE, "a leg", 0.0)
NONE = np.zeros((0, 2), np.float32)
SOMETHING = Nearby(5, np.array([[1.5, 2.0]], np.float32), NONE)
IMAGE = np.linspace(0.5, 3.5, 16 * 12, dtype=np.float32).reshape(12, 16)


class Clock:
    """Whoever waits has waited, or somebody came meanwhile."""

    def __init__(self) -> None:
        self.at_s = 100.0
        self.meanwhile: list[Any] = []
        self.waits: list[float] = []

    def now_s(self) -> float:
        return self.at_s

    def wait(self, condition: threading.Condition, until_s: float) -> None:
        condition.notify_all()  # a mistake, where it is not held
        self.waits.append(round(until_s - self.at_s, 6))
        if self.meanwhile:
            self.meanwhile.pop(0)()
        else:
            self.at_s = until_s


class Robot:
    """What a test says that came, and a reflex of it that notes what it asks."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, camera: CameraConfig | None = None) -> None:
        self.clock, self.changed, self.hurried = Clock(), threading.Condition(), 0
        self.newest: RawMessage | None = None
        self.rounds = 0
        self.poses: dict[bool, Pose | None] = {False: HERE, True: HERE}  # by `alone`
        self.optics: Any = (CAMERA, None)
        self.scan: Scan | None = None
        self.asked: list[Any] = []
        self.seen: list[Any] = []
        self.answer = lambda twist: FREE
        body, camera = (BODY, camera or CameraConfig())
        self.reflex = Reflex(self, self.changed, self.clock, body, camera, urgent=self.urgent)
        monkeypatch.setattr(module, "cautioned", self.cautioned)
        monkeypatch.setattr(module, "near_points", self.near_points)

    def urgent(self) -> None:
        self.hurried += 1

    def cautioned(self, twist, pose, near, radius_m, brake_mps2) -> Caution:
        self.asked.append((twist, pose, near, radius_m, brake_mps2))
        return self.answer(twist)

    def near_points(self, depth_m, intrinsics, mount, height_m, max_depth_m) -> NearPoints:
        self.seen.append((depth_m, intrinsics, mount, height_m, max_depth_m))
        points = np.array([[1.0, 0.0, 0.3]], np.float32)
        return NearPoints(points, points[:, 2], np.zeros((0, 3), np.float32))

    def newest_depth(self) -> RawMessage | None:
        self.rounds += 1
        assert self.rounds < 1000  # it goes round without waiting
        return self.newest

    def depth(self, raw: RawMessage) -> DepthImage:
        return DepthImage(decode_depth(raw.payload, "depth").value, 1.0)

    def pose_at(self, stamp_ns: int, alone: bool = False) -> Pose | None:
        assert stamp_ns == 7
        self.rounds += 1
        assert self.rounds < 1000
        return self.poses[alone]

    def sight(self, depth: RawMessage, depth_m: Any) -> DepthSight | None:
        assert depth.stamp_ns == 7
        if isinstance(self.optics, Exception):
            raise self.optics
        if self.optics is None:
            return None
        check_size(depth_m.shape, "depth", self.optics[0], "info")
        return DepthSight(depth_m, *self.optics)

    def near_scan(self, stamp_ns: int) -> Scan | None:
        assert stamp_ns == 7
        return self.scan

    def shows(self, image: Any = IMAGE) -> RawMessage:
        return RawMessage(7, wire.encode_depth(image, 7), self.clock.at_s)


@pytest.fixture
def robot(monkeypatch) -> Robot:
    return Robot(monkeypatch)


def test_before_the_first_image_and_without_odometry_nothing_limits(robot: Robot):
    robot.answer = lambda twist: LEG
    assert robot.reflex.caution(AHEAD, HERE) is FREE
    robot.reflex._near = SOMETHING
    assert robot.reflex.caution(AHEAD, None) is FREE
    assert robot.asked == []


def test_what_is_asked_is_the_command_from_where_the_base_is_against_what_is_near(robot: Robot):
    robot.reflex._near = SOMETHING
    slower = Caution(HaltKind.OBSTACLE, "a leg", 0.2)
    robot.answer = lambda twist: slower
    assert robot.reflex.caution(AHEAD, HERE) is slower
    assert robot.asked == [(AHEAD, HERE, SOMETHING, 0.2, 0.5)]


def test_a_robot_that_was_stopped_from_speed_is_stopped_until_it_must_have_braked(robot: Robot):
    """As fast as it was, it rolls; what it may do at that speed is asked for what is asked now."""
    robot.reflex._near = SOMETHING
    robot.answer = lambda twist: LEG if twist.v_mps > 0.1 else FREE
    assert robot.reflex.caution(AHEAD, HERE) is LEG
    robot.clock.at_s = 100.79
    del robot.asked[:]
    crawl = Twist(0.05, -0.3)
    assert robot.reflex.caution(crawl, HERE) == LEG
    assert [twist for twist, *_ in robot.asked] == [crawl, Twist(0.4, -0.3)]
    assert robot.reflex.caution(Twist(0.0, 0.3), HERE) is FREE  # it is told to stand already
    assert robot.reflex.caution(Twist(-0.1, 0.3), HERE) is FREE
    robot.clock.at_s = 100.0 + 0.4 / 0.5
    assert robot.reflex.caution(crawl, HERE) is FREE
    robot.clock.at_s = 100.5
    assert robot.reflex.caution(crawl, HERE) is FREE  # once it has braked, it has


def test_what_it_may_not_roll_by_it_may_not_crawl_by_either(robot: Robot):
    robot.reflex._near = SOMETHING
    slow = Caution(HaltKind.FLOOR, "a step", 0.05)
    robot.answer = lambda twist: slow if twist.v_mps > 0.1 else FREE
    robot.reflex._braked_mps, robot.reflex._brakes_s = 0.4, 101.0
    told = robot.reflex.caution(Twist(0.05, 0.0), HERE)
    assert told == Caution(HaltKind.FLOOR, "a step", 0.0)


def test_a_way_that_is_free_again_is_driven_though_it_still_rolls(robot: Robot):
    robot.reflex._near = SOMETHING
    robot.answer = lambda twist: LEG
    robot.reflex.caution(AHEAD, HERE)
    robot.answer = lambda twist: FREE
    assert robot.reflex.caution(Twist(0.05, 0.0), HERE) is FREE


def test_it_is_told_zero_from_the_fastest_and_for_as_long_as_that_takes(robot: Robot):
    robot.reflex._near = SOMETHING
    robot.answer = lambda twist: LEG if twist.v_mps > 0.1 else FREE
    crawl = Twist(0.05, 0.0)
    robot.reflex.caution(AHEAD, HERE)
    robot.clock.at_s = 100.5
    robot.reflex.caution(Twist(0.4, 0.0), HERE)  # no faster: its time goes on
    robot.clock.at_s = 100.75
    assert robot.reflex.caution(crawl, HERE) == LEG
    robot.reflex.caution(Twist(0.6, 0.0), HERE)
    del robot.asked[:]
    robot.clock.at_s = 100.75 + 1.19
    assert robot.reflex.caution(crawl, HERE) == LEG
    assert robot.asked[-1][0] == Twist(0.6, 0.0)
    robot.clock.at_s = 100.75 + 1.21
    assert robot.reflex.caution(crawl, HERE) is FREE


def test_a_robot_that_is_stopped_again_from_no_faster_has_braked_no_later(robot: Robot):
    robot.reflex._near = SOMETHING
    robot.answer = lambda twist: LEG if twist.v_mps > 0.1 else FREE
    robot.reflex.caution(AHEAD, HERE)
    robot.clock.at_s = 100.5
    robot.reflex.caution(AHEAD, HERE)
    robot.clock.at_s = 100.81
    assert robot.reflex.caution(Twist(0.05, 0.0), HERE) is FREE


def test_what_slows_without_stopping_is_no_reason_to_brake_to_the_end(robot: Robot):
    robot.reflex._near = SOMETHING
    robot.answer = lambda twist: Caution(HaltKind.OBSTACLE, "a leg", 0.01)
    robot.reflex.caution(AHEAD, HERE)
    robot.answer = lambda twist: LEG if twist.v_mps > 0.1 else FREE
    assert robot.reflex.caution(Twist(0.05, 0.0), HERE) is FREE


def test_a_robot_that_stands_is_not_stopped_from_any_speed(robot: Robot):
    robot.reflex._near = SOMETHING
    robot.answer = lambda twist: LEG
    robot.reflex.caution(STILL, HERE)
    assert robot.reflex._braked_mps == 0.0


# -- an image --------------------------------------------------------------------------------------


def test_an_image_is_held_against_the_command_and_what_has_to_be_slower_is_urgent(robot: Robot):
    robot.answer = lambda twist: LEG
    robot.reflex.caution(AHEAD, HERE)
    robot.reflex.look(robot.shows())
    ((depth_m, intrinsics, mount, height_m, max_depth_m),) = robot.seen
    assert depth_m.shape == IMAGE.shape
    assert (intrinsics, mount, height_m, max_depth_m) == (CAMERA, CameraConfig(), 1.1, 4.0)
    twist, pose, near, *body = robot.asked[-1]
    assert (twist, pose, body) == (AHEAD, HERE, [0.2, 0.5])
    x, y = 1.0 + np.cos(0.3), 2.0 + np.sin(0.3)
    assert near.stamp_ns == 7
    assert near.obstacles == pytest.approx(np.array([[x, y]]))
    assert robot.hurried == 1
    robot.answer = lambda twist: FREE
    robot.reflex.look(robot.shows())
    assert robot.hurried == 1


def test_flying_pixels_are_taken_out_before_anything_is_looked_for(robot: Robot, monkeypatch):
    monkeypatch.setattr(DepthImage, "solid", lambda image: image.depth_m * 2)
    robot.reflex.look(robot.shows())
    assert np.array_equal(robot.seen[0][0], IMAGE * 2)


@pytest.mark.parametrize("what", ["payload", "lens", "no lens", "no pose", "shape"])
def test_an_image_that_cannot_be_used_is_not_looked_at(robot: Robot, what: str):
    image = robot.shows(IMAGE[:, :8] if what == "shape" else IMAGE)
    if what == "payload":
        image = RawMessage(7, b"\x00\x01\x00\x00", 0.0)
    if what == "lens":
        robot.optics = SensorError("tf: no way")
    if what == "no lens":
        robot.optics = None
    if what == "no pose":
        robot.poses = {False: None, True: None}
    robot.reflex.look(image)
    assert (robot.seen, robot.reflex._near) == ([], None)


def test_a_mount_that_tf_tells_is_taken_and_without_it_the_configured_one(robot: Robot):
    told = Mount(z_m=0.5)
    robot.optics = CAMERA, told
    robot.reflex.look(robot.shows())
    assert robot.seen[-1][2] is told
    robot.optics = CAMERA, None
    robot.reflex.look(robot.shows())
    assert robot.seen[-1][2] == CameraConfig()


def test_a_mount_that_the_floor_tells_begins_with_the_configured_one_and_is_kept(monkeypatch):
    camera = CameraConfig(mount="floor", z_m=0.9)
    robot, asked = Robot(monkeypatch, camera), []
    found = [Mount(z_m=0.91), Mount(z_m=0.92), Mount(z_m=0.93)]

    def by_floor(*given: Any) -> Mount:
        asked.append(given)
        return found.pop(0)

    monkeypatch.setattr(module, "mount_by_floor", by_floor)
    for _ in range(3):
        robot.reflex.look(robot.shows())
    assert [given[3] for given in asked] == [camera, Mount(z_m=0.91), Mount(z_m=0.92)]
    assert {(given[1], given[2]) for given in asked} == {(CAMERA, camera)}
    assert asked[0][0].shape == IMAGE.shape
    assert [seen[2] for seen in robot.seen] == [Mount(z_m=0.91), Mount(z_m=0.92), Mount(z_m=0.93)]


def test_another_body_and_camera_are_taken_with_the_next_image(robot: Robot):
    body, camera = SweptBody(0.3, 0.6, 0.7, 3.0), CameraConfig(z_m=0.4)
    robot.reflex.sweeps(body, camera)
    robot.reflex.look(robot.shows())
    assert robot.seen[0][2:] == (camera, 0.6, 3.0)
    robot.reflex.caution(AHEAD, HERE)
    assert robot.asked[-1][3:] == (0.3, 0.7)


def test_what_a_laser_met_is_near_too_but_for_what_is_the_body_itself(robot: Robot):
    ranges = np.array([0.19, 0.21], np.float32)
    robot.scan = Scan((1.0, 2.0), np.array([0.0, 0.0]), ranges)
    robot.reflex.look(robot.shows())
    assert robot.reflex._near is not None
    assert robot.reflex._near.obstacles[1:] == pytest.approx(np.array([[1.21, 2.0]]), abs=1e-6)


def test_odometry_of_an_image_is_waited_for_a_moment(robot: Robot):
    robot.poses[False], robot.poses[True] = None, Pose(9.0, 9.0, 0.0)
    robot.clock.meanwhile = [lambda: setattr(robot.clock, "at_s", 100.02)]
    assert robot.reflex._pose_at(7) == Pose(9.0, 9.0, 0.0)
    assert robot.clock.waits == [POSE_S, 0.03]
    robot.clock.waits.clear()
    robot.clock.meanwhile = [lambda: robot.poses.update({False: HERE})]
    assert robot.reflex._pose_at(7) == HERE
    assert len(robot.clock.waits) == 1
    robot.poses[False] = None
    robot.reflex._closed = True
    assert robot.reflex._pose_at(7) == Pose(9.0, 9.0, 0.0)
    assert len(robot.clock.waits) == 1


# -- what is too old, or shows nothing -----------------------------------------------------------

STALE_S = 0.5  # safety.depth_stale_s


def test_an_image_is_good_for_half_a_second_and_then_nothing_is_driven(robot: Robot):
    assert robot.reflex.doubt() is None  # that none has come yet is told by others
    robot.reflex.look(robot.shows())
    robot.clock.at_s = 100.0 + STALE_S
    assert robot.reflex.doubt() is None
    robot.clock.at_s = 101.25
    told = "depth: the newest image that can be used is 1.2 s old, safety.depth_stale_s is 0.5"
    assert robot.reflex.doubt() == Halt(HaltKind.FRAME, told)


def test_an_image_without_odometry_is_no_image_that_is_missing(robot: Robot):
    robot.reflex.look(robot.shows())
    robot.poses = {False: None, True: None}
    robot.clock.at_s = 101.0
    image = robot.shows()
    robot.reflex.look(image)
    robot.clock.at_s = 101.0 + STALE_S
    assert robot.reflex.doubt() is None
    robot.clock.at_s = 101.0 + STALE_S + 0.001
    assert robot.reflex.doubt() is not None
    robot.poses = {False: HERE, True: HERE}
    robot.reflex.look(image)
    assert robot.reflex._unplaced_s == -np.inf


def test_a_reflex_that_can_look_at_no_image_holds_the_base_with_the_reason(robot: Robot):
    robot.optics = SensorError("tf: no way from base_link to camera")
    robot.reflex.look(robot.shows())
    robot.clock.at_s = 100.0 + STALE_S
    robot.optics = SensorError("tf: none at all")
    robot.reflex.look(robot.shows())
    assert robot.reflex.doubt() is None
    robot.clock.at_s = 100.001 + STALE_S
    assert robot.reflex.doubt() == Halt(HaltKind.FRAME, "tf: none at all")
    robot.optics = CAMERA, None
    robot.reflex.look(robot.shows())
    assert robot.reflex.doubt() is None
    robot.optics = SensorError("tf: no way")
    robot.clock.at_s = 101.0
    robot.reflex.look(robot.shows())
    assert robot.reflex.doubt() is None  # half a second after it could


def test_by_images_that_show_nothing_it_turns_and_does_not_drive(robot: Robot):
    nothing = np.zeros_like(IMAGE)
    robot.reflex.look(robot.shows())
    robot.clock.at_s = 100.0 + STALE_S
    robot.reflex.look(robot.shows(nothing))
    assert robot.reflex.caution(AHEAD, HERE) is FREE  # it saw something just now
    robot.clock.at_s = 100.75
    held = Caution(HaltKind.FRAME, "depth: without a single reading for 0.8 s", 0.0)
    assert robot.reflex.caution(AHEAD, HERE) == held
    assert robot.reflex.doubt() is None
    assert robot.reflex.caution(Twist(0.0, 0.5), HERE) is FREE
    assert robot.reflex.caution(Twist(-0.1, 0.5), HERE) is FREE
    robot.clock.at_s = 100.0 + 2 * STALE_S
    assert robot.reflex.caution(AHEAD, HERE) == replace(
        held, reason="depth: without a single reading for 1.0 s"
    )
    robot.clock.at_s = 100.001 + 2 * STALE_S
    assert robot.reflex.caution(AHEAD, HERE) is FREE
    assert robot.reflex.doubt() is not None  # that is another matter: none comes any more


def test_a_camera_that_never_showed_anything_is_said_to_in_seconds(robot: Robot):
    robot.reflex.look(robot.shows(np.zeros_like(IMAGE)))
    told = robot.reflex.caution(AHEAD, HERE)
    assert told.reason == "depth: without a single reading for 999.0 s"


# -- its thread, run here --------------------------------------------------------------------------


def run(robot: Robot, *events: Any) -> list[RawMessage]:
    """The images that it looks at, while these events come one after the other; then it is
    closed."""
    looked: list[RawMessage] = []
    robot.reflex.look = looked.append  # type: ignore[method-assign]
    robot.clock.meanwhile = [*events, robot.reflex.close]
    robot.reflex._run()
    return looked


def test_each_image_is_looked_at_once_while_somebody_drives(robot: Robot):
    first, second = robot.shows(), robot.shows()
    robot.reflex.caution(AHEAD, HERE)
    comes = lambda image: lambda: setattr(robot, "newest", image)  # noqa: E731
    assert run(robot, comes(first), lambda: None, comes(second)) == [first, second]
    assert set(robot.clock.waits) == {1.0}


def test_without_a_question_for_a_while_nobody_drives_and_nothing_is_looked_at(robot: Robot):
    assert run(robot, lambda: setattr(robot, "newest", robot.shows())) == []
    robot.reflex._closed, robot.newest = False, None
    robot.reflex.caution(AHEAD, HERE)
    robot.clock.at_s += IDLE_S - 0.01
    image = robot.shows()
    assert run(robot, lambda: setattr(robot, "newest", image)) == [image]
    robot.reflex._closed = False
    robot.clock.at_s += 0.01
    robot.newest = None
    assert run(robot, lambda: setattr(robot, "newest", robot.shows())) == []


def test_on_a_clock_that_has_just_begun_nobody_has_asked_and_nothing_rolls(robot: Robot):
    """As a machine's has that was just switched on."""
    robot.clock.at_s = 1.0
    assert run(robot, lambda: setattr(robot, "newest", robot.shows())) == []
    robot.clock.at_s, robot.reflex._near = 1.0, SOMETHING
    slower = Caution(HaltKind.OBSTACLE, "a leg", 0.2)
    robot.answer = lambda twist: slower
    assert robot.reflex.caution(AHEAD, HERE) is slower


def test_one_that_is_closed_looks_at_nothing_more(robot: Robot):
    robot.reflex.caution(AHEAD, HERE)
    robot.newest = robot.shows()
    robot.reflex.close()
    assert run(robot) == []
    assert robot.clock.waits == []


def test_what_ends_it_is_raised_where_it_is_asked(robot: Robot):
    robot.reflex.caution(AHEAD, HERE)
    robot.newest = robot.shows()
    robot.optics = ValueError("mistake")
    robot.reflex._run()
    with pytest.raises(ValueError, match="mistake"):
        robot.reflex.caution(AHEAD, HERE)


def test_its_thread_has_a_name_and_does_not_keep_the_process_alive(robot: Robot):
    thread = robot.reflex._thread
    assert (thread.name, thread.daemon) == ("reflex", True)
    robot.clock.wait = lambda condition, until_s: condition.wait()  # type: ignore[method-assign]
    robot.reflex.start()
    robot.reflex.close()
    assert not thread.is_alive()


def test_its_end_is_waited_for_a_second_at_most(robot: Robot):
    joined: list[float] = []
    thread: Any = SimpleNamespace(
        is_alive=lambda: True, join=lambda timeout: joined.append(timeout)
    )
    robot.reflex._thread = thread
    robot.reflex.close()
    assert joined == [1.0]


# -- what is configured ----------------------------------------------------------------------------


def test_the_body_that_is_swept_is_the_configured_one():
    config = load(
        None,
        ("robot.radius_m=0.21", "robot.height_m=0.8", "control.brake_mps2=0.6",
         "map.max_depth_m=4.5"),
    )  # fmt: skip
    assert swept(config.navigate) == SweptBody(0.21, 0.8, 0.6, 4.5)


def test_a_speed_that_the_camera_does_not_allow_is_refused_in_a_line():
    control = SimpleNamespace(max_speed_mps=2.0, brake_mps2=0.5)
    config: Any = SimpleNamespace(
        control=control,
        robot=SimpleNamespace(radius_m=0.2),
        map=SimpleNamespace(max_depth_m=5.0),
    )
    with pytest.raises(ConfigError) as refused:
        check(config)
    assert str(refused.value) == (
        "control.max_speed_mps: is 2; by depth images up to 0.4 s old, braking with 0.5 m/s^2 "
        "(control.brake_mps2), the robot halts before what steps in front from 1.19 m/s: set that, "
        "or less"
    )
    control.max_speed_mps = module.sure_mps(0.2, 0.5, 5.0)
    check(config)
