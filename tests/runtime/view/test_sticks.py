"""The sticks: told ten times a second while held, and let go whatever becomes of a page."""

import time
from collections.abc import Callable, Iterator

import pytest
from manual_clock import ManualClock

from runtime.clock import SystemClock
from runtime.view.sticks import SILENT_S, SPEAKS_S, ZEROS, PageSticks

MOST = 0.4, 1.0
PATIENCE_S = 10.0


class Base:
    """Hears what is told."""

    def __init__(self) -> None:
        self.heard: list[tuple[float, float]] = []
        self.barred = ""

    def tell(self, v_mps: float, w_radps: float) -> None:
        self.heard.append((v_mps, w_radps))


@pytest.fixture
def base() -> Base:
    return Base()


@pytest.fixture
def sticks(base: Base) -> Iterator[PageSticks]:
    sticks = PageSticks(base.tell, MOST, lambda: base.barred, SystemClock())
    yield sticks
    sticks.close()


def until(what: Callable[[], bool]) -> None:
    by_s = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < by_s
        time.sleep(0.005)


def test_what_is_held_is_told_and_repeated(sticks: PageSticks, base: Base):
    for _ in range(10):
        assert sticks.hold(1, 0.5, -1.0)
        time.sleep(SPEAKS_S / 2)
    assert base.heard[:2] == [(0.2, -1.0)] * 2
    assert sticks.who == 1


def test_a_page_that_falls_silent_has_let_go(sticks: PageSticks, base: Base):
    assert sticks.hold(1, 1.0, 0.0)
    until(lambda: base.heard[-ZEROS:] == [(0.0, 0.0)] * ZEROS)
    assert sticks.who is None
    told = len(base.heard)
    time.sleep(4 * SPEAKS_S)
    assert len(base.heard) == told  # who has let go says nothing more, not even zero
    assert told <= SILENT_S / SPEAKS_S + ZEROS + 3


def test_who_lets_go_tells_zero_at_once(sticks: PageSticks, base: Base):
    sticks.hold(1, 1.0, 0.0)
    until(lambda: len(base.heard) == 1)
    sticks.let_go(1)
    until(lambda: len(base.heard) == 1 + ZEROS)
    assert base.heard[1:] == [(0.0, 0.0)] * ZEROS


def test_one_hand_at_a_time(sticks: PageSticks):
    assert sticks.hold(1, 1.0, 0.0)
    assert not sticks.hold(2, -1.0, 0.0)
    sticks.let_go(2)
    assert sticks.who == 1
    sticks.let_go(1)
    assert sticks.hold(2, -1.0, 0.0)


@pytest.mark.parametrize("given", [(5.0, -5.0), (1e300, -1e300)])
def test_nobody_drives_faster_than_the_robot_may(
    sticks: PageSticks, base: Base, given: tuple[float, float]
):
    sticks.hold(1, *given)
    until(lambda: bool(base.heard))
    assert base.heard[0] == (0.4, -1.0)


def test_a_stop_is_obeyed_by_hands_too(sticks: PageSticks, base: Base):
    sticks.hold(1, 1.0, 0.0)
    until(lambda: bool(base.heard))
    base.barred = "stopped"
    until(lambda: base.heard[-1] == (0.0, 0.0))
    assert not sticks.hold(1, 1.0, 0.0)
    assert sticks.who is None


def test_who_stops_the_robot_takes_them_from_everyone(sticks: PageSticks, base: Base):
    sticks.hold(1, 1.0, 0.0)
    until(lambda: bool(base.heard))
    sticks.drop()
    assert sticks.who is None
    until(lambda: base.heard[-1] == (0.0, 0.0))
    sticks.drop()


@pytest.mark.parametrize("by_the_robot", [False, True])
def test_after_a_stop_nobody_drives_who_has_not_let_go(base: Base, by_the_robot: bool):
    clock = ManualClock()
    sticks = PageSticks(base.tell, MOST, lambda: base.barred, clock)
    assert sticks.hold(1, 1.0, 0.0)
    if by_the_robot:
        base.barred = "stopped"
    else:
        sticks.drop()  # before the robot tells that it stands
    for who in (1, 2, 1, 2, 1):
        clock.advance(SPEAKS_S)
        assert not sticks.hold(who, 1.0, 0.0)
    base.barred = ""  # it was released
    clock.advance(SPEAKS_S)
    assert not sticks.hold(1, 1.0, 0.0)
    clock.advance(SILENT_S)
    assert sticks.hold(2, 1.0, 0.0)
    sticks.close()


def test_closing_ends_in_zero(base: Base):
    sticks = PageSticks(base.tell, MOST, lambda: "", SystemClock())
    sticks.hold(1, 1.0, 0.0)
    until(lambda: bool(base.heard))
    sticks.close()
    assert base.heard[-1] == (0.0, 0.0)
    assert not sticks.hold(1, 1.0, 0.0)
