"""Stages, timed on a clock that a test sets; overruns and what was running beside them."""

import threading

import pytest
from manual_clock import ManualClock

from runtime.tracing.budgets import read_budgets
from runtime.tracing.stages import Stage
from runtime.tracing.tracer import OVERRUNS_KEPT, Beside, Tracer

DEADLINE_S = read_budgets().stages[Stage.ACT].p99_ms / 1e3


@pytest.fixture
def parts():
    clock = ManualClock(10.0)
    return clock, Tracer(read_budgets(), clock.now_s)


def test_a_stage_is_timed_and_one_within_it_too(parts):
    clock, tracer = parts
    with tracer.stage(Stage.ACT):
        clock.advance(0.001)
        with tracer.stage(Stage.PLACE):
            clock.advance(0.002)
    told = tracer.told()
    assert set(told) == {"act", "place"}
    assert (told["act"]["max_ms"], told["place"]["max_ms"]) == (3.0, 2.0)
    assert not tracer.overruns()


def test_one_that_raises_is_timed_and_over(parts):
    clock, tracer = parts

    def fails():
        with tracer.stage(Stage.ACT):
            clock.advance(0.001)
            raise KeyError("what was seen")

    for _ in range(2):
        with pytest.raises(KeyError):
            fails()
    assert tracer.told()["act"]["n"] == 2


def test_an_overrun_says_what_was_running_beside_it(parts):
    clock, tracer = parts
    looking, done = threading.Event(), threading.Event()

    def look():
        with tracer.stage(Stage.DETECT):
            looking.set()
            done.wait(10)

    thread = threading.Thread(target=look, name="detector")
    thread.start()
    assert looking.wait(10)
    tracer.note("decisions", "vote")
    clock.advance(0.5)
    tracer.note("decisions", "vote")  # still the same one
    with tracer.stage(Stage.ACT):
        clock.advance(2 * DEADLINE_S)
    (overrun,) = tracer.overruns()
    done.set()
    thread.join()
    tracer.note("decisions", "")
    tracer.overruns()  # the look's own
    since_s = pytest.approx(0.5 + 2 * DEADLINE_S)
    assert overrun.stage is Stage.ACT
    assert overrun.took_ms == pytest.approx(2e3 * DEADLINE_S)
    assert overrun.beside == (
        Beside("detector", "detect", since_s),
        Beside("decisions", "vote", since_s),
    )
    assert tracer.told()["act"]["over"] == 1
    with tracer.stage(Stage.ACT):
        clock.advance(2 * DEADLINE_S)
    assert tracer.overruns()[0].beside == ()


def test_overruns_that_nobody_asks_for_do_not_pile_up(parts):
    _, tracer = parts
    for _ in range(3 * OVERRUNS_KEPT):
        tracer.book(Stage.ACT, 2 * DEADLINE_S)
    assert len(tracer.overruns()) == OVERRUNS_KEPT
    assert not tracer.overruns()
    assert tracer.told()["act"]["over"] == 3 * OVERRUNS_KEPT


def test_a_search_begins_with_nothing_counted(parts):
    clock, tracer = parts
    with tracer.stage(Stage.ACT):
        clock.advance(2 * DEADLINE_S)
        tracer.clear()
    assert tracer.told()["act"]["n"] == 1
    tracer.clear()
    assert tracer.told() == {}
    assert tracer.overruns() == []
