"""Towers of CLIP's kind: each way finds the right place and class; what does not fit together."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from baseline_graphs import MEANS, WIDTH, image_tower, sentence_row, text_tower

from models.detection.clip import PLACED, SENTENCE, ClipDetector, patches, regions
from models.detection.detector import open_detector
from models.errors import ModelFileError
from models.words.text_encoder import TextEncoder

CLASSES = (("sofa",), ("toilet", "loo"), ("giraffe",))
SOFA, TOILET, GIRAFFE = range(3)
RED, GREEN, BLUE = np.eye(3, dtype=np.uint8) * 255


@pytest.fixture
def texts(tmp_path: Path) -> Path:
    """Rows of all sentences that are asked for, but the giraffe's."""
    words = [word for word in MEANS if word not in ("left", "right", "top", "bottom")]
    sentences = [s.format(word) for word in words for s in (SENTENCE, *PLACED)]
    np.savez(tmp_path / "texts.npz", **{s: sentence_row(s) for s in sentences})
    return tmp_path / "texts.npz"


def opened(image: Path, texts: Path, encoder: TextEncoder) -> ClipDetector:
    detector = open_detector(image, "auto", encoder, texts=texts)
    assert isinstance(detector, ClipDetector)
    detector.set_vocabulary(CLASSES, ())
    return detector


def room(things: dict[tuple[int, int], np.ndarray]) -> np.ndarray:
    """A green image of 80 rows and 120 columns, with squares of 40 px at (row, column)."""
    rgb = np.full((80, 120, 3), GREEN, np.uint8)
    for (row, column), colour in things.items():
        rgb[row : row + 40, column : column + 40] = colour
    return rgb


@pytest.mark.parametrize("batch", ["n", 1])
def test_patches_are_called_what_they_look_like(
    batch: int | str, tmp_path: Path, texts: Path, encoder: TextEncoder
) -> None:
    detector = opened(image_tower(tmp_path / "i.onnx", batch=batch), texts, encoder)
    assert detector.capabilities["contract"] == "clip"
    assert detector.capabilities["unseen"] == ["giraffe"]
    seen = detector.detect(room({(0, 0): BLUE, (40, 80): RED}))
    sure = seen.scores > 0.9
    found = dict(zip(seen.labels[sure].tolist(), seen.boxes_px[sure].tolist(), strict=True))
    assert found == {TOILET: [0, 0, 40, 40], SOFA: [80, 40, 120, 80]}
    assert not (detector.detect(room({})).scores > 0.1).any()  # walls are neither


def test_a_reference_sentence_says_where_the_goal_is(
    tmp_path: Path, texts: Path, encoder: TextEncoder
) -> None:
    detector = opened(image_tower(tmp_path / "i.onnx"), texts, encoder)
    detector.find_by("reference")
    picture = np.zeros((90, 120, 3), np.uint8)
    picture[:30, 80:] = BLUE
    assert not len(detector.detect(picture).scores)  # no goal yet
    detector.look_for(TOILET)
    seen = detector.detect(picture)
    np.testing.assert_allclose(seen.boxes_px, [[80, 0, 120, 30]], atol=1e-4)
    assert seen.labels.tolist() == [TOILET]
    assert seen.scores[0] > 0.5
    detector.look_for(SOFA)
    assert not (detector.detect(picture).scores > 0.1).any()
    detector.look_for(GIRAFFE)
    assert not len(detector.detect(picture).scores)
    unsure = opened(image_tower(tmp_path / "u.onnx", metadata={"value.scale": "3"}), texts, encoder)
    unsure.find_by("reference")
    unsure.look_for(TOILET)
    assert unsure.detect(picture).scores[0] < 0.3  # it is there, but hardly sooner than elsewhere


@pytest.mark.parametrize("rank", [3, 4])
def test_the_relevance_map_says_where_the_goal_is(
    rank: int, tmp_path: Path, texts: Path, encoder: TextEncoder
) -> None:
    detector = opened(image_tower(tmp_path / "i.onnx", grid=8, rank=rank), texts, encoder)
    assert detector.capabilities["contract"] == "clip with relevance"
    detector.find_by("grad")
    picture = np.zeros((80, 160, 3), np.uint8)
    picture[:40, :40] = picture[40:, 120:] = BLUE
    assert not len(detector.detect(picture).scores)  # no goal yet
    detector.look_for(TOILET)
    seen = detector.detect(picture)
    order = np.argsort(seen.boxes_px[:, 0])
    wanted = [[0, 0, 40, 40], [120, 40, 160, 80]]
    np.testing.assert_allclose(seen.boxes_px[order], wanted, atol=12)  # a map of 8 x 8 cells
    assert seen.labels.tolist() == [TOILET] * 2
    assert (seen.scores > 0.9).all()
    detector.look_for(GIRAFFE)
    assert not len(detector.detect(picture).scores)
    detector.look_for(SOFA)
    assert not len(detector.detect(picture).scores)
    faint = room({(20, 40): (GREEN + RED // 4)})  # where it is most alike, but in no way a sofa
    assert not (detector.detect(faint).scores > 0.1).any()


def test_a_tower_embeds_what_is_asked_for(tmp_path: Path, encoder: TextEncoder) -> None:
    tower = text_tower(tmp_path / "tower")
    detector = opened(image_tower(tmp_path / "i.onnx"), tower, encoder)
    assert detector.capabilities["unseen"] == []
    seen = detector.detect(room({(20, 60): RED}))
    assert (seen.labels[0], seen.boxes_px[0].tolist()) == (SOFA, [60, 20, 100, 60])


def test_scores_are_calibrated_by_the_file(
    tmp_path: Path, texts: Path, encoder: TextEncoder
) -> None:
    picture = room({(0, 0): BLUE})
    plain = opened(image_tower(tmp_path / "i.onnx"), texts, encoder).detect(picture)
    scale = {"value.scale": "5"}
    softer = opened(image_tower(tmp_path / "s.onnx", metadata=scale), texts, encoder)
    soft = softer.detect(picture).scores[0]
    assert soft < 0.99 < plain.scores[0]
    assert softer.detect(picture // 2).scores[0] == pytest.approx(soft, abs=0.02)
    told = {**scale, "value.gain": "0.5", "value.shift": "-1"}
    settled = opened(image_tower(tmp_path / "c.onnx", metadata=told), texts, encoder)
    odds = 0.5 * np.log(soft / (1 - soft)) - 1
    assert settled.detect(picture).scores[0] == pytest.approx(1 / (1 + np.exp(-odds)), abs=1e-5)


def test_odd_pictures(tmp_path: Path, texts: Path, encoder: TextEncoder) -> None:
    detector = opened(image_tower(tmp_path / "i.onnx", grid=4), texts, encoder)
    for way in ("patch", "reference", "grad"):
        detector.find_by(way)
        detector.look_for(TOILET)
        for shape in ((1, 1), (1, 3000), (3000, 2), (600, 800)):
            seen = detector.detect(np.zeros((*shape, 3), np.uint8))
            assert np.isfinite(seen.scores).all()
            assert (seen.boxes_px >= 0).all()
            assert (seen.boxes_px <= [*shape[::-1], *shape[::-1]]).all()
    with pytest.raises(ModelFileError, match="a frame is"):
        detector.detect(np.zeros((4, 4), np.uint8))


@pytest.mark.parametrize("shape", [(480, 640), (1, 1), (3, 900), (6000, 8000)])
def test_patches_cover_the_image(shape: tuple[int, int]) -> None:
    boxes = patches(*shape)
    assert len(boxes) <= 60
    assert (boxes[:, 2:] > boxes[:, :2]).all()
    assert boxes.min() == 0
    assert boxes[:, 2:].max(axis=0).tolist() == list(shape[::-1])
    for low, high in ((0, 2), (1, 3)):
        ends = sorted(set(zip(boxes[:, low].tolist(), boxes[:, high].tolist(), strict=True)))
        assert all(begin <= end for (_, end), (begin, _) in itertools.pairwise(ends))


def test_a_flat_map_shows_nothing() -> None:
    for level in (np.ones((4, 4), np.float32), np.full((4, 4), np.nan, np.float32)):
        boxes, peaks = regions(level, (16, 16), (80, 120))
        assert boxes.shape == (0, 4)
        assert not len(peaks)


def test_what_does_not_fit(
    tmp_path: Path, texts: Path, constant_graph, encoder: TextEncoder
) -> None:
    image = image_tower(tmp_path / "i.onnx")
    with pytest.raises(ModelFileError, match="takes embedded texts; give them, or its text tower"):
        open_detector(image, "auto", encoder)
    with pytest.raises(ModelFileError, match="gives no relevance map"):
        opened(image, texts, encoder).find_by("grad")
    with pytest.raises(ModelFileError, match="takes 4 of image at once"):
        opened(image_tower(tmp_path / "f.onnx", batch=4), texts, encoder)
    bad = image_tower(tmp_path / "b.onnx", metadata={"value.scale": "-3"})
    with pytest.raises(ModelFileError, match=r"value\.scale -3\.0 of no use; it must be above 0"):
        opened(bad, texts, encoder)
    np.savez(tmp_path / "wide.npz", **{SENTENCE.format("sofa"): np.ones(WIDTH + 1)})
    with pytest.raises(
        ModelFileError, match=r"outputs \[\(1, 6\)\]; expected \(1, 7\), the texts'"
    ):
        opened(image, tmp_path / "wide.npz", encoder)
    no_row = constant_graph({"out": np.zeros((1, 5, 4))}, (16, 16))
    with pytest.raises(ModelFileError, match=r"outputs \[\(1, 5, 4\)\]; expected \(1, 6\)"):
        open_detector(no_row, "clip", encoder, texts=texts)
    tower = text_tower(tmp_path / "tower")
    with pytest.raises(ModelFileError, match=r"inputs input_ids .* are no image tower's"):
        open_detector(tower, "clip", encoder, texts=texts)
    (tower.parent / "tokenizer.json").unlink()
    with pytest.raises(ModelFileError, match=r"tokenizer\.json: missing; put the tower's there"):
        opened(image, tower, encoder)
