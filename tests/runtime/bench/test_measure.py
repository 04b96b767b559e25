"""A run of the bench."""

import itertools
import os
import threading
import time
from concurrent.futures import Future
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from runtime.bench import measure, synthetic
from runtime.bench.measure import BenchError, Subject
from runtime.bench.synthetic import Published
from runtime.config import load
from runtime.errors import RecordingError
from runtime.robot.session import GOAL
from runtime.tracing.stages import Stage


@pytest.mark.slow
def test_a_run_from_start_to_end():
    config = load(None, ())
    drive = synthetic.drive(8.0, config.bus.topics, config.camera)
    found = measure.measured(Subject(), ("toilet",), drive, config.bus.topics, 20.0)
    assert {Stage.LATE, Stage.TICK, Stage.FRAME, Stage.SURVEY, Stage.DETECT} <= set(found.stages)
    assert found.stages[Stage.TICK]["n"] > 20
    assert 0 < found.ready_s < 60
    assert found.first_command_s is not None
    assert found.memory_mb > 100
    assert found.sleeper["n"] > 20


def test_a_runtime_that_ends_is_told_of_in_a_line_with_what_it_said():
    config = load(None, ())
    wrong = Subject(("--set", "camera.hight_m=1"))
    with pytest.raises(BenchError, match=r"the runtime ended and said: rfnav: .*hight_m"):
        measure.measured(wrong, ("toilet",), iter(()), config.bus.topics, 20.0)


def test_a_runtime_that_says_much_is_not_held_up_by_it(tmp_path: Path):
    package = tmp_path / "runtime"
    package.mkdir()
    (package / "__init__.py").touch()
    said = "import sys\nsys.stderr.write('much\\n' * 200_000 + 'the last\\n')\n"
    (package / "__main__.py").write_text(said)
    config = load(None, ())
    with pytest.raises(BenchError, match="the runtime ended and said: the last"):
        measure.measured(Subject((), tmp_path), ("toilet",), iter(()), config.bus.topics, 20.0)


class Wire:
    """A session that nobody hears."""

    def declare_subscriber(self, *_: object) -> None:
        pass

    def declare_publisher(self, *_: object, **__: object) -> "Wire":
        return self

    def put(self, payload: bytes) -> None:
        pass


@pytest.fixture
def robot(tmp_path: Path) -> measure._Robot:
    alive = SimpleNamespace(pid=os.getpid(), poll=lambda: None)
    return measure._Robot(Wire(), load(None, ()).bus.topics, alive, tmp_path / "said.txt")


def test_a_drive_ends_when_what_is_done_beside_it_fails(robot: measure._Robot):
    hours = [Published("odom", hour * 3600 * 10**9, b"") for hour in range(3)]
    began_s = time.monotonic()
    with pytest.raises(BenchError, match="refused"), robot.playing(hours) as played:
        raise BenchError("the goal was refused")
    assert time.monotonic() - began_s < 60
    assert played.done()


def told(query: str, body: dict[str, str], asked: list[str], scored_s: float) -> dict[str, Any]:
    """What a runtime says whose experts were so long at work."""
    if query == GOAL:
        asked.append(body["goal"])
    return {"stages": {Stage.SCORE: {"total_s": scored_s}}}


def test_the_next_goal_is_asked_for_once_the_experts_are_idle(
    robot: measure._Robot, monkeypatch: pytest.MonkeyPatch
):
    asked: list[str] = []
    monkeypatch.setattr(measure, "GOAL_S", 60.0)
    monkeypatch.setattr(measure, "POLL_S", 0.01)
    monkeypatch.setattr(robot, "ask", lambda query, body: told(query, body, asked, 3.0))
    played: Future[float] = Future()
    threading.Timer(0.5, lambda: played.set_result(7.0)).start()
    assert robot.search(("bed", "sofa", "vase"), played) == 7.0
    assert asked[:3] == ["bed", "sofa", "vase"]


def test_goals_are_asked_for_in_turn_until_the_drive_is_over(
    robot: measure._Robot, monkeypatch: pytest.MonkeyPatch
):
    asked: list[str] = []
    monkeypatch.setattr(measure, "GOAL_S", 0.05)
    monkeypatch.setattr(measure, "POLL_S", 0.02)
    busy = (second / 2 for second in itertools.count())  # all the time
    monkeypatch.setattr(robot, "ask", lambda query, body: told(query, body, asked, next(busy)))
    played: Future[float] = Future()
    threading.Timer(0.33, lambda: played.set_result(7.0)).start()
    assert robot.search(("bed", "sofa"), played) == 7.0
    assert len(asked) > 3
    assert asked == ["bed", "sofa"] * (len(asked) // 2) + ["bed"] * (len(asked) % 2)


def test_a_drive_that_itself_was_too_late_ends_the_goals(
    robot: measure._Robot, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(robot, "ask", lambda query, body: None)
    played: Future[float] = Future()
    played.set_exception(TimeoutError("the player's own"))
    with pytest.raises(TimeoutError, match="the player's own"):
        robot.search(("bed", "sofa"), played)


def test_one_goal_is_asked_for_once(robot: measure._Robot, monkeypatch: pytest.MonkeyPatch):
    asked: list[str] = []
    monkeypatch.setattr(measure, "GOAL_S", 0.01)
    monkeypatch.setattr(robot, "ask", lambda query, body: asked.append(body["goal"]))
    played: Future[float] = Future()
    threading.Timer(0.1, lambda: played.set_result(7.0)).start()
    assert robot.search(("bed",), played) == 7.0
    assert asked == ["bed"]


def test_a_drive_that_cannot_begin_is_told_at_once(robot: measure._Robot):
    def broken():
        raise RecordingError("no colour")
        yield

    with pytest.raises(RecordingError, match="no colour"), robot.playing(broken()):
        pytest.fail("it began")
    with pytest.raises(BenchError, match="nothing to play"), robot.playing(()):
        pytest.fail("it began")


def test_a_drive_tells_the_memory_at_its_half_and_what_went_wrong_in_it(robot: measure._Robot):
    def breaks():
        yield Published("odom", 0, b"")
        raise RecordingError("cut off")

    with robot.playing([Published("odom", n * 10**8, b"") for n in range(3)]) as played:
        assert played.result(60) > 1
    with robot.playing(breaks()) as played, pytest.raises(RecordingError, match="cut off"):
        played.result(60)
