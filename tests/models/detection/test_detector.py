"""The open-vocabulary detector's contract, on a small graph whose answers are known."""

from pathlib import Path

import numpy as np
import pytest

from models.detection.detector import OpenDetector, open_detector
from models.errors import ModelFileError
from models.words.text_encoder import TextEncoder

METADATA = {
    "format": "rf-nav-detector/1",
    "value.scale": "20.0",
    "value.bias": "-12.0",
    "value.room_scale": "10.0",
}
ROOMS = ("kitchen", "bathroom")


@pytest.fixture
def detector(constant_graph, encoder: TextEncoder) -> OpenDetector:
    toilet, sofa, bathroom = encoder.embed(["toilet", "sofa", "a bathroom"])
    outputs = {
        "boxes": np.array([[[10, 10, 60, 60], [12, 10, 60, 60], [0, 20, 96, 50]]], np.float32),
        "objectness": np.array([[0.9, 0.8, 0.01]], np.float32),
        "embeddings": np.stack((toilet, toilet, sofa))[None],
        "scene": bathroom[None],
    }
    path = constant_graph(outputs, (64, 96), METADATA)
    found = open_detector(path, "rfnav", encoder)
    assert isinstance(found, OpenDetector)
    return found


def test_detections_follow_the_vocabulary(detector: OpenDetector) -> None:
    frame = np.zeros((64, 96, 3), np.uint8)
    detector.set_vocabulary((("bed",), ("loo", "toilet")), ROOMS)
    seen = detector.detect(frame)
    # one thing, which might be another; what is in the same place and less sure is left out
    np.testing.assert_allclose(seen.boxes_px, [[10, 10, 60, 60]] * 2, atol=1e-4)
    assert seen.labels.tolist() == [1, 0]
    assert seen.scores[1] < 0.1 < 0.8 < seen.scores[0] < 0.9
    assert seen.embeddings.shape == (2, 384)
    assert seen.rooms.argmax() == 1
    assert seen.rooms.sum() == pytest.approx(1, abs=1e-5)
    detector.set_vocabulary((("bicycle",),), ())
    seen = detector.detect(frame)
    assert len(seen.scores) == 0
    assert seen.boxes_px.shape == (0, 4)
    assert seen.embeddings.shape == (0, 384)
    assert seen.rooms.shape == (0,)


@pytest.mark.parametrize("shape", [(1, 1, 3), (480, 640, 3), (7, 1000, 3)])
def test_any_frame_size(detector: OpenDetector, shape: tuple[int, ...]) -> None:
    detector.set_vocabulary((("toilet",),), ROOMS)
    seen = detector.detect(np.zeros(shape, np.uint8))
    limit = [shape[1], shape[0]] * 2
    assert (seen.boxes_px >= 0).all()
    assert (seen.boxes_px <= limit).all()


@pytest.mark.parametrize(
    "frame", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), np.uint8)]
)
def test_what_is_no_frame(detector: OpenDetector, frame: np.ndarray) -> None:
    detector.set_vocabulary((("toilet",),), ROOMS)
    with pytest.raises(ModelFileError, match="a frame is"):
        detector.detect(frame)


@pytest.mark.parametrize(
    ("classes", "said"),
    [
        ((), "the class list is empty"),
        ((("a",),) * 2001, "2001 names; at most 2000"),
        ((("so\nfa",),), "holds a line break"),
        ((("x" * 101,),), "101 characters"),
        (((" ",),), "is blank"),
        (((),), "at least one name"),
    ],
)
def test_bad_vocabularies(detector: OpenDetector, classes, said: str) -> None:
    with pytest.raises(ModelFileError, match=said):
        detector.set_vocabulary(classes, ROOMS)


def test_a_frame_before_a_vocabulary(detector: OpenDetector) -> None:
    with pytest.raises(ModelFileError, match="has no vocabulary"):
        detector.detect(np.zeros((8, 8, 3), np.uint8))


def test_files_that_are_no_detector(constant_graph, tmp_path: Path, encoder: TextEncoder) -> None:
    with pytest.raises(ModelFileError, match=r"none\.onnx: no such model file"):
        open_detector(tmp_path / "none.onnx", "rfnav", encoder)
    (tmp_path / "bad.onnx").write_bytes(b"\x08\x01garbage")
    with pytest.raises(ModelFileError, match=r"bad\.onnx: not a usable ONNX file"):
        open_detector(tmp_path / "bad.onnx", "rfnav", encoder)
    other = constant_graph({"out": np.zeros((1, 7, 3))}, (64, 96))
    with pytest.raises(ModelFileError, match="not an RF-NAV detector"):
        open_detector(other, "rfnav", encoder)
