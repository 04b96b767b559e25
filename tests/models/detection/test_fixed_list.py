"""YOLO files with a fixed class list: each layout, matching by meaning, bad lists."""

from pathlib import Path

import numpy as np
import pytest
from places import SHARED

from models.detection.detector import open_detector
from models.detection.imported import describe
from models.errors import ModelFileError
from models.words.class_maps import coco_names
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary

SIZE = (64, 96)
CELLS = 8 * 12 + 4 * 6 + 2 * 3
NAMES = "{0: 'couch', 1: 'giraffe', 2: 'tv'}"
CLASSES = (("sofa",), ("television", "tv"), ("toilet",))
REAL = SHARED / "models" / "yolox_nano.onnx"


def v8() -> np.ndarray:
    out = np.zeros((1, 7, CELLS), np.float32)
    out[0, :, 0] = (48, 32, 40, 20, 0.9, 0.0, 0.0)
    out[0, :, 1] = (48, 32, 40, 22, 0.6, 0.0, 0.0)
    out[0, :, 2] = (20, 20, 10, 10, 0.0, 0.8, 0.0)
    return out


def v5() -> np.ndarray:
    out = np.zeros((1, 3 * CELLS, 8), np.float32)
    out[0, 7] = (48, 32, 40, 20, 0.9, 1.0, 0.0, 0.0)
    return out


def yolox() -> np.ndarray:
    out = np.zeros((1, CELLS, 8), np.float32)
    cell = 8 * 12 + 2 * 6 + 3  # stride 16, row 2, column 3
    out[0, cell] = (0.0, 0.0, np.log(40 / 16), np.log(20 / 16), 0.9, 1.0, 0.0, 0.0)
    return out


@pytest.mark.parametrize("layout", [v5, v8, yolox])
def test_layouts_give_the_same_box(layout, constant_graph, encoder: TextEncoder) -> None:
    path = constant_graph({"out": layout()}, SIZE, {"names": NAMES})
    detector = open_detector(path, "auto", encoder)
    assert detector.capabilities["classes"] == ["couch", "giraffe", "tv"]
    assert not detector.capabilities["open_vocabulary"]
    detector.set_vocabulary(CLASSES, ())
    matched = detector.capabilities["matched"]
    assert matched.keys() == {"sofa", "television"}
    assert 0.6 <= matched["sofa"]["couch"] <= 1
    assert detector.capabilities["unseen"] == ["toilet"]
    seen = detector.detect(np.zeros((128, 192, 3), np.uint8))
    np.testing.assert_allclose(seen.boxes_px, [[56, 44, 136, 84]], atol=1e-3)
    np.testing.assert_allclose(seen.scores, [0.9], atol=1e-5)
    assert seen.labels.tolist() == [0]
    assert seen.embeddings.shape == (1, 0)
    assert seen.rooms.shape == (0,)


def test_a_place_may_be_called_two_things(constant_graph, encoder: TextEncoder) -> None:
    out = v8()
    out[0, 6, 0] = 0.3  # a couch of 0.9 that may be a tv
    detector = open_detector(constant_graph({"out": out}, SIZE, {"names": NAMES}), "yolo", encoder)
    detector.set_vocabulary(CLASSES, ())
    seen = detector.detect(np.zeros((*SIZE, 3), np.uint8))
    assert seen.labels.tolist() == [0, 1]
    np.testing.assert_allclose(seen.scores, [0.9, 0.3], atol=1e-5)
    np.testing.assert_allclose(seen.boxes_px[0], seen.boxes_px[1])


def test_a_calibration_in_the_file_makes_scores_chances(
    constant_graph, encoder: TextEncoder
) -> None:
    def seen(**values: str) -> np.ndarray:
        metadata = {"names": NAMES, **{f"value.{k}": v for k, v in values.items()}}
        detector = open_detector(constant_graph({"out": out}, SIZE, metadata), "auto", encoder)
        detector.set_vocabulary(CLASSES, ())
        return detector.detect(np.zeros((*SIZE, 3), np.uint8)).scores

    out = np.zeros((1, 7, CELLS), np.float32)
    out[0, :, 0] = (20, 32, 30, 20, 0.9, 0.0, 0.0)
    out[0, :, 1] = (70, 32, 30, 20, 0.0, 0.0, 0.4)
    out[0, :, 2] = (48, 12, 30, 10, 0.05, 0.0, 0.0)
    out[0, :, 3] = (48, 55, 30, 10, np.inf, 0.0, 0.0)  # nothing, before and after
    np.testing.assert_array_equal(seen(), np.float32([0.9, 0.4, 0.05]))
    np.testing.assert_array_equal(seen(gain="1.0", shift="0"), seen())
    # odds 9, 2/3 and 1/19, squared and doubled; the weakest is kept, too
    settled = seen(gain="2", shift=repr(np.log(2.0).item()))
    np.testing.assert_allclose(settled, [162 / 163, 8 / 17, 2 / 363], rtol=1e-5)


@pytest.mark.parametrize(
    ("key", "value", "must"),
    [
        ("gain", "two", "a finite number"),
        ("gain", "nan", "a finite number"),
        ("shift", "-inf", "a finite number"),
        ("shift", "", "a finite number"),
        ("gain", "0", "above 0"),
        ("gain", "-1.5", "above 0"),
    ],
)
def test_a_damaged_calibration_is_one_line(
    key: str, value: str, must: str, constant_graph, encoder: TextEncoder
) -> None:
    metadata = {"names": NAMES, f"value.{key}": value}
    path = constant_graph({"out": v8()}, SIZE, metadata)
    said = rf"graph\.onnx: value\.{key} \S+ of no use; it must be {must}$"
    with pytest.raises(ModelFileError, match=said):
        open_detector(path, "auto", encoder)


def test_odd_frames(constant_graph, encoder: TextEncoder) -> None:
    path = constant_graph({"out": v8() * 0}, SIZE, {"names": NAMES})
    detector = open_detector(path, "auto", encoder)
    detector.set_vocabulary(CLASSES, ())
    for shape in ((1, 1, 3), (3, 999, 3), (480, 640, 3)):
        assert len(detector.detect(np.zeros(shape, np.uint8)).scores) == 0


def test_a_class_list_of_the_wrong_length(
    constant_graph, tmp_path: Path, encoder: TextEncoder
) -> None:
    path = constant_graph({"out": v8()}, SIZE)
    with pytest.raises(ModelFileError, match=r"its 3 classes have no names; give a text file"):
        open_detector(path, "auto", encoder)
    names = tmp_path / "names.txt"
    names.write_text("couch\ngiraffe\n")
    with pytest.raises(ModelFileError, match=r"names\.txt: 2 names for 3 classes"):
        open_detector(path, "auto", encoder, classes_file=names)
    names.write_text("couch\ngiraffe\ntv\n\n")
    assert open_detector(path, "auto", encoder, classes_file=names).capabilities["classes"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the class list is empty"),
        ("a\n" * 2001, "2001 names; at most 2000"),
        ("sofa\n\ntv\n", "a class name is blank"),
        ("x" * 101 + "\n", "101 characters; at most 100"),
        ("a\n\x1b[2Jb\nc\n", "holds what cannot be printed"),
    ],
)
def test_bad_class_files(
    text: str, said: str, constant_graph, tmp_path: Path, encoder: TextEncoder
) -> None:
    path = constant_graph({"out": v8()}, SIZE)
    names = tmp_path / "names.txt"
    names.write_text(text)
    with pytest.raises(ModelFileError, match=said):
        open_detector(path, "auto", encoder, classes_file=names)


def test_an_unknown_layout_is_refused(constant_graph, encoder: TextEncoder) -> None:
    odd = np.zeros((1, 77, 7), np.float32)
    path = constant_graph({"out": odd}, SIZE, {"names": NAMES})
    with pytest.raises(ModelFileError, match="of no known layout; expected"):
        open_detector(path, "auto", encoder)


@pytest.mark.skipif(not REAL.exists(), reason="needs a copy of YOLOX-Nano")
def test_a_real_yolox_runs(tmp_path: Path, encoder: TextEncoder) -> None:
    names = tmp_path / "names.txt"
    names.write_text("".join(f"thing {i}\n" for i in range(57)) + "couch\n" + "other\n" * 22)
    detector = open_detector(REAL, "auto", encoder, classes_file=names)
    detector.set_vocabulary(CLASSES, ())
    noise = np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)
    assert len(detector.detect(noise).scores) < 5


def test_cocos_list_is_matched_by_its_map(constant_graph, encoder: TextEncoder) -> None:
    names = coco_names()
    out = np.zeros((1, 84, CELLS), np.float32)
    for place, name in enumerate(("horse", "couch", "bear", "suitcase")):
        out[0, :4, place] = (10 + 20 * place, 30, 16, 20)
        out[0, 4 + names.index(name), place] = 0.9
    path = constant_graph({"out": out}, SIZE, {"names": str(dict(enumerate(names)))})
    detector = open_detector(path, "auto", encoder)
    words = load_vocabulary()
    classes = (*words.objects, ("suitcase",))
    detector.set_vocabulary(classes, words.rooms)
    seen = detector.detect(np.zeros((64, 96, 3), np.uint8))
    assert {classes[k][0] for k in seen.labels} == {"sofa", "suitcase"}
    assert detector.capabilities["matched"]["sofa"] == {"couch": 1.0}
    assert "drying rack" in detector.capabilities["unseen"]
    assert "classes: a fixed list of 80, COCO's, each read as one of ours or none" in describe(
        detector.capabilities
    )
