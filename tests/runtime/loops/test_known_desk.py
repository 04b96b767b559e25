"""What is known of the home, for whoever asks: beside the loop."""

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import pytest
from goal_bench import Asked
from lived_in import lived_in

from runtime.clock import SystemClock
from runtime.core.world import World
from runtime.loops import known_desk
from runtime.loops.known_desk import WAITING, KnownDesk
from runtime.robot.requests import ENDS, Request

CLASSES = (("mug", "cup"),)


class At:
    """A desk for a world, and what it has answered."""

    def __init__(self, world: World | None) -> None:
        self.world = world
        self.desk = KnownDesk(lambda: "odom", lambda: (0.0, 0.0), SystemClock(), 0)
        goal = SimpleNamespace(classes=CLASSES)
        self.desk.search = lambda: SimpleNamespace(world=self.world, goal=goal)

    def ask(self, kind: str, **body: object) -> Asked:
        asked = Asked()
        request = Request(kind, body, asked, f"rfnav/{kind}")
        answer = self.desk.answer(request)
        if answer is not None:
            request.reply(answer)
        return asked

    def answered(self, kind: str, **body: object) -> dict:
        asked = self.ask(kind, **body)
        waited(lambda: bool(asked.answers))
        return asked.answers[0]


def waited(for_: Callable[[], bool]) -> None:
    until_s = time.monotonic() + 20.0
    while not for_():
        assert time.monotonic() < until_s
        time.sleep(0.01)


@pytest.fixture
def at(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(known_desk, "REST", 0.0)
    it = At(lived_in())
    yield it
    it.desk.close()


def test_things_places_and_the_map_are_told(at: At):
    assert at.answered("things")["things"][0]["name"] == "mug"
    assert at.answered("where", name="a cup")["found"][0]["id"] == 1
    assert at.answered("map")["rows"] > 40


def test_before_anything_was_seen_that_is_said(at: At):
    at.world = None
    assert at.answered("things")["said"].startswith("nothing is known yet")


@pytest.mark.parametrize(
    ("kind", "body", "said"),
    [
        ("things", {"all": True}, "rfnav/things: ask {}"),
        ("map", {"since": 3}, "rfnav/map: ask {}"),
        ("where", {"of": "mug"}, 'rfnav/where: ask {"name": NAME}'),
    ],
)
def test_nonsense_is_refused_at_once(at: At, kind: str, body: dict, said: str):
    assert at.ask(kind, **body).answers == [{"accepted": False, "error": said}]


def test_one_copy_serves_until_something_new_was_seen(at: At, monkeypatch: pytest.MonkeyPatch):
    copies, real = [], known_desk.atlas_of
    monkeypatch.setattr(known_desk, "atlas_of", lambda *a: copies.append(a) or real(*a))
    at.answered("map")
    at.answered("things")
    assert len(copies) == 1
    at.world.stamp_ns += 1
    at.answered("things")
    assert len(copies) == 1  # it is no older than FRESH_S
    monkeypatch.setattr(known_desk, "FRESH_S", 0.0)
    at.answered("things")
    assert len(copies) == 2
    at.world = replace(at.world)
    at.answered("things")
    assert len(copies) == 3


def test_without_a_question_there_is_neither_copy_nor_thread(at: At):
    assert not any(thread.name == "known" for thread in threading.enumerate())


def test_a_flood_is_refused_and_what_waits_at_the_end_as_well(at: At, monkeypatch):
    monkeypatch.setattr(known_desk, "REST", 1e6)
    first = at.ask("things")
    waited(lambda: bool(first.answers))  # it rests now
    asked = [at.ask("things") for _ in range(WAITING + 2)]
    late = [one.answers for one in asked if one.answers]
    assert late == 2 * [
        [{"accepted": False, "error": f"busy: {WAITING} such requests wait already"}]
    ]
    at.desk.close()
    assert all(one.answers == [{"accepted": False, "error": ENDS}] for one in asked[:WAITING])


def test_a_mistake_of_ours_is_answered_and_then_raised(at: At, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(known_desk, "nothing_told", lambda *_: 1 / 0)
    at.world = None
    assert at.answered("map") == {"accepted": False, "error": "internal error"}
    waited(lambda: not any(thread.name == "known" for thread in threading.enumerate()))
    with pytest.raises(ZeroDivisionError):
        at.ask("map")
