"""Another goal on the same way."""

from collections.abc import Mapping
from itertools import count
from pathlib import Path

import pytest
from apartment import NO_DETECTIONS
from fake_models import FakeModels
from lockstep_double import home
from recorded_drive import recorded_drive

from runtime.config import Config, load
from runtime.core.types import Detections
from runtime.errors import RecordingError
from runtime.perception.goal_words import Goal
from runtime.recording.exact import read
from runtime.recording.reader import Recorded
from runtime.replay.question import Finding, asked
from runtime.replay.script import Script, Turn


class Reseen(FakeModels):
    """Sees what was seen then, in the order in which it was; has no experts."""

    def __init__(self, path: Path) -> None:
        super().__init__(home())
        seen = [turn.heard["detections"] for turn in Script.open(path).turns()]
        self.seen = [read(told[0], Detections) for told in seen if told]
        self.windows: list[object] = []

    def accept(self, goal: str, config: Config):
        assert config.panel.experts == ()
        _, panel = super().accept(goal, config)
        return Goal(goal, goal, ((goal,),), f"{goal}: as it is"), panel

    def detect(self, rgb, window=lambda: None) -> Detections:
        self.windows.append(window())
        return self.seen.pop(0)


@pytest.fixture(scope="module")
def recorded() -> Path:
    return recorded_drive()


def question(path: Path) -> tuple[str, list[Finding]]:
    with_none = load(None, ["panel.experts=[]"])
    return asked(Script.open(path), "toilet", Reseen(path), with_none)


def test_what_would_have_been_found_and_when(recorded: Path):
    how, found = question(recorded)
    assert how == "toilet: as it is"
    thing = found[0]
    assert thing.xy == pytest.approx((7.4, 2.2), abs=0.6)
    assert thing.believed_s is not None
    assert 0 < thing.noticed_s <= thing.believed_s
    assert "believed at" in thing.in_words()


def test_what_was_never_seen_would_not_have_been_found(recorded: Path):
    models = Reseen(recorded)
    models.seen = [NO_DETECTIONS] * len(models.seen)
    with_none = load(None, ["panel.experts=[]"])
    assert asked(Script.open(recorded), "toilet", models, with_none)[1] == []


def test_without_colour_nothing_can_be_asked(recorded: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("runtime.replay.script._take_images", lambda turn, seen: None)
    with pytest.raises(RecordingError, match="has no colour"):
        question(recorded)


def test_small_things_get_the_closer_look_that_a_drive_gives(
    recorded: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("runtime.loops.search.surfaces_window", lambda obs, mount: obs.stamp_ns)
    models = Reseen(recorded)
    asked(Script.open(recorded), "toilet", models, load(None, ["panel.experts=[]"]))
    stamps = [turn.told["stamp_ns"] for turn in Script.open(recorded).turns() if turn.depth]
    assert models.windows == stamps


def test_what_a_detector_elsewhere_said_is_asked_again(
    recorded: Path, monkeypatch: pytest.MonkeyPatch
):
    with_none = load(None, ["panel.experts=[]", 'research.detector_source="topic"'])
    models = Reseen(recorded)
    with pytest.raises(RecordingError, match="has no labels"):
        asked(Script.open(recorded), "toilet", models, with_none)
    stamps = [turn.told["stamp_ns"] for turn in Script.open(recorded).turns() if turn.depth]
    told = [None, *map(labels, stamps[1:], models.seen[1:])]  # the first came too late
    monkeypatch.setattr(Script, "heard", lambda self, name: told)
    monkeypatch.setattr("runtime.replay.script._take_images", depth_alone)
    _, found = asked(Script.open(recorded), "toilet", models, with_none)
    assert found[0].xy == pytest.approx((7.4, 2.2), abs=0.6)
    assert models.windows == []


def labels(stamp_ns: int, seen: Detections) -> dict[str, object]:
    told = {"stamp_ns": stamp_ns, "names": ["toilet"] * len(seen.scores), "room": None}
    return told | {"boxes": seen.boxes_px.tolist(), "scores": seen.scores.tolist()}


def depth_alone(turn: Turn, seen: Mapping[str, Recorded]) -> None:
    turn.depth = seen["depth"].payload


def test_what_is_believed_at_once_is_believed_from_then_on(
    recorded: Path, monkeypatch: pytest.MonkeyPatch
):
    times = count(0.0, 0.5)
    monkeypatch.setattr(
        "runtime.replay.question._noticed",
        lambda world, now_s: [Finding(7, "toilet", (0.0, 0.0), now_s, next(times), 0.9, 1.0)],
    )
    (thing,) = question(recorded)[1]
    assert next(times) > 5.0
    assert thing.believed_s == 0.0
