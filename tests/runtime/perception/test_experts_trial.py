"""Models that vote, tried: what is said of pictures that come along, how long it takes, and what
would have to be configured."""

import re
from pathlib import Path

import pytest
from mmproj import write_mmproj

from models.detection.trial import RENDERS
from models.errors import ModelFileError
from models.store import manifest
from runtime.config import load
from runtime.perception import experts_trial
from runtime.perception.experts_trial import Voter


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
    for line in lines[2:5]:
        told = dict(re.findall(r"(\S+)\.jpg (\d\.\d\d)", line))
        assert max(told, key=lambda view: float(told[view])) == "bathroom", line
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
    assert re.search(r"^  sle, toilet: (no preference|living-room\.jpg 0\.\d\d, )", told, re.M)
    assert re.search(
        r"^a picture is encoded in \d+\.\d\d s, when its keyframe is kept$", told, re.M
    )
    assert re.search(r"^panel.decide_budget_s: [\d.]+ would hold it; 2 is the default$", told, re.M)
    used = [line.removeprefix("use it with ") for line in lines if line.startswith("use it")]
    config = load(None, used)
    assert config.models.vision_projector == str(projector)
    assert config.navigate.keyframes.image_width_px == 320
