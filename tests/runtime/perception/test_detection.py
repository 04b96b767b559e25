"""Detectors at work: what is said of the goal to a fixed list, and what CLIP is told of it."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from baseline_graphs import image_tower, sentence_row
from onnx import TensorProto, helper, numpy_helper

from models.detection.clip import PLACED, SENTENCE
from models.detection.fixed_list import FixedListDetector
from models.errors import ModelFileError
from runtime import config as configuration
from runtime.clock import SystemClock
from runtime.errors import ModelError
from runtime.perception.loaded_models import LoadedModels

pytestmark = pytest.mark.slow  # the real models are loaded

CELLS = 8 * 12 + 4 * 6 + 2 * 3


@pytest.fixture
def detector(tmp_path: Path) -> Path:
    """A YOLOv8 export of couches, giraffes and dining tables that sees a couch everywhere."""
    out = np.zeros((1, 7, CELLS), np.float32)
    out[0, :, 0] = (48, 32, 40, 20, 0.9, 0.0, 0.1)
    constants = [numpy_helper.from_array(np.float32(0), "none"), numpy_helper.from_array(out, "v")]
    nodes = [
        helper.make_node("ReduceSum", ["image"], ["sum"], keepdims=0),
        helper.make_node("Mul", ["sum", "none"], ["nothing"]),
        helper.make_node("Add", ["v", "nothing"], ["out"]),
    ]
    image = helper.make_tensor_value_info("image", TensorProto.FLOAT, [1, 3, 64, 96])
    answer = helper.make_tensor_value_info("out", TensorProto.FLOAT, out.shape)
    graph = helper.make_graph(nodes, "yolo", [image], [answer], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, {"names": "['couch', 'giraffe', 'dining table']"})
    onnx.save(model, str(tmp_path / "yolo.onnx"))
    return tmp_path / "yolo.onnx"


def test_a_fixed_list_says_what_stands_for_the_goal(detector: Path) -> None:
    config = configuration.load(None, [f'models.detectors=["{detector}"]', "panel.experts=[]"])
    with LoadedModels(config, SystemClock()) as models:
        goal, _ = models.accept("couch", config)
        assert goal.name == "sofa"
        assert goal.how.endswith(
            "seen as what is like it in the detector's fixed list: couch (1.00)"
        )
        assert models.capabilities()["matched"]["sofa"] == {"couch": 1.0}
        seen = models.detect(np.zeros((64, 96, 3), np.uint8))
        assert [goal.classes[k][0] for k in seen.labels] == ["sofa"]
        goal, _ = models.accept("toilet", config)
        assert goal.how.endswith("; the detector knows nothing like it and cannot see it")
        seen = models.detect(np.full((1, 1, 3), 255, np.uint8))
        assert goal.name not in [goal.classes[k][0] for k in seen.labels]


def test_a_detector_that_fails_on_a_frame_is_a_fault_of_a_model(
    detector: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(self: FixedListDetector, rgb: np.ndarray) -> None:
        raise ModelFileError("yolo.onnx: does not run on images (1, 3, 64, 96)")

    config = configuration.load(None, [f'models.detectors=["{detector}"]', "panel.experts=[]"])
    with LoadedModels(config, SystemClock()) as models:
        models.accept("couch", config)
        monkeypatch.setattr(FixedListDetector, "detect", fail)
        with pytest.raises(ModelError, match=r"^yolo\.onnx: does not run on images"):
            models.detect(np.zeros((64, 96, 3), np.uint8))


def test_clip_is_told_the_goal_and_how_to_find_it(tmp_path: Path) -> None:
    words = [s.format(name) for name in ("sofa", "toilet") for s in (SENTENCE, *PLACED)]
    path, texts = tmp_path / "clip.d" / "model.onnx", tmp_path / "clip.d" / "texts.npz"
    path.parent.mkdir()
    image_tower(path)
    np.savez(texts, **{sentence: sentence_row(sentence) for sentence in words})
    frame = np.zeros((90, 90, 3), np.uint8)
    frame[60:, :30, 2] = 255  # blue as toilets are
    settings = [f'models.detectors=["{path.parent}"]', "panel.experts=[]"]
    settings += ["research.detector_memo_frames=9"]

    def config(way: str) -> configuration.Config:
        return configuration.load(None, [*settings, f'research.clip_way="{way}"'])

    with LoadedModels(config("patch"), SystemClock()) as models:
        toilet, _ = models.accept("toilet", config("patch"))
        patches = models.detect(frame)
        assert patches.labels[0] == toilet.label
        models.accept("sofa", config("reference"))
        assert not len(models.detect(frame).scores)
        models.accept("toilet", config("reference"))
        for _ in range(2):
            ninth = models.detect(frame)
            np.testing.assert_allclose(ninth.boxes_px, [[0, 60, 30, 90]], atol=1e-3)
            with pytest.raises(ModelError, match="gives no relevance map"):
                models.accept("sofa", config("grad"))
        models.accept("toilet", config("patch"))
        assert len(models.detect(frame).scores) == len(patches.scores) > 1
