"""Which messages belong together."""

import math

from hypothesis import given
from hypothesis import strategies as st

from runtime.core.types import Pose
from runtime.robot.sync import IMAGES_KEPT, RawMessage, Rings, interpolate
from runtime.robot.wire import Stamped

MS = 1_000_000


def rings(lockstep: bool = False) -> Rings:
    return Rings(20 * MS, 250 * MS, lockstep)


def raw(stamp_ms: float, payload: bytes = b"") -> RawMessage:
    return RawMessage(int(stamp_ms * MS), payload, 0.0)


def test_colour_and_depth_pair_within_20_ms_and_wait_for_odometry_on_both_sides() -> None:
    r = rings()
    r.color.append(raw(100))
    r.depth.extend([raw(79), raw(119), raw(140)])
    r.odom.append(raw(90))
    assert r.peek() is None
    r.odom.append(raw(130))
    match = r.take()
    assert match is not None
    assert (match.depth.stamp_ns, match.stamp_ns) == (119 * MS, 119 * MS)
    assert (match.before.stamp_ns, match.after.stamp_ns) == (90 * MS, 130 * MS)
    assert r.take() is None
    assert [x.stamp_ns for x in r.depth] == [140 * MS]


def test_21_ms_are_too_far_apart() -> None:
    r = rings()
    r.color.append(raw(100))
    r.depth.append(raw(121))
    r.odom.extend([raw(90), raw(130)])
    assert r.peek() is None


def test_odometry_that_paused_is_not_interpolated_over() -> None:
    r = rings()
    r.color.append(raw(100))
    r.depth.append(raw(100))
    r.odom.extend([raw(0), raw(251)])
    assert r.peek() is None
    r.odom.append(raw(100))
    assert r.peek() is not None


def test_in_real_time_the_newest_set_wins_and_older_ones_are_forgotten() -> None:
    r = rings()
    for stamp in range(0, 500, 33):
        r.color.append(raw(stamp))
        r.depth.append(raw(stamp + 3))
        r.odom.extend([raw(stamp), raw(stamp + 10)])
    assert len(r.color) == IMAGES_KEPT
    match = r.take()
    assert match is not None
    assert match.color.stamp_ns == 495 * MS
    assert not r.color
    assert not r.depth


def test_in_lockstep_every_set_leaves_in_order_and_stamps_are_equal() -> None:
    r = rings(lockstep=True)
    for stamp in range(50):
        r.color.append(raw(stamp))
        r.depth.append(raw(stamp))
        r.odom.append(raw(stamp))
    r.color.append(raw(60))
    r.depth.append(raw(60.001))
    r.odom.append(raw(60))
    taken = []
    while (match := r.take()) is not None:
        taken.append(match.stamp_ns // MS)
        assert match.before.stamp_ns == match.after.stamp_ns == match.stamp_ns
    assert taken == list(range(50))


@given(
    st.lists(st.integers(0, 400), min_size=1, max_size=10, unique=True),
    st.lists(st.integers(0, 400), min_size=1, max_size=10, unique=True),
    st.lists(st.integers(0, 400), min_size=1, max_size=20, unique=True),
)
def test_a_match_keeps_its_promises(color: list[int], depth: list[int], odom: list[int]) -> None:
    r = rings()
    for ring, stamps in ((r.color, color), (r.depth, depth), (r.odom, odom)):
        ring.extend(raw(stamp) for stamp in stamps)
    while (match := r.take()) is not None:
        assert abs(match.color.stamp_ns - match.depth.stamp_ns) <= 20 * MS
        assert match.before.stamp_ns <= match.stamp_ns <= match.after.stamp_ns
        assert match.after.stamp_ns - match.before.stamp_ns <= 250 * MS
        assert all(left.stamp_ns > match.color.stamp_ns for left in r.color)


@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1), st.integers(0, 1000))
def test_interpolation_stays_between_and_turns_the_shorter_way(a: float, b: float, t: int) -> None:
    before, after = Stamped(0, Pose(0, 5, a)), Stamped(1000, Pose(1, 3, b))
    pose = interpolate(before, after, t)
    assert math.isclose(pose.x_m, t / 1000, abs_tol=1e-9)
    assert math.isclose(pose.y_m, 5 - 2 * t / 1000, abs_tol=1e-9)
    turned = abs(math.remainder(pose.yaw_rad - a, math.tau))
    assert turned <= abs(math.remainder(b - a, math.tau)) + 1e-9
    assert -math.pi < pose.yaw_rad <= math.pi
    if t == 1000:
        assert abs(math.remainder(pose.yaw_rad - b, math.tau)) < 1e-9


def test_a_clock_that_was_set_back_makes_what_came_before_worthless() -> None:
    r = rings()
    for stamp_ms in (10_000, 10_005, 9_995):  # a little late is not set back
        r.file("odom", raw(stamp_ms))
    assert len(r.odom) == 3
    r.file("odom", raw(3))
    assert [one.stamp_ns for one in r.odom] == [3 * MS]
