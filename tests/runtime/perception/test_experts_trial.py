"""Models that vote, tried: what is said of pictures that come along, how long it takes, and what
would have to be configured."""

import re
from pathlib import Path

import pytest
from mmproj import write_mmproj

from models.detection.trial import RENDERS
from models.errors import ModelFileError
from models.store import manifest
from runtime.clock import Deadline, SystemClock
from runtime.config import Config, load
from runtime.core.types import Absence, Brief, FrontierBrief, Missing
from runtime.experts.panel import Expert
from runtime.perception import experts_trial
from runtime.perception.experts_trial import Voter
from runtime.perception.goal_words import Goal


@pytest.mark.parametrize(
    ("name", "projector", "experts", "setting"),
    [
        ("experts", "", ("o2f", "r2f", "sle"), None),
        ("qwen3-0.6b", "", ("o2f", "r2f"), 'models.language="qwen3-0.6b"'),
        ("smolvlm2-500m", "", ("sle",), 'models.vision="smolvlm2-500m"'),
        ("/x/y.gguf", "", ("o2f", "r2f"), 'models.language="/x/y.gguf"'),
        ("/x/y.gguf", "/x/z.gguf", ("sle",), 'models.vision_projector="/x/z.gguf"'),
    ],
)
def test_what_a_model_is_asked_for(
    name: str, projector: str, experts: tuple[str, ...], setting: str | None
) -> None:
    voter = Voter.named(name, projector, "", 1)
    assert voter is not None
    assert voter.experts == experts
    assert setting is None or setting in voter.settings
    load(None, voter.settings)


def test_what_does_not_vote() -> None:
    for name in ("rfnav-det", "some.onnx"):
        assert Voter.named(name, "", "", 1) is None
    with pytest.raises(ModelFileError, match="minilm: is a model for text, and neither sees nor"):
        Voter.named("minilm", "", "", 1)


class AcceptsSlowly:
    """Experts that answer at once, of models whose goal takes time until it is scored."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def accept(self, goal: str, config: Config) -> tuple[Goal, None]:
        self.now_s += 3.0
        return Goal(goal, goal, ((goal,),), "as it is"), None

    def settle(self, by: Deadline) -> bool:
        self.now_s += 4.0
        return True

    def health(self) -> dict[str, object]:
        return {}

    def seated(self, config: Config) -> dict[str, Expert]:
        def ask(brief: Brief, by: Deadline) -> Missing:
            self.now_s += 0.5
            return Missing("o2f", Absence.NO_MODEL)

        return {"o2f": ask}


def test_a_vote_is_timed_without_what_is_done_before_it(monkeypatch: pytest.MonkeyPatch) -> None:
    models = AcceptsSlowly()
    monkeypatch.setattr(experts_trial.time, "perf_counter", lambda: models.now_s)
    seen = [FrontierBrief(0, 1.0, (), ())]
    trial = experts_trial._Trial(models, load(None, ()), SystemClock(), [], seen)  # type: ignore[arg-type]
    assert next(trial.times()).startswith("a vote on 8 frontiers: 0.50 s where nothing")


@pytest.mark.slow
def test_our_own_experts_know_a_bathroom(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experts_trial, "ASKED", ("toilet",))
    monkeypatch.setattr(experts_trial, "FRONTIERS", 3)
    monkeypatch.setattr(experts_trial, "_busy", lambda: "  the machine is busy")
    voter = Voter.named("experts", "", "", 1)
    assert voter is not None
    lines = list(voter.tried(RENDERS))
    assert lines[0].startswith("experts: votes as o2f, r2f, sle; loaded in ")
    assert lines[1] == "  the machine is busy"
    for line in lines[2:4]:
        told = dict(re.findall(r"(\S+)\.jpg (\d\.\d\d)", line))
        assert max(told, key=lambda view: float(told[view])) == "bathroom", line
    each = r"(\S+\.jpg 0\.\d\d(, )?){3} \(by head\)"
    assert re.fullmatch(rf"  sle, toilet: (no preference: )?{each}", lines[4])
    timed = r"a vote on 3 frontiers: \d+\.\d\d s where nothing .*, \d+\.\d\d s where all was"
    assert re.fullmatch(timed, lines[5])
    assert lines[6].startswith("panel.decide_budget_s: ")
    assert len(lines) == 7  # there is nothing to configure


@pytest.mark.slow
def test_a_model_that_sees_tells_what_a_picture_costs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of random weights: it is only asked."""
    monkeypatch.setattr(experts_trial, "ASKED", ("toilet",))
    monkeypatch.setattr(experts_trial, "FRONTIERS", 2)
    monkeypatch.setattr(experts_trial, "LOCAL_SHARE", 1e-3)
    text, projector = manifest.fetch("smollm2-135m"), write_mmproj(tmp_path / "mmproj.gguf")
    voter = Voter.named(str(text), str(projector), "llava-1.5", 1)
    assert voter is not None
    lines = list(voter.tried(RENDERS[:2]))
    told = "\n".join(lines)
    assert re.search(r"^  sle, toilet: (no preference: )?living-room\.jpg 0\.\d\d, ", told, re.M)
    assert re.search(
        r"^a picture is encoded in \d+\.\d\d s, when its keyframe is kept$", told, re.M
    )
    assert re.search(r"^panel.decide_budget_s: [\d.]+ would hold it; 2 is the default$", told, re.M)
    used = [line.removeprefix("use it with ") for line in lines if line.startswith("use it")]
    config = load(None, used)
    assert config.models.vision_projector == str(projector)
    assert config.navigate.keyframes.image_width_px == 320
