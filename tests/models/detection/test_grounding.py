"""Networks that take a caption: the goal's own boxes are found; what does not fit together."""

from pathlib import Path

import numpy as np
import pytest
from baseline_graphs import grounding_network

from models.detection.detector import open_detector
from models.detection.grounding import GroundingDetector
from models.detection.told import IMAGENET
from models.errors import ModelFileError
from models.words.text_encoder import TextEncoder

CLASSES = (("toilet", "loo"), ("sofa",), ("coffee table",))
BOXES = ((0.25, 0.5, 0.5, 1.0), (0.75, 0.25, 0.2, 0.3), (0.5, 0.5, 0.1, 0.1), (0.9, 0.9, 0.4, 0.4))
WORDS = ("sofa", "toilet", "[CLS]", "table")
WHITE = np.full((100, 200, 3), 255, np.uint8)
MEAN, STD = np.array(IMAGENET[1:]) / 255
BRIGHT = float(((1 - MEAN) / STD).mean())  # what the network sees of a white image, 2.4


@pytest.mark.parametrize("length", ["t", 12])
def test_the_goal_alone_is_found(length: int | str, tmp_path: Path, encoder: TextEncoder) -> None:
    path = grounding_network(tmp_path / "g.onnx", BOXES, WORDS, length)
    detector = open_detector(path, "auto", encoder)
    assert isinstance(detector, GroundingDetector)
    assert detector.capabilities["contract"] == "grounding"
    detector.set_vocabulary(CLASSES, ("kitchen",))
    assert not len(detector.detect(WHITE).scores)  # no goal yet
    for goal, box in ((0, [130, 10, 170, 40]), (1, [0, 0, 100, 100]), (2, [140, 70, 200, 100])):
        detector.look_for(goal)
        seen = detector.detect(WHITE)
        assert seen.labels.tolist() == [goal]
        np.testing.assert_allclose(seen.boxes_px, [box], atol=1e-3)  # inside the image
    detector.look_for(0)
    wanted = np.exp(BRIGHT) / (np.exp(BRIGHT) + np.e)
    assert detector.detect(WHITE).scores[0] == pytest.approx(wanted, abs=1e-3)
    assert not len(detector.detect(np.zeros_like(WHITE)).scores)  # "no object" outweighs it


def test_every_token_of_the_name_counts(tmp_path: Path, encoder: TextEncoder) -> None:
    path = grounding_network(tmp_path / "g.onnx", BOXES, WORDS)
    detector = open_detector(path, "grounding", encoder)
    grey = np.full((10, 10, 3), 175, np.uint8)
    token = np.exp(((175 / 255 - MEAN) / STD).mean())
    for goal, times in (("table", 1), ("table table", 2)):
        detector.set_vocabulary(((goal,),), ())
        detector.look_for(0)
        wanted = times * token / (times * token + np.e)
        assert detector.detect(grey).scores == pytest.approx([wanted], abs=1e-3)
    deaf = grounding_network(tmp_path / "d.onnx", BOXES, WORDS, heard=3)  # the first and two tables
    detector = open_detector(deaf, "grounding", encoder)
    detector.set_vocabulary((("table table table table",),), ())
    detector.look_for(0)
    assert detector.detect(grey).scores == pytest.approx([wanted], abs=1e-3)


def test_odd_pictures(tmp_path: Path, encoder: TextEncoder) -> None:
    detector = open_detector(grounding_network(tmp_path / "g.onnx", BOXES, WORDS), "auto", encoder)
    detector.set_vocabulary(CLASSES, ())
    detector.look_for(1)
    for shape in ((1, 1), (1, 3000), (600, 800)):
        seen = detector.detect(np.full((*shape, 3), 255, np.uint8))
        assert (seen.boxes_px >= 0).all()
        assert (seen.boxes_px <= [*shape[::-1], *shape[::-1]]).all()
    with pytest.raises(ModelFileError, match="a frame is"):
        detector.detect(np.zeros((4, 4), np.uint8))


def test_what_does_not_fit(tmp_path: Path, constant_graph, encoder: TextEncoder) -> None:
    other = constant_graph({"out": np.zeros((1, 5, 4))}, (16, 16))
    with pytest.raises(ModelFileError, match=r"inputs \['image'\]; expected an image"):
        open_detector(other, "grounding", encoder)
    odd = grounding_network(tmp_path / "n.onnx", [(*box, 1.0) for box in BOXES], WORDS)
    with pytest.raises(ModelFileError, match=r"\[1, 4, 5\]\]; expected boxes \(1, Q, 4\) and log"):
        open_detector(odd, "auto", encoder)
    path = grounding_network(tmp_path / "g.onnx", BOXES, WORDS)
    tokenizer = tmp_path / "tokenizer.json"
    tokenizer.write_text("{}")
    with pytest.raises(ModelFileError, match=r"tokenizer\.json: damaged"):
        open_detector(path, "auto", encoder)
    tokenizer.unlink()
    with pytest.raises(ModelFileError, match=r"tokenizer\.json: missing; give the network's to"):
        open_detector(path, "auto", encoder)
