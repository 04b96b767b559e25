"""One clock for all streams: stamps that are none, or of another clock."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.robot.stamps import WINDOW_S, StampAge, StreamClocks
from runtime.robot.sync import RawMessage

EPOCH_S = 1_700_000_000.0


class Robot:
    """Odometry 20 times and images 10 times a second; `clocks`: what each stream's stamps are
    ahead of the time of day, None for one that stamps nothing."""

    def __init__(self, **clocks: float | None) -> None:
        self.lines: list[str] = []
        self.clocks = {"odom": 0.0, "depth": 0.0, "color": 0.0} | clocks
        self.delay_s = {"odom": 0.002, "depth": 0.03, "color": 0.05}
        self.streams = StreamClocks(self.lines.append)
        self.now_s = 10.0

    def put(self, stream: str, taken_s: float) -> float:
        """When it was taken, by the stamp that it is given."""
        ahead_s = self.clocks[stream]
        stamp_ns = 0 if ahead_s is None else round((EPOCH_S + taken_s + ahead_s) * 1e9)
        raw = RawMessage(stamp_ns, b"", taken_s + self.delay_s[stream])
        return self.streams.restamped(stream, raw, stream).stamp_ns / 1e9 - EPOCH_S

    def live(self, seconds: float = 2.0) -> dict[str, float]:
        """By how much each stream's last stamp is off."""
        off = {}
        for n in range(round(seconds * 20)):
            self.now_s += 0.05
            streams = self.clocks if n % 2 else ("odom",)
            off |= {stream: self.put(stream, self.now_s) - self.now_s for stream in streams}
        return off


def test_stamps_of_one_clock_are_left_alone():
    robot = Robot()
    assert robot.live() == pytest.approx({"odom": 0, "depth": 0, "color": 0}, abs=1e-6)
    assert robot.lines == []


def test_a_clock_a_little_off_is_late_or_early_and_not_another():
    robot = Robot(depth=-2.5, color=-2.5)
    off = robot.live()
    assert off["depth"] == pytest.approx(-2.5, abs=1e-6)  # whoever judges lateness has to see it
    assert robot.lines == []


@pytest.mark.parametrize("ahead_s", [-EPOCH_S + 3.0, 3600.0, -86_400.0])
def test_images_by_another_clock_are_taken_to_odometry_s(ahead_s: float):
    robot = Robot(depth=ahead_s, color=ahead_s)
    off = robot.live()
    assert off["depth"] == pytest.approx(0.03 - 0.002, abs=1e-5)  # what arrivals differ by
    assert off["color"] == pytest.approx(off["depth"], abs=1e-5)  # they stay a pair
    assert len(robot.lines) == 2
    assert robot.lines[0].endswith("synchronise the clocks")


def test_two_cameras_with_clocks_of_their_own_are_both_taken_to_odometry_s():
    off = Robot(depth=3600.0, color=-3600.0).live()
    assert off["depth"] == pytest.approx(0.028, abs=1e-5)
    assert off["color"] == pytest.approx(0.048, abs=1e-5)


def test_without_stamps_arrival_counts_and_that_is_said_once():
    robot = Robot(depth=None, color=None)
    off = robot.live()
    assert off["depth"] == pytest.approx(0.028, abs=1e-5)
    assert off["color"] == pytest.approx(0.048, abs=1e-5)
    assert robot.lines == [
        f"{stream}: header.stamp is 0: arrival is taken; let the driver fill it"
        for stream in ("depth", "color")
    ]
    assert robot.streams.unstamped == {"depth", "color"}


def test_where_nobody_stamps_all_are_by_arrival():
    robot = Robot(odom=None, depth=None, color=None)
    off = robot.live()
    assert off["depth"] - off["odom"] == pytest.approx(0.028, abs=1e-5)


def test_odometry_without_stamps_is_taken_to_the_camera_s_clock():
    off = Robot(odom=None).live()
    assert off["odom"] == pytest.approx(0.002 - 0.03, abs=1e-5)
    assert off["depth"] == pytest.approx(0, abs=1e-6)


def test_a_clock_that_runs_away_is_followed_without_a_wobble():
    robot = Robot(depth=3600.0, color=3600.0)
    robot.live()
    seen = set()
    for _ in range(60):
        robot.clocks["depth"] += 0.002
        robot.clocks["color"] += 0.002
        off = robot.live(1.0)
        assert off["depth"] == pytest.approx(0.028, abs=0.06)
        assert off["color"] == pytest.approx(off["depth"], abs=1e-4)
        seen.add(round(off["depth"] - 0.002 * len(seen), 3))
    assert len(seen) > 1


@given(
    st.lists(st.tuples(st.floats(0.0, 2.0), st.floats(0.001, 0.5)), min_size=1, max_size=60),
    st.integers(-(10**18), 10**18),
)
def test_lateness_is_what_is_beyond_the_least_of_the_window(delays, clock_ns):
    age, taken_s, seen = StampAge(), 1000.0, []
    for delay_s, step_s in delays:
        taken_s += step_s + 2.0  # in order, whatever the delays
        arrival_s = taken_s + delay_s
        late_s = age.late_s(clock_ns + round(taken_s * 1e9) + 1, arrival_s)
        seen = [(a, d) for a, d in seen if a >= arrival_s - WINDOW_S] + [(arrival_s, delay_s)]
        assert late_s == pytest.approx(delay_s - min(d for _, d in seen), abs=1e-5)


def test_an_age_is_what_is_beyond_the_least_difference_of_the_clocks():
    age = StampAge()
    assert (age.offset_s, age.stands_still) == (math.inf, False)
    assert age.late_s(1_000_000_000, 5.0) == 0.0
    assert (age.offset_s, age.stands_still) == (4.0, False)
    assert age.late_s(2_000_000_000, 6.5) == 0.5
    assert age.late_s(3_000_000_000, 6.75) == 0.0
    assert age.offset_s == 3.75
    assert age.late_s(4_000_000_000, 8.0, 3.5) == 0.5  # by the other's clock
    assert age.late_s(5_000_000_000, 9.0, 5.0) == 0.25


def test_a_stamp_that_stands_still_tells_no_age_and_spoils_none():
    age = StampAge()
    assert age.late_s(0, 5.0) == 0.0
    assert age.stands_still
    assert age.offset_s == math.inf
    assert age.late_s(1_000_000_000, 6.0) == 0.0
    assert not age.stands_still
    assert age.late_s(1_000_000_000, 9.0) == 0.0
    assert age.stands_still
    assert age.late_s(2_000_000_000, 8.0) == 1.0
    assert not age.stands_still


def test_a_clock_that_was_set_back_by_more_than_a_second_begins_anew():
    age = StampAge()
    age.late_s(10_000_000_000, 20.0)
    assert age.late_s(9_000_000_000, 21.0) == 2.0
    assert age.late_s(7_999_999_999, 22.0) == 0.0
    assert age.offset_s == pytest.approx(14.0)


def test_the_least_difference_counts_for_ten_seconds():
    age = StampAge()
    age.late_s(1_000_000_000, 16.0)
    age.late_s(2_000_000_000, 18.0)
    assert age.late_s(9_000_000_000, 26.0) == 2.0  # just as old as it may be
    assert age.late_s(10_000_000_000, 26.5) == 0.5
    assert age.offset_s == 16.0
