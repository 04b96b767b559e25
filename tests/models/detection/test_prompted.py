"""Detectors that take embedded texts: shapes of inputs and outputs, rows and towers."""

import shutil
from pathlib import Path

import numpy as np
import onnx
import pytest

from models.detection.detector import open_detector
from models.detection.prompted import TowerPrompts, open_prompts
from models.errors import ModelFileError
from models.store import manifest
from models.words.text_encoder import TextEncoder

SIZE = (64, 96)
BOXES = np.array([[10, 10, 60, 60], [70, 5, 90, 25]], np.float32)
ROWS = np.eye(4, dtype=np.float32)
NAMES = {"sofa": ROWS[0], "couch": ROWS[1], "toilet": ROWS[2]}


@pytest.fixture
def texts(tmp_path: Path) -> Path:
    path = tmp_path / "rows.npz"
    np.savez(path, **{name: 3 * row for name, row in NAMES.items()})
    return path


@pytest.mark.parametrize("slots", ["n", 5])
@pytest.mark.parametrize(("batched", "joined"), [(False, False), (True, False), (True, True)])
def test_texts_are_asked_for_and_the_best_name_counts(
    slots, batched: bool, joined: bool, prompted_graph, texts: Path, encoder: TextEncoder
) -> None:
    regions = np.array([[0.2, 0.9, 0, 0], [0, 0, 0.7, 0]], np.float32)
    path = prompted_graph(BOXES, regions, SIZE, slots, batched, joined)
    detector = open_detector(path, "auto", encoder, texts=texts)
    assert detector.capabilities["contract"] == "prompted"
    detector.set_vocabulary((("giraffe",), ("toilet", "loo"), ("sofa", "couch")), ("kitchen",))
    assert detector.capabilities["unseen"] == ["giraffe"]
    assert detector.capabilities["matched"] == {"toilet": ["toilet"], "sofa": ["sofa", "couch"]}
    seen = detector.detect(np.zeros((128, 192, 3), np.uint8))
    np.testing.assert_allclose(seen.boxes_px, BOXES * 2, atol=1e-3)
    np.testing.assert_allclose(seen.scores, [0.9, 0.7], atol=1e-6)
    assert seen.labels.tolist() == [2, 1]
    assert seen.embeddings.shape == (2, 0)
    detector.set_vocabulary((("giraffe",),), ())
    assert len(detector.detect(np.zeros((1, 1, 3), np.uint8)).scores) == 0


def test_four_texts_are_told_from_four_corners(
    prompted_graph, texts: Path, encoder: TextEncoder
) -> None:
    regions = np.array([[0, 0.9, 0, 0], [0, 0, 0.7, 0]], np.float32)
    detector = open_detector(prompted_graph(BOXES, regions, SIZE), "auto", encoder, texts=texts)
    detector.set_vocabulary((("sofa", "couch", "toilet"), ("sofa",)), ())
    seen = detector.detect(np.zeros((*SIZE, 3), np.uint8))
    np.testing.assert_allclose(seen.boxes_px, BOXES, atol=1e-3)
    assert seen.labels.tolist() == [0, 0]


def test_a_network_that_answers_with_nan_sees_nothing(
    prompted_graph, texts: Path, encoder: TextEncoder
) -> None:
    path = prompted_graph(BOXES * np.nan, np.full((2, 4), np.nan, np.float32), SIZE)
    detector = open_detector(path, "auto", encoder, texts=texts)
    detector.set_vocabulary((("sofa",),), ())
    assert len(detector.detect(np.zeros((*SIZE, 3), np.uint8)).scores) == 0


@pytest.mark.parametrize("joined", [False, True])
def test_logits_and_a_calibration(
    joined: bool, prompted_graph, texts: Path, encoder: TextEncoder
) -> None:
    """Scores outside of 0..1 are logits; gain and shift act on what they are then."""
    regions = np.array([[np.log(3), -6, -6, -6], [-6, -6, 0, -6]], np.float32)
    path = prompted_graph(BOXES, regions, SIZE, joined=joined)
    detector = open_detector(path, "auto", encoder, texts=texts)
    detector.set_vocabulary((("sofa",), ("toilet",)), ())
    seen = detector.detect(np.zeros((*SIZE, 3), np.uint8))
    np.testing.assert_allclose(seen.scores, [3 / 4, 1 / 2], rtol=1e-5)
    model = onnx.load(str(path))
    onnx.helper.set_model_props(model, {"value.gain": "2", "value.shift": str(np.log(3))})
    onnx.save(model, str(path))
    detector = open_detector(path, "auto", encoder, texts=texts)
    detector.set_vocabulary((("sofa",), ("toilet",)), ())
    seen = detector.detect(np.zeros((*SIZE, 3), np.uint8))
    np.testing.assert_allclose(seen.scores, [27 / 28, 3 / 4], rtol=1e-5)


def test_rows_that_do_not_fit(prompted_graph, tmp_path: Path, encoder: TextEncoder) -> None:
    path = prompted_graph(BOXES, np.zeros((2, 4), np.float32), SIZE, 2)
    with pytest.raises(ModelFileError, match="takes embedded texts; give them"):
        open_detector(path, "auto", encoder)
    other = tmp_path / "other.npz"
    np.savez(other, sofa=np.ones(7, np.float32))
    with pytest.raises(ModelFileError, match="texts have 4 values, the rows given 7"):
        open_detector(path, "auto", encoder, texts=other)
    np.savez(other, **{f"thing {i}": ROWS[0] for i in range(3)})
    detector = open_detector(path, "auto", encoder, texts=other)
    with pytest.raises(ModelFileError, match="takes 2 texts, not 3"):
        detector.set_vocabulary([(f"thing {i}",) for i in range(3)], ())


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ({"sofa": np.ones((2, 3))}, "every array must be one row"),
        ({"sofa": np.ones(3), "bed": np.ones(4)}, "every array must be one row"),
        ({"sofa": np.zeros(3)}, "zero or not finite"),
        ({"so\nfa": np.ones(3)}, "holds a line break"),
        ({"x" * 10_000: np.ones(3)}, "10000 characters; at most 100"),
        ({}, "the class list is empty"),
    ],
)
def test_bad_rows(rows, said: str, tmp_path: Path) -> None:
    path = tmp_path / "rows.npz"
    if any(len(name) > 200 for name in rows):  # too long for a zip's member on some systems
        import zipfile

        with zipfile.ZipFile(path, "w") as archive:
            for name, row in rows.items():
                with archive.open(name + ".npy", "w") as member:
                    np.lib.format.write_array(member, np.asarray(row))
    else:
        np.savez(path, **rows)
    with pytest.raises(ModelFileError, match=said):
        open_prompts(path)


def test_files_that_are_no_rows(tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match="no such file"):
        open_prompts(tmp_path / "none.npz")
    (tmp_path / "bad.npz").write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(ModelFileError, match=r"not a readable \.npz"):
        open_prompts(tmp_path / "bad.npz")


@pytest.fixture
def tower(tmp_path: Path) -> Path:
    """A text tower: the mean id of the tokens, and their count, as a row of two."""
    from onnx import TensorProto, helper, numpy_helper, save

    ids = helper.make_tensor_value_info("input_ids", TensorProto.INT64, [1, 16])
    row = helper.make_tensor_value_info("text_embeds", TensorProto.FLOAT, [1, 2])
    nodes = [
        helper.make_node("Cast", ["input_ids"], ["x"], to=TensorProto.FLOAT),
        helper.make_node("ReduceSum", ["x", "axis"], ["sum"], keepdims=1),
        helper.make_node("Sign", ["x"], ["any"]),
        helper.make_node("ReduceSum", ["any", "axis"], ["count"], keepdims=1),
        helper.make_node("Concat", ["sum", "count"], ["text_embeds"], axis=1),
    ]
    axis = numpy_helper.from_array(np.array([1], np.int64), "axis")
    graph = helper.make_graph(nodes, "tower", [ids], [row], [axis])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    (tmp_path / "tower").mkdir()
    save(model, str(tmp_path / "tower" / "text.onnx"))
    shutil.copy(manifest.fetch("minilm") / "tokenizer.json", tmp_path / "tower")
    return tmp_path / "tower" / "text.onnx"


def test_a_tower_embeds_any_text(tower: Path) -> None:
    prompts = open_prompts(tower)
    assert isinstance(prompts, TowerPrompts)
    assert prompts.dimension == 2
    one, other = prompts.row("sofa"), prompts.row("a very long sofa " * 20)
    assert one is not None
    assert other is not None
    assert np.linalg.norm(one) == pytest.approx(1)
    assert not np.allclose(one, other)
    (tower.parent / "tokenizer.json").unlink()
    with pytest.raises(ModelFileError, match=r"tokenizer\.json: missing; put the tower's there"):
        open_prompts(tower)


def test_a_tower_of_other_inputs_is_refused(constant_graph, tower: Path) -> None:
    shutil.copy(constant_graph({"out": np.zeros((1, 2))}, (8, 8)), tower)
    with pytest.raises(ModelFileError, match="no text tower's; expected input_ids"):
        open_prompts(tower)
