"""What is noticed of single messages, to the number."""

import math

import numpy as np
import pytest
from camera_messages import image
from other_half import slam_pose

from runtime.core.motion.courses import STILL
from runtime.core.motion.safety import SafetyConfig
from runtime.core.types import Pose, Twist
from runtime.robot import wire
from runtime.robot.odometry import BaseOdometry
from runtime.robot.sync import RawMessage
from runtime.robot.vigilance import (
    MOVED_RAD,
    STILL_STAMPS,
    TILT_RAD,
    Vigilance,
    _differ,
    _sight,
)

EPOCH_NS = 1_700_000_000_000_000_000  # the robot's clock is another than ours
AHEAD = Twist(0.3, 0.0)
NOISE = np.random.default_rng(5)


class Told:
    """Messages that a test dates and fills by hand."""

    def __init__(self, cfg: SafetyConfig | None = None, slam: bool = False) -> None:
        read = BaseOdometry(slam=slam).read
        self.vigilance, self.slam = Vigilance(cfg or SafetyConfig(), read), slam

    def take(self, stream: str, payload: bytes, now_s: float, stamp_s: float | None = None):
        stamp_ns = round((now_s if stamp_s is None else stamp_s) * 1e9)
        return self.vigilance.take(stream, RawMessage(stamp_ns, payload, now_s), stream)

    def odom(self, pose: Pose, now_s: float, stamp_s: float | None = None, seq: int = 0):
        """`seq`: a bit that makes two messages of one place two."""
        stamp_ns = round((now_s if stamp_s is None else stamp_s) * 1e9)
        encode = slam_pose if self.slam else wire.encode_odometry
        return self.take("odom", encode(pose, stamp_ns) + bytes([seq]), now_s, stamp_s)

    def depth(self, metres: float, now_s: float):
        """Of something at that distance; another is another image."""
        image = np.tile(np.linspace(metres, metres + 4, 40, dtype=np.float32), (30, 1))
        return self.take("depth", wire.encode_depth(image, round(now_s * 1e9)), now_s)

    def color(self, grey: int, now_s: float):
        image = np.full((4, 4, 3), grey, np.uint8)
        return self.take("color", wire.encode_color(image, round(now_s * 1e9)), now_s)

    def doubt(self, now_s: float, sent: Twist = STILL) -> str:
        halt = self.vigilance.doubt(now_s, sent)
        return f"{halt.kind}: {halt.reason}" if halt else ""


ORIGIN = Pose(0.0, 0.0, 0.0)


def lean(roll: float = 0.0, pitch: float = 0.0, norm: float = 1.0) -> bytes:
    """Odometry of a base that leans, by a quaternion of that length."""
    message = wire.decode(wire.encode_odometry(ORIGIN, 0), wire.ODOMETRY, "odom")
    q = message.pose.pose.orientation
    q.x, q.y, q.z = norm * math.sin(roll / 2), norm * math.sin(pitch / 2), 0.0
    q.w = norm * math.cos((roll + pitch) / 2)
    return bytes(wire.encode(message))


def test_stamps_that_are_none_stand_still_though_each_message_was_dated_anew():
    """Whoever dates it has told of that: it is not said twice."""
    said: list[str] = []
    vigilance = Vigilance(SafetyConfig(), tell=said.append)
    none = wire.encode_odometry(Pose(0.0, 0.0, 0.0), 0)
    for n in range(STILL_STAMPS + 1):
        assert vigilance.unstamped == ({"odom"} if n >= STILL_STAMPS else set())
        vigilance.take("odom", RawMessage(EPOCH_NS + n, none, 10.0 + n), "odom")
    assert said == []
    for stamp_ns in (10**9, 10**9 + 2**24):  # of a clock that begins with the robot
        stamped = wire.encode_odometry(Pose(0.0, 0.0, 0.0), stamp_ns)
        for _ in range(STILL_STAMPS):
            vigilance.take("odom", RawMessage(stamp_ns, stamped, 20.0 + stamp_ns / 1e9), "odom")
            assert vigilance.unstamped == set()


def test_what_is_no_stream_of_the_watched_ones_is_left_alone():
    told, raw = Told(), RawMessage(5, b"anything", 1.0)
    assert told.vigilance.take("tf", raw, "tf") is raw
    assert told.doubt(1.0) == ""


def test_a_message_is_dated_by_how_late_it_is():
    told = Told()
    assert told.odom(ORIGIN, 10.0, 4.0).arrival_s == 10.0
    late = told.odom(ORIGIN, 10.25, 4.125)
    assert (late.arrival_s, late.stamp_ns) == (10.125, 4_125_000_000)
    assert told.vigilance.unstamped == set()


def test_what_comes_late_is_said_of_each_stream_and_what_does_not_come_is_not():
    cfg = SafetyConfig(odom_stale_s=0.5, frame_stale_s=1.0)
    told = Told(cfg)
    told.odom(ORIGIN, 10.0, 4.0)
    told.odom(ORIGIN, 11.0, 4.5, 1)  # as late as it may be
    assert told.doubt(11.0) == ""
    told.odom(ORIGIN, 12.0, 5.25)
    assert told.doubt(12.0) == "odometry: odom comes 0.8 s late by its stamps"
    assert told.doubt(12.5) != ""
    assert told.doubt(12.501) == ""  # nothing came since: somebody else's affair
    for stream, send in (("depth", told.depth), ("color", told.color)):
        fresh = Told(cfg)
        fresh.odom(ORIGIN, 10.0)
        payload = send(2, 10.0).payload
        fresh.take(stream, payload, 11.0, 10.0)
        assert fresh.doubt(11.0) == ""
        fresh.take(stream, payload, 12.0, 10.75)
        assert fresh.doubt(12.0) == f"frame: {stream} comes 1.2 s late by its stamps"
        assert fresh.doubt(13.0) != ""
        assert fresh.doubt(13.001) == ""


def test_a_jump_is_how_far_two_messages_are_apart_and_is_doubted_for_half_a_second():
    for slam in (False, True):
        told = Told(slam=slam)
        told.odom(Pose(5.0, -7.0, 2.0), 10.0)
        told.odom(Pose(5.1, -7.1, 2.2), 10.05)
        assert told.doubt(10.05) == ""
        told.odom(Pose(5.4, -6.7, 2.7), 10.25)
        said = "jump: odometry jumped by 0.50 m, 0.50 rad"
        assert (told.doubt(10.25), told.doubt(10.75), told.doubt(10.7501)) == (said, said, "")
    for to in (Pose(5.0, -6.5, 2.0), Pose(4.5, -7.0, 2.0), Pose(5.0, -7.0, 1.0)):
        told = Told()
        told.odom(Pose(5.0, -7.0, 2.0), 10.0)
        told.odom(to, 10.05)
        assert told.doubt(10.05).startswith("jump: ")


def test_as_far_as_odometry_may_go_is_no_jump():
    told = Told(SafetyConfig(odom_jump_m=0.5))
    told.odom(ORIGIN, 10.0)
    told.odom(Pose(0.5, 0.0, 0.0), 10.05)
    assert told.doubt(10.05) == ""


def test_a_clock_that_goes_back_is_said_with_how_far_and_one_that_stands_is_not():
    told = Told()
    told.odom(ORIGIN, 10.0, 4.0)
    told.odom(ORIGIN, 10.05, 4.0, 1)
    assert told.doubt(10.05) == ""
    told.odom(ORIGIN, 10.1, 2.5)
    assert told.doubt(10.1) == "clock: odometry's clock went back by 1.50 s"
    told = Told()
    told.odom(ORIGIN, 10.0, 30_000_000.0)
    told.odom(ORIGIN, 10.05, 10_000_000.0)
    assert told.doubt(10.05) == "clock: odometry's clock went back by 20000000.00 s"


def test_of_what_was_noticed_the_last_is_told():
    told = Told()
    told.odom(ORIGIN, 10.0)
    told.odom(Pose(2.0, 0.0, 0.0), 10.25)
    told.take("odom", lean(pitch=0.5), 10.5)
    told.odom(ORIGIN, 10.5, 3.0)
    assert told.doubt(10.5).startswith(("jump: ", "tilt: ", "clock: "))
    told.odom(Pose(2.0, 0.0, 0.0), 10.75, 3.1)
    assert told.doubt(10.75).startswith("jump: ")


@pytest.mark.parametrize(
    ("payload", "said"),
    [
        (lean(pitch=0.34), ""),
        (lean(pitch=0.36), "tilt: the base leans by 21 degrees"),
        (lean(roll=0.34), ""),
        (lean(roll=-0.4), "tilt: the base leans by 23 degrees"),
        (lean(roll=0.4, norm=1.005), "tilt: the base leans by 23 degrees"),
        (lean(roll=0.34, norm=1.005), ""),
        (lean(pitch=3.0), "tilt: the base leans by 172 degrees"),
    ],
)
def test_how_far_it_may_lean_whichever_way(payload: bytes, said: str):
    told = Told()
    told.take("odom", payload, 10.0)
    assert told.doubt(10.0) == said


def test_the_area_is_round_where_it_began():
    told = Told(SafetyConfig(area_m=1.0))
    told.odom(Pose(5.0, 5.0, 0.0), 10.0)
    told.odom(Pose(5.25, 5.0, 0.0), 10.1)
    told.odom(Pose(5.25, 5.25, 0.0), 10.2)
    told.odom(Pose(5.5, 5.25, 0.0), 10.3)
    told.odom(Pose(5.75, 5.25, 0.0), 10.4)
    told.odom(Pose(5.75, 5.0, 0.0), 10.5)
    told.odom(Pose(6.0, 5.0, 0.0), 10.6)  # just there
    assert told.doubt(10.6) == ""
    told.odom(Pose(6.0, 4.75, 0.0), 10.7)
    said = "area: 1.0 m from where it began, 1 m are its area: bring it back"
    assert told.doubt(10.7) == said


def frozen(now_s: float = 10.5, to: Pose = Pose(0.1, 0.0, 0.0), **left_out: bool) -> str:  # noqa: B008 -- a value
    """What is said at `now_s` of depth that came at 10 s and again at 10.3, while colour lived and
    odometry told of another place; but for what is left out."""
    told = Told()
    if "place" not in left_out:
        told.odom(ORIGIN, 9.9)
    told.color(1, 9.9)
    told.depth(2.0, 10.0)
    if "moved" not in left_out:
        told.odom(to, 10.2)
    if "colour" not in left_out:
        told.color(2, 10.02)  # of the same moment
        told.color(2 if "alive" in left_out else 3, 10.25)
    if "again" not in left_out:
        told.depth(2.0, 10.3)
    return told.doubt(now_s)


def test_depth_repeats_itself_when_all_says_that_it_should_not():
    assert frozen() == "frame: depth repeats itself for 0.5 s, while colour lives"
    assert frozen(11.0) == "frame: depth repeats itself for 1.0 s, while colour lives"
    assert frozen(10.49) == ""
    for what in ("place", "moved", "colour", "alive", "again"):
        assert frozen(**{what: True}) == ""


@pytest.mark.parametrize(
    ("to", "held"),
    [
        (Pose(0.09, 0.0, 0.0), False),
        (Pose(0.0, -0.1, 0.0), True),
        (Pose(0.06, 0.06, 0.09), False),
        (Pose(0.0, 0.0, 0.11), True),
        (Pose(0.0, 0.0, -0.11), True),
    ],
)
def test_depth_may_repeat_itself_where_the_base_has_hardly_moved(to: Pose, held: bool):
    assert bool(frozen(to=to)) is held


def test_depth_is_held_against_where_the_base_was_when_it_changed():
    told = Told()
    told.odom(Pose(2.0, 3.0, 1.0), 9.8)
    told.depth(2.0, 9.9)
    told.odom(Pose(2.2, 3.2, 1.2), 9.95)
    told.depth(3.0, 10.0)  # another: from here on
    told.color(1, 10.0)
    told.color(2, 10.1)
    told.depth(3.0, 10.2)
    assert told.doubt(11.0) == ""
    told.odom(Pose(2.2, 3.301, 1.2), 10.3)
    assert told.doubt(11.0).startswith("frame: depth repeats")


@pytest.mark.parametrize("back_s", [0.0, 3600.0])
def test_a_jump_moves_where_depth_is_held_against_whatever_the_clock_says(back_s: float):
    told = Told(SafetyConfig(odom_jump_m=0.3))
    told.odom(ORIGIN, 9.9)
    told.depth(2.0, 10.0)
    told.color(1, 10.0)
    told.color(2, 10.1)
    told.depth(2.0, 10.2)
    told.odom(Pose(1.0, 0.0, 0.0), 10.3, 10.3 - back_s)
    assert told.doubt(11.0) == ""
    told.odom(Pose(1.1, 0.0, 0.0), 10.4, 10.4 - back_s)
    assert told.doubt(11.0).startswith("frame: depth repeats")


def stuck(sent: Twist = AHEAD, told_s: float = 10.0, **left_out: bool) -> Told:
    """Odometry that came at 9.5 s and again at 10.6; the base told to move from `told_s` on; the
    camera saw one thing at 9.9 s and another at 10.5."""
    told = Told()
    told.odom(ORIGIN, 9.5)
    told.depth(2.0, 9.9)
    told.doubt(told_s, sent)
    if "another" not in left_out:
        told.depth(4.0, 10.5)
    told.odom(ORIGIN, 10.6, seq=int("changed" in left_out))
    return told


def test_odometry_repeats_itself_when_all_says_that_it_should_not():
    said = "odometry: odometry repeats itself for {} s, while the camera moves"
    assert stuck().doubt(10.5) == said.format("1.0")
    assert stuck().doubt(11.5) == said.format("2.0")
    assert stuck(told_s=10.25).doubt(10.7499) == ""
    assert stuck(told_s=10.25).doubt(10.75) == said.format("1.2")
    assert stuck(another=True).doubt(11.0) == ""
    assert stuck(changed=True).doubt(11.0) == ""
    assert stuck(told_s=10.5).doubt(11.0) != ""  # it saw it just when it was told
    assert stuck(told_s=10.51).doubt(12.0) == ""  # what it saw before tells nothing


@pytest.mark.parametrize(
    ("sent", "held"),
    [
        (Twist(0.05, 0.0), True),
        (Twist(-0.05, 0.0), True),
        (Twist(0.049, 0.099), False),
        (Twist(0.0, 0.1), True),
        (Twist(0.0, -0.1), True),
        (STILL, False),
    ],
)
def test_told_less_than_that_a_base_may_stand(sent: Twist, held: bool):
    assert bool(stuck(sent).doubt(11.0)) is held


def test_it_is_told_to_move_from_the_first_time_on():
    told = stuck(told_s=10.0)
    told.doubt(10.4, AHEAD)
    assert told.doubt(10.5) != ""


def test_odometry_is_tried_again_ten_seconds_after_the_camera_saw_something_else():
    told = stuck()
    assert told.doubt(20.5) != ""
    assert told.doubt(20.51) == ""
    assert told.doubt(20.52) == ""
    told.depth(6.0, 21.0)  # all begins anew: what it sees, and when it is told
    told.depth(8.0, 21.1)
    assert told.doubt(22.0) == ""
    told.doubt(22.0, AHEAD)
    told.depth(3.0, 22.25)
    assert told.doubt(22.4) == ""
    assert told.doubt(22.5).startswith("odometry: odometry repeats itself")


def test_a_sight_is_some_readings_of_an_image_whatever_its_bytes():
    head = b"\x00\x01\x00\x00 ... 32FC1\0\0 ...".ljust(200, b"\0")
    readings = np.arange(1, 6001, dtype=np.float32)
    readings[3], readings[6] = np.nan, np.inf
    sight = _sight(head + b"\7\7\7" + readings.tobytes())
    assert sight.dtype == np.float32
    assert len(sight) == 2000
    assert sight[:4].tolist() == [1.0, 0.0, 0.0, 10.0]
    short = np.arange(1, 1501, dtype=np.uint16)
    whole = _sight(bytes(200) + b"\7" + short.tobytes())
    assert whole.tolist() == short.tolist()
    assert _sight(bytes(150)).size == 0
    late = bytes(196) + b"32FC1" + bytes(7)  # beyond where an encoding stands
    assert _sight(late).size == 4


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize(("encoding", "kind"), [("16UC1", "u2"), ("16SC1", "i2"), ("32FC1", "f4")])
def test_a_sight_is_of_the_numbers_that_the_camera_sent(encoding: str, kind: str, big: bool):
    readings = np.arange(1000, 1600, dtype=np.dtype(kind).newbyteorder(">" if big else "<"))
    sight = _sight(image(encoding, (30, 20), readings.tobytes(), big=big)).tolist()
    assert len(sight) > 500  # the first are taken for the head
    assert sight == list(range(1000, 1600))[-len(sight) :]


def test_two_sights_differ_by_a_twentieth_in_a_quarter_of_what_both_see():
    before = np.full(16, 100.0, np.float32)

    def now(count: int, value: float) -> np.ndarray:
        changed = before.copy()
        changed[:count] = value
        return changed

    assert not _differ(before, now(4, 106.0))
    assert _differ(before, now(5, 106.0))
    assert _differ(before, now(5, 94.0))
    assert not _differ(before, now(16, 105.0))
    assert not _differ(before, now(8, 0.0))
    assert not _differ(now(8, 0.0), before)
    assert _differ(before, before[:8])
    partly = now(5, 200.0)
    partly[5:] = 0.0  # only those five are seen in both
    assert _differ(before, partly)
    near = np.full(16, 0.5, np.float32)  # m
    assert _differ(near, near + np.float32(0.4))
    nothing = np.zeros(16, np.float32)
    assert not _differ(nothing, before)


def test_an_image_without_a_difference_in_it_tells_no_place():
    for flat in (np.zeros((30, 40), np.float32), np.full((30, 40), 2.0, np.float32)):
        told = Told()
        told.odom(ORIGIN, 9.9)
        payload = wire.encode_depth(flat, 0)
        told.take("depth", payload, 10.0)
        told.odom(Pose(0.2, 0.0, 0.0), 10.1)
        told.color(1, 10.2)
        told.color(2, 10.25)
        told.take("depth", payload, 10.3)
        assert told.doubt(11.0) == ""


def test_an_image_without_readings_is_no_mistake_and_no_place():
    told = Told()
    told.odom(ORIGIN, 9.9)
    told.take("depth", bytes(150), 10.0)
    told.odom(Pose(0.2, 0.0, 0.0), 10.1)
    told.color(1, 10.2)
    told.color(2, 10.25)
    told.take("depth", bytes(150), 10.3)
    assert told.doubt(11.0) == ""


def test_just_as_much_as_is_allowed_is_no_jump_no_tilt_and_a_move():
    """By odometry that is told to the bit, as none is by a quaternion."""
    told, pose, tilt_rad = Told(SafetyConfig(odom_jump_rad=0.5)), ORIGIN, 0.0
    told.vigilance.read = lambda raw: (wire.Stamped(raw.stamp_ns, pose), tilt_rad)
    told.take("odom", bytes(20), 10.0)
    told.color(1, 10.0)
    told.depth(2.0, 10.0)
    told.color(2, 10.1)
    told.color(3, 10.1)
    told.depth(2.0, 10.1)
    pose, tilt_rad = Pose(0.0, 0.0, 0.5), TILT_RAD
    told.take("odom", bytes(20), 10.2)
    assert told.doubt(10.2) == ""
    pose, tilt_rad = Pose(0.0, 0.0, MOVED_RAD), 0.0
    told.take("odom", bytes(20), 10.3)
    assert told.doubt(10.5).startswith("frame: depth repeats")


def test_a_message_of_colour_with_nothing_in_it_is_no_sign_of_life():
    told = Told()
    told.odom(ORIGIN, 9.9)
    told.depth(2.0, 10.0)
    told.odom(Pose(0.1, 0.0, 0.0), 10.1)
    told.color(1, 10.1)
    told.take("color", b"", 10.2)
    told.depth(2.0, 10.3)
    assert told.doubt(11.0) == ""


def test_odometry_is_as_late_as_is_beyond_the_least_delay_of_its_own_last_ten_seconds():
    told = Told()
    told.odom(ORIGIN, 16.0, 1.0)
    told.odom(ORIGIN, 18.0, 2.0, 1)
    assert told.odom(ORIGIN, 26.5, 10.0, 2).arrival_s == 26.0  # not by what came 10.5 s before


def test_four_messages_after_a_stamp_that_have_the_same_are_not_yet_unstamped_and_five_are():
    told = Told()
    for n in range(STILL_STAMPS):
        told.odom(ORIGIN, 10.0 + n, 4.0)
        assert told.vigilance.unstamped == set()
    told.odom(ORIGIN, 20.0, 4.0)
    assert told.vigilance.unstamped == {"odom"}


def test_where_odometry_is_found_after_it_stood_still_is_where_depth_is_held_against():
    told = stuck()
    told.odom(Pose(0.2, 0.0, 0.0), 10.7)
    told.color(1, 10.75)
    told.color(2, 10.8)
    told.depth(4.0, 10.9)
    assert told.doubt(11.1) == ""
    told.odom(Pose(0.29, 0.0, 0.0), 11.2)
    assert told.doubt(11.2) == ""
    told.odom(Pose(0.31, 0.0, 0.0), 11.3)
    assert told.doubt(11.3).startswith("frame: depth repeats")


def test_of_a_small_compressed_image_every_reading_is_looked_at():
    told = Told()
    told.vigilance = Vigilance(SafetyConfig(), BaseOdometry().read, packed=True)
    told.odom(ORIGIN, 9.9)
    image = np.array([[0.0, 2.0, 0.0, 3.0]], np.float32)  # every other shows nothing
    for now_s in (10.0, 10.3):
        told.take("depth", bytes(30), now_s)
        told.vigilance.looked(image, now_s)
    told.color(1, 10.0)
    told.color(2, 10.1)
    told.odom(Pose(0.2, 0.0, 0.0), 10.4)
    assert told.doubt(11.0).startswith("frame: depth repeats")
