"""Looks beside the drive: chosen, in a thread of its own, one at a time."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from apartment import NO_DETECTIONS, TWO_ROOMS, Apartment

from runtime.clock import SystemClock
from runtime.core.mapping.attention import View
from runtime.core.types import Pose
from runtime.loops.detector_worker import DetectorWorker, Surveyed
from runtime.tracing.budgets import read_budgets
from runtime.tracing.tracer import Tracer

OBS = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)).observe()


def image(name: str) -> Surveyed:
    return Surveyed(name, OBS, OBS.pose.xy[None], 0.0)


def shows(first: int, n: int = 50) -> View:
    return View(frozenset(range(first, first + n)), 0)


class Detector:
    """Every look waits until it is let go."""

    def __init__(self) -> None:
        self.looked: list[object] = []
        self.began, self.go = threading.Semaphore(0), threading.Semaphore(0)
        self.error: Exception | None = None

    def __call__(self, surveyed: Surveyed):
        self.looked.append(surveyed.asker)
        self.began.release()
        assert self.go.acquire(timeout=20)
        if self.error:
            raise self.error
        return None if surveyed.asker == "dark" else NO_DETECTIONS


@contextmanager
def working() -> Iterator[tuple[Detector, DetectorWorker]]:
    detector, clock = Detector(), SystemClock()
    worker = DetectorWorker(detector, Tracer(read_budgets(), clock.now_s), clock)
    try:
        yield detector, worker
    finally:
        detector.go.release(100)
        worker.close()


def taken(worker: DetectorWorker, n: int) -> list[object]:
    names: list[object] = []
    waits = threading.Event()
    for _ in range(2000):
        names += [look.of.asker for look in worker.take()]
        if len(names) >= n:
            return names
        waits.wait(0.01)
    raise AssertionError(names)


def test_what_passes_by_during_a_look_is_looked_at_and_the_newest_after_it():
    with working() as (detector, worker):
        worker.offer(image("first"), shows(0), False)
        assert detector.began.acquire(timeout=20)
        worker.offer(image("goal passes by"), shows(500), False)
        for n in range(30):
            worker.offer(image(f"known {n}"), shows(0), False)
        assert worker.behind()
        detector.go.release(3)
        assert taken(worker, 3) == ["first", "goal passes by", "known 29"]
        assert not worker.behind()


def test_a_view_that_is_offered_on_and_on_is_not_waited_for():
    with working() as (detector, worker):
        worker.offer(image("first"), shows(0), False)
        assert detector.began.acquire(timeout=20)
        assert worker.behind()  # it is looked at for the first time
        for n in range(5):
            worker.offer(image(f"the same {n}"), shows(0), False)
            detector.go.release(1)
            assert detector.began.acquire(timeout=20)  # a look is under way
            assert worker.behind() == (n == 0)  # the first was not taken yet
            worker.take()
            assert not worker.behind()
        worker.offer(image("another"), shows(500), False)
        assert worker.behind()


def test_at_once_means_the_newest():
    with working() as (detector, worker):
        worker.offer(image("first"), shows(0), False)
        assert detector.began.acquire(timeout=20)
        worker.offer(image("new"), shows(500), False)
        worker.offer(image("the target"), shows(0), True)
        detector.go.release(2)
        assert taken(worker, 2) == ["first", "the target"]


def test_an_image_of_which_nothing_can_be_said_is_left_out():
    with working() as (detector, worker):
        worker.offer(image("dark"), shows(0), False)
        assert detector.began.acquire(timeout=20)
        detector.go.release(1)
        worker.offer(image("light"), shows(500), False)
        detector.go.release(1)
        assert taken(worker, 1) == ["light"]


def test_a_new_search_begins_when_no_look_is_under_way_and_gets_none_of_the_old():
    with working() as (detector, worker):
        worker.offer(image("old"), shows(0), False)
        assert detector.began.acquire(timeout=20)
        worker.offer(image("old too"), shows(500), False)
        threading.Timer(0.2, detector.go.release).start()
        worker.begin(newest_only=False)
        assert worker.take() == []
        assert detector.looked == ["old"]
        detector.go.release(1)
        worker.offer(image("new"), shows(0), False)
        assert taken(worker, 1) == ["new"]


def test_a_pause_ends_no_look_and_loses_nothing_that_waits():
    with working() as (detector, worker):
        worker.offer(image("first"), shows(0), False)
        assert detector.began.acquire(timeout=20)
        worker.offer(image("waits"), shows(500), False)
        threading.Timer(0.2, detector.go.release).start()
        with worker.paused():
            assert detector.looked == ["first"]
            assert not detector.began.acquire(timeout=0.3)  # nothing is looked at meanwhile
        detector.go.release(1)
        assert taken(worker, 2) == ["first", "waits"]
        worker.offer(image("known"), shows(0), False)
        assert not worker.behind()  # what was looked at is remembered


def test_what_goes_wrong_is_raised_to_who_takes():
    with working() as (detector, worker):
        detector.error = KeyError("what the camera saw")
        worker.offer(image("first"), shows(0), False)
        assert detector.began.acquire(timeout=20)
        detector.go.release(1)
        with pytest.raises(KeyError):
            taken(worker, 1)


def test_after_a_look_the_detector_rests_as_long_as_it_is_told():
    with working() as (detector, worker):
        worker.rest = 1000.0
        worker.offer(image("first"), shows(0), False)
        assert detector.began.acquire(timeout=20)
        threading.Event().wait(0.05)
        detector.go.release(1)
        assert taken(worker, 1) == ["first"]
        worker.offer(image("second"), shows(500), False)
        assert not detector.began.acquire(timeout=0.5)
