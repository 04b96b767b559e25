"""Deadlines only tighten, and a manual clock wakes those who wait on it."""

import math
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st
from manual_clock import ManualClock

from runtime.clock import Deadline, SystemClock


@given(st.floats(0, 100), st.lists(st.floats(0, 100), max_size=5))
def test_deadlines_only_tighten(first: float, rest: list[float]) -> None:
    clock = ManualClock(5.0)
    deadline = Deadline.after(first, clock)
    for seconds in rest:
        tighter = deadline.tightened(seconds)
        assert tighter.at_s <= deadline.at_s
        deadline = tighter
    assert deadline.left_s() == pytest.approx(min([first, *rest]))


def test_left_never_goes_below_zero() -> None:
    clock = ManualClock()
    deadline = Deadline.after(1.0, clock)
    assert not deadline.passed()
    clock.advance(3.0)
    assert deadline.passed()
    assert deadline.left_s() == 0.0
    assert Deadline.never(clock).left_s() == math.inf
    assert not Deadline.never(clock).passed()
    assert Deadline.never(clock).tightened(2.0).at_s == 5.0


def test_a_monotonic_clock_does_not_go_back() -> None:
    with pytest.raises(ValueError, match="cannot go back"):
        ManualClock().advance(-1)


def test_a_waiter_wakes_when_time_is_moved() -> None:
    clock, condition, woke = ManualClock(), threading.Condition(), threading.Event()
    waiting = threading.Event()

    def wait() -> None:
        with condition:
            waiting.set()
            while clock.now_s() < 10:
                clock.wait(condition, 10.0)
        woke.set()

    thread = threading.Thread(target=wait)
    thread.start()
    assert waiting.wait(2)
    clock.advance(4)
    assert not woke.is_set()
    clock.advance(6)
    assert woke.wait(2)
    thread.join(2)


def test_the_system_clock_waits_no_longer_than_asked() -> None:
    clock, condition = SystemClock(), threading.Condition()
    began = clock.now_s()
    with condition:
        clock.wait(condition, began + 0.02)
    assert 0.015 < clock.now_s() - began < 0.5
