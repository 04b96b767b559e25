"""A detector with a fixed class list, at work: what is said of the goal."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from models.detection.fixed_list import YoloDetector
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
    config = configuration.load(None, [f'models.detector="{detector}"', "panel.experts=[]"])
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
    def fail(self: YoloDetector, rgb: np.ndarray) -> None:
        raise ModelFileError("yolo.onnx: does not run on images (1, 3, 64, 96)")

    config = configuration.load(None, [f'models.detector="{detector}"', "panel.experts=[]"])
    with LoadedModels(config, SystemClock()) as models:
        models.accept("couch", config)
        monkeypatch.setattr(YoloDetector, "detect", fail)
        with pytest.raises(ModelError, match=r"^yolo\.onnx: does not run on images"):
            models.detect(np.zeros((64, 96, 3), np.uint8))
