"""What a robot's camera and a person's words may bring: a clear error or an empty answer."""

import os
from pathlib import Path

import numpy as np
import pytest

from models.detection.detections import RawDetections, boxes_only
from models.detection.detector import open_detector
from models.errors import ModelFileError
from models.words.text_encoder import TextEncoder

SIZE = (32, 32)
CELLS = 16 + 4 + 1
METADATA = {
    "format": "rf-nav-detector/1",
    "value.scale": "20.0",
    "value.bias": "-14.0",
    "value.room_scale": "10.0",
}
VOCABULARY = (("sofa", "couch"), ("toilet",))


@pytest.fixture(params=["rfnav", "prompted", "yolo"])
def detector(request, constant_graph, prompted_graph, tmp_path: Path, encoder: TextEncoder):
    """One of each contract, that sees one sofa."""
    box, row = np.array([[4, 4, 20, 20]], np.float32), encoder.embed(["sofa"])
    if request.param == "rfnav":
        outputs = {"boxes": box[None], "objectness": np.array([[0.9]]), "embeddings": row[None]}
        path = constant_graph({**outputs, "scene": row}, SIZE, METADATA)
        return open_detector(path, "auto", encoder)
    if request.param == "prompted":
        np.savez(tmp_path / "rows.npz", sofa=row[0], toilet=-row[0])
        path = prompted_graph(box, row, SIZE)
        return open_detector(path, "auto", encoder, texts=tmp_path / "rows.npz")
    out = np.zeros((1, 6, CELLS), np.float32)
    out[0, :, 0] = (12, 12, 16, 16, 0.9, 0)
    return open_detector(
        constant_graph({"o": out}, SIZE, {"names": "['sofa', 'bed']"}), "auto", encoder
    )


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 5000, 3), (480, 640, 3)])
@pytest.mark.parametrize("level", [0, 255])
def test_plain_frames_of_any_size(detector, shape: tuple[int, ...], level: int) -> None:
    detector.set_vocabulary(VOCABULARY, ())
    seen = detector.detect(np.full(shape, level, np.uint8))
    assert np.isfinite(seen.boxes_px).all()
    assert (seen.boxes_px <= [shape[1], shape[0]] * 2).all()
    assert set(seen.labels.tolist()) <= {0}


@pytest.mark.parametrize(
    "frame",
    [
        np.zeros((0, 0, 3), np.uint8),
        np.zeros((4, 4), np.uint8),
        np.zeros((4, 4, 4), np.uint8),
        np.zeros((4, 4, 3), np.float32),
    ],
)
def test_what_is_no_frame(detector, frame: np.ndarray) -> None:
    detector.set_vocabulary(VOCABULARY, ())
    with pytest.raises(ModelFileError, match="a frame is"):
        detector.detect(frame)


@pytest.mark.parametrize(
    ("classes", "said"),
    [
        ((), "the class list is empty"),
        ([(f"thing {i}",) for i in range(2001)], "2001 names; at most 2000"),
        ((("so\nfa",),), "holds a line break"),
        ((("x" * 10_000,),), "10000 characters; at most 100"),
        ((("\t",),), "is blank"),
    ],
)
def test_bad_vocabularies_leave_the_last_one(detector, classes, said: str) -> None:
    detector.set_vocabulary(VOCABULARY, ())
    with pytest.raises(ModelFileError, match=said):
        detector.set_vocabulary(classes, ())
    assert detector.detect(np.zeros((*SIZE, 3), np.uint8)).labels.tolist() == [0]


def test_as_many_classes_as_are_allowed(constant_graph, encoder: TextEncoder) -> None:
    out = np.zeros((1, 6, CELLS), np.float32)
    path = constant_graph({"o": out}, SIZE, {"names": "['sofa', 'bed']"})
    detector = open_detector(path, "auto", encoder)
    names = [(f"{a}{b}",) for a in "abcdefghij" for b in range(200)]
    few = encoder.embed(["sofa"])  # 2,000 embeddings would take seconds, and say nothing more
    encoder._memo.update({name: few for (name,) in names})
    detector.set_vocabulary(names, ())
    assert len(detector.detect(np.zeros((*SIZE, 3), np.uint8)).scores) == 0


def test_boxes_that_are_not_finite_are_not_there() -> None:
    boxes = np.array([[0, 0, 5, 5], [np.nan, 0, 5, 5], [0, 0, np.inf, 5]], np.float32)
    scores = np.array([np.nan, 0.9, 0.9], np.float32)
    seen: RawDetections = boxes_only(boxes, scores, np.zeros(3, np.int32))
    assert len(seen.scores) == 0


def test_thousands_of_frames_take_no_more_memory(detector) -> None:
    detector.set_vocabulary(VOCABULARY, ())
    frame = np.zeros((24, 32, 3), np.uint8)
    for _ in range(200):
        detector.detect(frame)
    before = _resident_mb()
    for k in range(4000):
        if k % 500 == 0:
            detector.set_vocabulary(VOCABULARY, ())
        detector.detect(frame)
    assert _resident_mb() - before < 4  # 4,000 embeddings that nobody forgot would be 6 MB


def _resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
