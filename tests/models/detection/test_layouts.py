"""Layouts of other networks' outputs: told by shapes, names and values, or by somebody; decoded."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from numpy.typing import NDArray
from onnx import helper

from models.detection import fixed_list
from models.detection.detector import open_detector
from models.detection.fixed_list import FixedListDetector
from models.detection.layouts import possible
from models.errors import ModelFileError
from models.onnx_session import run
from models.store import manifest
from models.words.class_maps import coco_91, coco_names
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary

SIZE = (64, 96)
CELLS = 8 * 12 + 4 * 6 + 2 * 3
NAMES = {"names": "['couch', 'giraffe', 'tv']"}
CLASSES = (("sofa",), ("television", "tv"), ("toilet",))
FRAME = np.full((128, 96, 3), (10, 20, 30), np.uint8)
OFF = -8.0
"""A logit of next to nothing."""
Arrays = dict[str, NDArray[np.float32]]


def detr(columns: int = 3, **called: str) -> Arrays:
    """A couch to the left, a tv at the right; the second couch is another one, half over it."""
    logits = np.full((1, 5, columns), OFF, np.float32)
    boxes = np.full((1, 5, 4), 0.01, np.float32)
    logits[0, 0, 0], boxes[0, 0] = 2, (0.25, 0.5, 0.5, 0.5)
    logits[0, 1, 0], boxes[0, 1] = 1, (0.25, 0.5, 0.5, 0.4)
    logits[0, 3, 2], boxes[0, 3] = 0, (0.9, 0.5, 0.2, 0.25)
    return {called.get("logits", "logits"): logits, called.get("boxes", "pred_boxes"): boxes}


def opened(graph, outputs: Arrays, encoder: TextEncoder, **metadata: str) -> FixedListDetector:
    detector = open_detector(graph(outputs, SIZE, NAMES | metadata), "auto", encoder)
    assert isinstance(detector, FixedListDetector)
    detector.set_vocabulary(CLASSES, ())
    return detector


@pytest.mark.parametrize("called", [{}, {"logits": "a_scores", "boxes": "b"}])
def test_detr_is_stretched_and_nothing_is_suppressed(
    called: dict[str, str], constant_graph, encoder: TextEncoder
) -> None:
    detector = opened(constant_graph, detr(**called), encoder)
    assert detector.capabilities["contract"] == "detr"
    seen = detector.detect(FRAME)
    chances = 1 / (1 + np.exp(-np.array([2.0, 1, 0])))
    np.testing.assert_allclose(seen.scores, chances, rtol=1e-5)
    assert seen.labels.tolist() == [0, 0, 1]
    boxes = [[0, 32, 48, 96], [0, 38.4, 48, 89.6], [76.8, 48, 96, 80]]
    np.testing.assert_allclose(seen.boxes_px, boxes, atol=1e-4)


def test_detr_with_four_classes_is_told_by_its_names(constant_graph, encoder: TextEncoder) -> None:
    four = {"names": "['couch', 'giraffe', 'tv', 'bed']"}
    seen = opened(constant_graph, detr(4), encoder, **four).detect(FRAME)
    assert seen.labels.tolist() == [0, 0, 1]
    with pytest.raises(ModelFileError, match="of no known layout"):
        opened(constant_graph, detr(4, boxes="other"), encoder, **four)


def test_detr_with_a_column_for_nothing_is_a_softmax(constant_graph, encoder: TextEncoder) -> None:
    outputs = detr(4)
    outputs["logits"][0, :, 3] = 0
    outputs["logits"][0, [2, 4], 3] = 9
    seen = opened(constant_graph, outputs, encoder).detect(FRAME)
    shares = np.exp([2, OFF, OFF, 0])
    np.testing.assert_allclose(seen.scores[0], shares[0] / shares.sum(), rtol=1e-5)
    assert seen.labels.tolist() == [0, 0, 1]


def test_boxes_in_pixels_are_not_detrs(constant_graph, encoder: TextEncoder) -> None:
    outputs = detr()
    outputs["pred_boxes"] = outputs["pred_boxes"] * 640
    with pytest.raises(ModelFileError, match=r"outside of 0\.\.1, which is not layout detr"):
        opened(constant_graph, outputs, encoder)


def test_cocos_91_numbers_are_its_80_names(constant_graph, encoder: TextEncoder) -> None:
    outputs = detr(91, logits="labels", boxes="dets")
    outputs["labels"][0, 0, 0], outputs["labels"][0, 0, coco_91().index("couch")] = OFF, 2
    outputs["labels"][0, 1, 0] = OFF
    path = constant_graph(outputs, SIZE)  # no names are in it
    detector = open_detector(path, "auto", encoder)
    assert detector.capabilities["classes"] == list(coco_names())
    detector.set_vocabulary(CLASSES, ())
    assert detector.detect(FRAME).labels.tolist() == [0]
    for names in (coco_names(), [name or "N/A" for name in coco_91()]):
        named = constant_graph(outputs, SIZE, {"names": str(list(names))})
        assert open_detector(named, "auto", encoder).capabilities["classes"] == list(coco_names())


@pytest.mark.parametrize(
    ("outputs", "told", "first"),
    [
        (detr(), {}, np.array([10, 20, 30]) / 255),
        (
            detr(91, logits="labels", boxes="dets"),
            {"names": ""},
            (np.array([10, 20, 30]) - [123.675, 116.28, 103.53]) / [58.395, 57.12, 57.375],
        ),
        (
            detr(),
            {"normalise": "imagenet"},
            (np.array([10, 20, 30]) - [123.675, 116.28, 103.53]) / [58.395, 57.12, 57.375],
        ),
        (
            {"out": np.zeros((1, CELLS, 3 + 4 * 8), np.float32)},
            {},
            (np.array([30, 20, 10]) - [103.53, 116.28, 123.675]) / [57.375, 57.12, 58.395],
        ),
        ({"out": np.zeros((1, CELLS, 8), np.float32)}, {}, np.array([30, 20, 10])),
        ({"out": np.zeros((1, 7, CELLS), np.float32)}, {}, np.array([10, 20, 30]) / 255),
    ],
    ids=["detr", "rf-detr", "told", "nanodet", "X", "v8"],
)
def test_each_gets_its_images_as_it_was_trained(
    outputs: Arrays, told: dict[str, str], first: NDArray[np.float64], constant_graph,
    encoder: TextEncoder, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    detector = opened(constant_graph, outputs, encoder, **told)
    fed: list[NDArray[np.float32]] = []

    def spy(session, feeds, path):
        fed.extend(feeds.values())
        return run(session, feeds, path)

    monkeypatch.setattr(fixed_list, "run", spy)
    detector.detect(np.full((64, 96, 3), (10, 20, 30), np.uint8))
    np.testing.assert_allclose(fed[0][0, :, 32, 48], first, rtol=1e-5)


def test_end_to_end_boxes_have_one_class_each(constant_graph, encoder: TextEncoder) -> None:
    out = np.zeros((1, 300, 6), np.float32)
    out[0, 0] = (10, 10, 50, 50, 0.9, 0)
    out[0, 1] = (12, 10, 50, 50, 0.8, 0)
    out[0, 2] = (60, 10, 80, 50, 0.7, 2)
    out[0, 3] = (60, 10, 80, 50, 0.9, 7)  # of no class that there is
    out[0, 4] = (60, 10, 80, 50, 0.9, np.nan)
    detector = opened(constant_graph, {"output0": out}, encoder)
    assert detector.capabilities["contract"] == "end-to-end"
    seen = detector.detect(np.zeros((*SIZE, 3), np.uint8))
    np.testing.assert_allclose(seen.boxes_px, out[0, :3, :4])
    np.testing.assert_allclose(seen.scores, [0.9, 0.8, 0.7])
    assert seen.labels.tolist() == [0, 0, 1]


@pytest.mark.parametrize("plus", [False, True])
@pytest.mark.parametrize("apart", [False, True])
@pytest.mark.parametrize("planes", [False, True])
def test_nanodets_heads(
    plus: bool, apart: bool, planes: bool, constant_graph, encoder: TextEncoder
) -> None:
    """One output or two of each stride, as rows or planes; scores or logits."""
    levels = [(8, 12), (4, 6), (2, 3), *([(1, 2)] if plus else [])]
    bins, cell = 8, 2 * 6 + 3  # stride 16, row 2, column 3
    heads = [np.full((h * w, 3 + 4 * bins), OFF, np.float32) for h, w in levels]
    for side, distance in enumerate((1, 0, 2, 1)):  # left, top, right, bottom
        heads[1][cell, 3 + side * bins + distance] = 40
    heads[1][cell, :3] = (0.9, 0, 0) if not apart else (np.log(9), OFF, OFF)
    if not apart:
        for level in heads:
            level[:, :3] = np.maximum(level[:, :3], 0)
        outputs = {"output": np.concatenate(heads)[None]}
    else:
        outputs = {}
        for stride, level, (h, w) in zip((8, 16, 32, 64), heads, levels, strict=False):
            for what, part in (("dis_pred", level[:, 3:]), ("cls_pred", level[:, :3])):
                shown = part.T.reshape(1, -1, h, w) if planes else part[None]
                outputs[f"{what}_stride_{stride}"] = shown
    detector = opened(constant_graph, outputs, encoder)
    assert detector.capabilities["contract"] == "nanodet"
    seen = detector.detect(np.zeros((*SIZE, 3), np.uint8))
    x, y = (48, 32) if plus else (56, 40)
    np.testing.assert_allclose(seen.boxes_px, [[x - 16, y, x + 32, y + 16]], atol=1e-3)
    np.testing.assert_allclose(seen.scores, [0.9], rtol=1e-4)
    assert seen.labels.tolist() == [0]


@pytest.mark.slow
def test_a_real_nanodets_raw_heads_say_what_its_boxes_say(
    tmp_path: Path, encoder: TextEncoder
) -> None:
    """Ours has the decoding inside: cut off before, this project's must give the same."""
    whole = manifest.fetch("nanodet-g")
    model = onnx.load(str(whole))
    joined = [n for n in model.graph.node if n.op_type == "Concat"]
    spread, scores = joined[-3].output[0], joined[-2].output[0]
    model.graph.node.append(helper.make_node("Concat", [scores, spread], ["raw"], axis=2))
    del model.graph.output[:]
    shape = [1, sum(40 * 52 // k**2 for k in (1, 2, 4)), 80 + 44]
    model.graph.output.append(helper.make_tensor_value_info("raw", onnx.TensorProto.FLOAT, shape))
    added = model.metadata_props.add()
    added.key, added.value = "normalise", "none"  # which it does itself
    onnx.save(model, str(tmp_path / "raw.onnx"))
    frame = np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)
    found = []
    for path in (whole, tmp_path / "raw.onnx"):
        detector = open_detector(path, "auto", encoder)
        detector.set_vocabulary(load_vocabulary().objects, ())
        found.append(detector.detect(frame))
    assert detector.capabilities["contract"] == "nanodet"
    assert len(found[0].scores) > 3
    np.testing.assert_allclose(found[0].boxes_px, found[1].boxes_px, atol=0.05)
    np.testing.assert_allclose(found[0].scores, found[1].scores, atol=1e-4)
    assert found[0].labels.tolist() == found[1].labels.tolist()


def test_scores_outside_of_chances_are_logits(constant_graph, encoder: TextEncoder) -> None:
    out = np.full((1, 7, CELLS), OFF, np.float32)
    out[0, :, 0] = (48, 32, 40, 20, np.log(4), OFF, OFF)
    seen = opened(constant_graph, {"out": out}, encoder).detect(np.zeros((*SIZE, 3), np.uint8))
    np.testing.assert_allclose(seen.scores, [0.8], rtol=1e-5)


def test_what_shapes_do_not_tell_must_be_said(constant_graph, encoder: TextEncoder) -> None:
    out = {"out": np.zeros((1, CELLS, 6), np.float32)}  # one class of layout X, or end to end
    one = {"names": "['couch']"}
    with pytest.raises(ModelFileError, match="may be of layout X or end-to-end; say which with"):
        opened(constant_graph, out, encoder, **one)
    for layout in ("X", "end-to-end"):
        detector = opened(constant_graph, out, encoder, layout=layout, **one)
        assert detector.capabilities["contract"].endswith(layout)
    with pytest.raises(ModelFileError, match="cannot be of layout detr"):
        opened(constant_graph, out, encoder, layout="detr", **one)
    with pytest.raises(ModelFileError, match="layout 'yolo' is unknown; known are v5, v8"):
        opened(constant_graph, out, encoder, layout="yolo", **one)
    with pytest.raises(ModelFileError, match="normalise 'x' is unknown; known are none, imagenet"):
        opened(constant_graph, out, encoder, layout="X", normalise="x", **one)


def test_names_must_fit_what_the_outputs_have_room_for(
    constant_graph, encoder: TextEncoder
) -> None:
    out = {"out": np.zeros((1, CELLS, 3 + 4 * 8), np.float32)}  # NanoDet's; X's for 30 names
    assert set(possible({"out": out["out"]}, *SIZE)) == {"X", "nanodet"}
    with pytest.raises(ModelFileError, match="2 names for 30 classes"):
        opened(constant_graph, out, encoder, names="['couch', 'tv']")
    with pytest.raises(ModelFileError, match="its 30 classes have no names"):
        open_detector(constant_graph(out, SIZE), "auto", encoder)
    few = {"out": np.zeros((1, 40, 6), np.float32)}
    with pytest.raises(ModelFileError, match="its classes have no names; give a text file"):
        open_detector(constant_graph(few, SIZE), "auto", encoder)
