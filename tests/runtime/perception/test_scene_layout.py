"""The network that was taught views is used beside what it was taught with, and nothing else."""

from pathlib import Path

import numpy as np
import pytest
from taught_layout import ShownModel, TaughtLayout

from models.errors import ModelFileError
from models.store import manifest
from runtime.clock import SystemClock
from runtime.config import ModelsConfig
from runtime.experts.scene_layout import SceneLayoutExperts
from runtime.experts.scorer import Scorer
from runtime.experts.seating import Unseated
from runtime.perception.scene_layout import Speaker, layout_for, seat_layout

PATH = Path("scene-layout.onnx")


@pytest.fixture(autouse=True)
def _as_it_was_taught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "runtime.perception.scene_layout.SceneLayout", lambda path, threads: TaughtLayout()
    )


def row(text: str) -> np.ndarray:
    return np.ones(1, np.float32)


SISTER = """
[sister]
task = "scene layout"
beside = "other-det"
licence = "MIT"
files = []
[mute]
task = "scene layout"
licence = "MIT"
files = []
"""


@pytest.mark.parametrize(
    ("models", "name"),
    [
        (ModelsConfig(), "scene-layout"),
        (ModelsConfig(detectors=("nanodet-g", "other-det")), "sister"),
        (ModelsConfig(detectors=("nanodet-g",)), "scene-layout"),  # which then says that it is not
        (ModelsConfig(detectors=("other-det",), scene_layout="own.onnx"), "own.onnx"),
    ],
)
def test_that_of_a_configured_detector_is_used(
    models: ModelsConfig, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "models.toml"
    path.write_text(SISTER, encoding="utf-8")
    monkeypatch.setattr(manifest, "user_manifest", lambda: path)
    assert layout_for(models) == name


def test_beside_its_detector_and_language_model_it_has_both_voices() -> None:
    with Scorer([("small", ShownModel())], SystemClock()) as scorer:
        told = seat_layout(lambda: PATH, ("detector",), Speaker("language", scorer), row, 1)
        assert isinstance(told, SceneLayoutExperts)
        assert (told.scorer, told.mute) == (scorer, "")


@pytest.mark.parametrize("detectors", [(), ("other",), ("other", "another")])
def test_beside_other_detectors_alone_it_is_not_used_and_nothing_is_wrong(
    detectors: tuple[str, ...],
) -> None:
    told = seat_layout(lambda: PATH, detectors, None, row, 1)
    assert isinstance(told, Unseated)
    assert not told.fault
    assert told.why.startswith("scene-layout.onnx: made for a detector that models.detectors does")
    assert 'research.scene_layout = "embedding"' in told.why


def test_another_detector_beside_its_own_does_not_matter() -> None:
    told = seat_layout(lambda: PATH, ("other", "detector"), None, row, 1)
    assert isinstance(told, SceneLayoutExperts)


def test_beside_another_language_model_it_has_no_words() -> None:
    with Scorer([("small", ShownModel())], SystemClock()) as scorer:
        for speaker, why in (
            (Speaker("other", scorer), "made for another language model than models.language"),
            (None, "models.language does not score words"),
        ):
            told = seat_layout(lambda: PATH, ("detector",), speaker, row, 1)
            assert isinstance(told, SceneLayoutExperts)
            assert told.scorer is None
            assert told.mute.startswith(f"scene-layout.onnx: {why}")


def test_a_file_that_was_taught_no_words_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(TaughtLayout, "speaks", False)
    with Scorer([("small", ShownModel())], SystemClock()) as scorer:
        told = seat_layout(lambda: PATH, ("detector",), Speaker("language", scorer), row, 1)
    assert isinstance(told, SceneLayoutExperts)
    assert told.mute.startswith("scene-layout.onnx: has nothing to show to a language model")


def test_a_file_that_is_missing_or_damaged_is_said_in_a_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def missing() -> Path:
        raise ModelFileError("scene-layout: no such model")

    def damaged(path: Path, threads: int) -> TaughtLayout:
        raise ModelFileError(f"{path}: not a usable ONNX file")

    told = seat_layout(missing, ("detector",), None, row, 1)
    assert told == Unseated("scene-layout: no such model", fault=True)
    monkeypatch.setattr("runtime.perception.scene_layout.SceneLayout", damaged)
    told = seat_layout(lambda: PATH, ("detector",), None, row, 1)
    assert told == Unseated("scene-layout.onnx: not a usable ONNX file", fault=True)
