"""Two detectors' boxes as one voice: what is one thing, what silence is worth, and where none is
fitted."""

from pathlib import Path

import numpy as np
import pytest

from models.detection.detections import RawDetections
from models.detection.fusion import (
    FusionWeights,
    Line,
    Together,
    fused,
    paired,
    read_weights,
)
from models.errors import ModelFileError

A, B = (10.0, 10.0, 50.0, 50.0), (100.0, 10.0, 150.0, 60.0)
NAMES = ("ours", "list")
KNOWS = np.array([[True, True, True], [True, True, False]])
WEIGHTS = FusionWeights(
    alone={("list", "renderings"): Line(1.0, -3.0)},
    together={
        (NAMES, "photographs"): Together((Line(0.5, 1.0), Line(1.0, 2.0)), -2.0),
    },
)


def seen(*rows: tuple[int, float, tuple[float, ...]]) -> RawDetections:
    boxes = np.array([r[2] for r in rows], np.float32).reshape(-1, 4)
    scores = np.array([r[1] for r in rows], np.float32)
    labels = np.array([r[0] for r in rows], np.int32)
    none = np.zeros(0, np.float32)
    return RawDetections(boxes, scores, labels, np.zeros((len(rows), 0), np.float32), none, none)


def odds(p: float) -> float:
    return float(np.log(p / (1 - p)))


def test_boxes_of_one_name_that_overlap_are_one_thing() -> None:
    shifted = tuple(v + 5 for v in A)
    places = paired([seen((0, 0.6, A), (1, 0.9, B)), seen((0, 0.8, shifted), (2, 0.7, B))])
    assert places.labels.tolist() == [1, 0, 2]
    assert places.which.tolist() == [[1, -1], [0, 0], [-1, 1]]
    np.testing.assert_allclose(places.boxes_px[1], shifted)  # the surer one's
    assert places.odds[1] == pytest.approx([odds(0.6), odds(0.8)], abs=1e-5)
    assert np.isnan(places.odds[0, 1])
    # two of one detector stay two: only one of them is what the other saw
    twice = paired([seen((0, 0.9, A), (0, 0.5, shifted)), seen((0, 0.3, A))])
    assert twice.which.tolist() == [[0, 0], [1, -1]]


def test_agreement_and_silence_are_worth_what_was_fitted() -> None:
    both, _ = fused(
        [seen((0, 0.7, A), (1, 0.7, B)), seen((0, 0.6, A))], NAMES, KNOWS, "photographs", WEIGHTS
    )
    agreed = 0.5 * odds(0.7) + 1.0 + odds(0.6) + 2.0 - 2.0
    alone = 0.5 * odds(0.7) + 1.0 - 2.0
    assert both.labels.tolist() == [0, 1]
    assert [odds(p) for p in both.scores.tolist()] == pytest.approx([agreed, alone], abs=1e-4)


def test_who_has_no_word_for_it_is_not_held_silent() -> None:
    one, _ = fused([seen((2, 0.7, A)), seen()], NAMES, KNOWS, "photographs", WEIGHTS)
    assert one.scores.tolist() == pytest.approx([0.7])


def test_without_fitted_weights_the_surest_counts_by_what_it_is_worth_alone() -> None:
    found = [seen((0, 0.7, A)), seen((0, 0.9, A))]
    one, _ = fused(found, NAMES, KNOWS, "renderings", WEIGHTS)
    assert odds(float(one.scores[0])) == pytest.approx(max(odds(0.7), odds(0.9) - 3), abs=1e-5)
    nothing, places = fused([seen(), seen()], NAMES, KNOWS, "photographs", WEIGHTS)
    assert not len(nothing.scores)
    assert places.which.shape == (0, 2)


def test_a_third_voice_leaves_the_others_weights_as_they_are() -> None:
    """As a second look is one, which knows one class alone."""
    knows = np.vstack([KNOWS, [False, False, True]])
    found = [seen((0, 0.7, A), (2, 0.2, B)), seen(), seen((2, 0.8, B))]
    one, _ = fused(found, (*NAMES, "again"), knows, "photographs", WEIGHTS)
    assert one.labels.tolist() == [2, 0]
    assert one.scores[0] == pytest.approx(0.8)
    assert odds(float(one.scores[1])) == pytest.approx(0.5 * odds(0.7) + 1.0 - 2.0, abs=1e-4)


def test_the_committed_weights_are_of_the_default_detectors() -> None:
    weights = read_weights()
    assert weights.home["rfnav-det"] == weights.home["rfnav-det-clean"] == "renderings"
    assert weights.home["nanodet-g"] == weights.home["rfnav-det-photos"] == "photographs"
    assert (("rfnav-det", "nanodet-g"), "photographs") in weights.together
    assert all(line.gain > 0 for line in weights.alone.values())


@pytest.mark.parametrize(
    "text",
    ["", "[detectors.x]\nhome = 'paintings'\n", "[detectors.x]\nhome = 'photographs'\n", "["],
)
def test_weights_of_no_use_are_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "fusion.toml"
    path.write_text(text)
    with pytest.raises(ModelFileError, match=rf"^{path}: not weights of detectors .*train\.fuse"):
        read_weights(path)
