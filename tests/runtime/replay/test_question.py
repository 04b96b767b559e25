"""Another goal on the same way."""

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
from runtime.replay.question import Finding, asked
from runtime.replay.script import Script


class Reseen(FakeModels):
    """Sees what was seen then, in the order in which it was; has no experts."""

    def __init__(self, path: Path) -> None:
        super().__init__(home())
        seen = [turn.heard["detections"] for turn in Script.open(path).turns()]
        self.seen = [read(told[0], Detections) for told in seen if told]

    def accept(self, goal: str, config: Config):
        assert config.panel.experts == ()
        _, panel = super().accept(goal, config)
        return Goal(goal, goal, ((goal,),), f"{goal}: as it is"), panel

    def detect(self, rgb, window=None) -> Detections:
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
