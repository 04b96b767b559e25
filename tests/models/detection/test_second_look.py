"""A second look at what the detector has no word for, by a classifier that answers in colours."""

import base64
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper

from models.detection.detector import OpenDetector, open_detector
from models.detection.ensemble import DetectorEnsemble
from models.detection.fusion import FusionWeights
from models.detection.second_look import (
    LOOKS,
    SecondLook,
    SecondLookEvidence,
    Sought,
    look_twice,
    places,
)
from models.errors import ModelFileError
from models.evaluation.judged import fit_odds
from models.evaluation.precision import Precision
from models.evaluation.sightings import Sightings, look_at_all, sightings
from models.evaluation.truth import FrameTruth, Marks, NameLists, _marks
from models.store import manifest
from models.words.text_encoder import TextEncoder

NAMES = ("umbrella", "banjo", "toaster")  # what is red, green, blue
VALUES = {
    "margin": 1.0,
    "alike": 0.5,
    "spread": 0.05,
    "shift": 0.0,
    **dict.fromkeys(("resemblance", "objectness", "strangeness"), 1.0),
}
METADATA = {
    "format": "rf-nav-second-look/1",
    "names": json.dumps(NAMES),
    "usual": json.dumps([1 / 3] * 3),
    **{f"value.{key}": str(value) for key, value in VALUES.items()},
}
RED, BLUE = (250, 0, 0), (0, 0, 250)
LEFT, RIGHT = (4, 20, 36, 52), (60, 20, 92, 52)


def write(path: Path, metadata: dict[str, str], times: int = 1) -> Path:
    """Logits are the mean of each colour over a crop, all three as often as told."""
    crops = helper.make_tensor_value_info("crops", TensorProto.FLOAT, ["n", 3, 16, 16])
    logits = helper.make_tensor_value_info("logits", TensorProto.FLOAT, ["n", 3 * times])
    mean = helper.make_node("ReduceMean", ["crops"], ["mean"], axes=[2, 3], keepdims=0)
    tile = helper.make_node("Concat", ["mean"] * times, ["logits"], axis=1)
    graph = helper.make_graph([mean, tile], "colours", [crops], [logits])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, metadata)
    onnx.save(model, str(path))
    return path


@pytest.fixture
def second(tmp_path: Path, encoder: TextEncoder) -> SecondLook:
    return SecondLook(write(tmp_path / "second.onnx", METADATA), encoder)


@pytest.fixture
def detector(constant_graph, encoder: TextEncoder) -> OpenDetector:
    """Sees two things, and a part of each: on the left something strange, on the right a sofa."""
    sofa, strange = encoder.embed(["sofa", "thermodynamics"])
    small = [(x0, y0, x1 - 4, y1) for x0, y0, x1, y1 in (LEFT, RIGHT)]
    outputs = {
        "boxes": np.array([[LEFT, RIGHT, *small]], np.float32),
        "objectness": np.array([[0.9, 0.9, 0.8, 0.8]], np.float32),
        "embeddings": np.stack((strange, sofa, strange, sofa))[None],
        "scene": sofa[None],
    }
    metadata = {
        "format": "rf-nav-detector/1",
        "value.scale": "20.0",
        "value.bias": "-12.0",
        "value.room_scale": "10.0",
    }
    found = open_detector(constant_graph(outputs, (64, 96), metadata), "rfnav", encoder)
    assert isinstance(found, OpenDetector)
    return found


def frame(left: tuple[int, int, int], right: tuple[int, int, int]) -> np.ndarray:
    rgb = np.zeros((64, 96, 3), np.uint8)
    for (x0, y0, x1, y1), colour in ((LEFT, left), (RIGHT, right)):
        rgb[y0:y1, x0:x1] = colour
    return rgb


def test_what_is_sought_is_compared_with_the_names(second: SecondLook) -> None:
    assert second.likeness(["umbrella"]) == pytest.approx([1, 0, 0], abs=1e-3)
    assert second.likeness(["beach umbrella"])[0] == 1  # the best stands for it
    assert not second.likeness(["thermodynamics"]).any()


def test_other_names_count_only_when_the_first_says_nothing(second: SecondLook) -> None:
    assert second.likeness(["umbrella", "toaster"]) == pytest.approx([1, 0, 0], abs=1e-3)
    assert second.likeness(["thermodynamics", "toaster"]) == pytest.approx([0, 0, 1], abs=1e-3)


def test_rows_in_the_file_are_used_if_they_are_this_encoders(
    tmp_path: Path, encoder: TextEncoder, monkeypatch: pytest.MonkeyPatch
) -> None:
    embedded: list[int] = []
    embed = encoder.embed
    monkeypatch.setattr(encoder, "embed", lambda texts: embedded.append(len(texts)) or embed(texts))
    names = NAMES * 10
    own = embed(names).astype(np.float16)
    for rows, asked in ((own, [3]), (own[::-1] * 0.9, [3, 30]), (own[:5], [30])):
        held = base64.b64encode(np.ascontiguousarray(rows).tobytes()).decode()
        many = {"names": json.dumps(names), "usual": json.dumps([1 / 30] * 30), "rows": held}
        embedded.clear()
        second = SecondLook(write(tmp_path / "many.onnx", METADATA | many, 10), encoder)
        assert embedded == asked
        assert second.likeness(["umbrella"])[::3] == pytest.approx(np.ones(10), abs=0.01)


def test_each_place_is_classified_by_itself(second: SecondLook) -> None:
    boxes = np.array([LEFT, RIGHT, (90, 60, 96, 64), (50, 5, 50, 5)], np.float32)
    found = second.classify(frame(RED, BLUE), boxes)
    assert found.shape == (4, 3)
    assert found.sum(axis=1) == pytest.approx(1.0, abs=1e-5)
    assert found[0, 0] > 0.99
    assert found[1, 2] > 0.99
    assert second.classify(frame(RED, BLUE), boxes[:0]).shape == (0, 3)


@pytest.mark.parametrize(
    ("left", "right", "labels"),
    [(RED, BLUE, [0, 1]), (BLUE, RED, [0]), (RED, RED, [0, 1])],
    ids=["strange and red", "red but a sofa", "both red"],
)
def test_only_what_is_strange_and_looks_like_it_is_found(
    left, right, labels: list[int], detector: OpenDetector, second: SecondLook
) -> None:
    detector.set_vocabulary((("sofa",), ("umbrella",)), ())
    sought = Sought(1, second.likeness(["umbrella"]), 5)
    image = frame(left, right)
    again = look_twice(detector, second, sought, image, detector.look(image))
    assert set(again.labels.tolist()) <= {1}
    seen = DetectorEnsemble({"ours": detector}, weights=FusionWeights())
    seen.set_vocabulary((("sofa",), ("umbrella",)), ())
    seen.again = second, sought
    both, first = seen.detect(image), detector.detect(image)
    sure = both.scores > 0.5
    assert sorted(both.labels[sure].tolist()) == labels
    for label, box in zip(both.labels[sure], both.boxes_px[sure], strict=True):
        assert box == pytest.approx(RIGHT if label == 0 else LEFT, abs=1e-3)
    assert len(both.scores) == len(both.embeddings)
    assert both.scores[both.labels == 0] == pytest.approx(first.scores[first.labels == 0])


def test_no_more_places_are_looked_at_than_asked_for(
    detector: OpenDetector, second: SecondLook, monkeypatch: pytest.MonkeyPatch
) -> None:
    looked = []
    classify = second.classify
    monkeypatch.setattr(
        second, "classify", lambda rgb, boxes: looked.append(len(boxes)) or classify(rgb, boxes)
    )
    detector.set_vocabulary((("sofa",), ("umbrella",)), ())
    view = detector.look(frame(RED, RED))
    assert len(places(view)) == 2  # parts of what is there already are no places
    for most in (5, 1):
        sought = Sought(1, second.likeness(["umbrella"]), most)
        seen = look_twice(detector, second, sought, frame(RED, RED), view)
        assert seen.scores[seen.labels == 1].max() > 0.5  # the strangest is the first
    assert looked == [2, 1]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "rf-nav-detector/1"}, "not a classifier for second looks"),
        ({"names": ""}, "is missing or no use"),
        ({"usual": "often"}, "is missing or no use"),
        ({"value.margin": "wide"}, "is missing or no use"),
        ({"names": "5"}, "is missing or no use"),
        ({"rows": "abc"}, "is missing or no use"),
        ({"rows": "abcd"}, "is missing or no use"),  # 3 bytes
        ({"names": '["umbrella", "banjo"]'}, "3 classes, but 2 names"),
        ({"usual": "[0.5, 0.5]"}, "and 2 usual probabilities"),
    ],
)
def test_a_file_that_is_none_is_refused_in_a_line(
    change: dict[str, str], said: str, tmp_path: Path, encoder: TextEncoder
) -> None:
    path = write(tmp_path / "other.onnx", METADATA | change)
    with pytest.raises(ModelFileError, match=said) as error:
        SecondLook(path, encoder)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_it_is_evaluated_on_what_was_held_out_and_on_each_word_as_if_it_were(
    detector: OpenDetector, second: SecondLook, monkeypatch: pytest.MonkeyPatch
) -> None:
    boxes = {"sofa": RIGHT, "umbrella": LEFT}
    table = {
        "images": [{"id": 1, "file_name": "a.png"}],
        "categories": [{"id": k + 1, "name": name} for k, name in enumerate(boxes)],
        "annotations": [
            {"id": k, "image_id": 1, "category_id": k + 1, "iscrowd": 0, "area": 32 * 32,
             "bbox": [x0, y0, x1 - x0, y1 - y0]}
            for k, (x0, y0, x1, y1) in enumerate(boxes.values())
        ],
    }  # fmt: skip
    truth = FrameTruth(Path(), table, tuple(boxes), _marks(table))
    words = NameLists({"sofa": ("sofa",)}, ("umbrella",), {}, {}, (), {})
    monkeypatch.setattr(FrameTruth, "picture", lambda self, name: frame(RED, BLUE))
    looked = look_at_all(detector, second, truth, words)
    (told,) = sightings(looked, second, truth, words, {"umbrella": ["umbrella"]}, LOOKS)
    found, order = told.scored(second)
    assert Precision(truth).average([found], [1])[1] == pytest.approx(1.0)
    assert found.labels.tolist() == [1, 1]
    assert told.boxes_px[order[0]] == pytest.approx(LEFT)
    (alone,) = sightings(looked, second, truth, words, {"sofa": ["sofa"]}, LOOKS)
    assert alone.labels.tolist() == []  # no class of these stands for a sofa
    words = replace(words, trained={"umbrella": ("umbrella",)}, held_out=())
    looked = look_at_all(detector, second, truth, words)
    (known,) = sightings(looked, second, truth, words, {"umbrella": ["umbrella"]}, LOOKS)
    assert known.labels.tolist() == [1, 1]
    assert known.evidence.strangeness == pytest.approx([0, 0])  # its own word is left out


def test_it_is_fitted_on_what_is_rare_among_the_trained(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    from models.train.second_look import fit, rarely_seen, read_names

    listed = tmp_path / "names.py"
    listed.write_text('raise SystemExit\n_IMAGENET_CATEGORIES = ["umbrella", "banjo"]\n')
    assert read_names(listed) == ("umbrella", "banjo")
    listed.write_text("OTHER = []\n")
    with pytest.raises(ModelFileError, match="holds no _IMAGENET_CATEGORIES"):
        read_names(listed)
    categories, rng = ("sofa", "piano", "umbrella", "bed"), np.random.default_rng(0)
    often = {0: 40, 1: 5, 2: 5, 3: 1}  # of 1,000
    marks = []
    for n in range(1000):
        kinds = np.array([k for k, count in often.items() if n < count], np.int64)
        boxes = np.tile(np.array(LEFT, np.float32), (len(kinds), 1))
        marks.append(Marks(boxes, kinds, np.zeros(len(kinds), bool)))
    truth = FrameTruth(Path(), {}, categories, tuple(marks))
    words = NameLists({"sofa": (), "piano": (), "bed": ()}, ("umbrella",), {}, {}, (), {})
    assert rarely_seen(truth, words) == ("piano",)
    told = []  # a place a frame, that of the piano looks like one
    for n in range(1000):
        resemblance = rng.normal(3 if n < 5 else 0, 0.5)
        evidence = SecondLookEvidence(*np.array([[resemblance], [0.0], [0.0]], np.float32))
        label = np.array([1], np.int32)
        told.append(Sightings(np.array([LEFT], np.float32), label, evidence))
    worth = fit(told, truth, AnyLook())
    assert set(worth) == {"resemblance", "objectness", "strangeness", "shift"}
    assert worth["resemblance"] > 2
    assert worth["shift"] < -4


class AnyLook(SecondLook):
    """Without a network: what looks more like it is likelier."""

    def __init__(self) -> None:
        pass

    def probability(self, evidence: SecondLookEvidence) -> np.ndarray:
        return 1 / (1 + np.exp(-evidence.resemblance))


def test_evidence_is_weighed_by_how_often_it_was_right() -> None:
    """Of two kinds of evidence one tells right from wrong, the other nothing."""
    rng = np.random.default_rng(0)
    evidence = rng.normal(size=(4000, 2))
    right = rng.random(4000) < 1 / (1 + np.exp(-(2 * evidence[:, 0] - 1)))
    weights = fit_odds(evidence, right, np.zeros(3))
    assert weights == pytest.approx([2, 0, -1], abs=0.15)


def test_the_committed_one_knows_a_thousand_things(encoder: TextEncoder) -> None:
    second = SecondLook(manifest.locate("second-look"), encoder)
    assert len(second.names) == 1000
    assert second.names[int(second.likeness(["umbrella"]).argmax())] == "umbrella"
    grey = np.full((48, 64, 3), 128, np.uint8)
    found = second.classify(grey, np.array([[0, 0, 64, 48]], np.float32))
    assert found.shape == (1, 1000)
    assert found.sum() == pytest.approx(1.0, abs=1e-4)
