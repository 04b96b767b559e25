"""Fixtures that several rooms' tests share: the text encoder, and small ONNX graphs with known
outputs. A room's conftest names those that it uses."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from models.store import manifest
from models.words.text_encoder import TextEncoder


@pytest.fixture(scope="session")
def encoder() -> TextEncoder:
    return TextEncoder(manifest.fetch("minilm"))


@pytest.fixture
def constant_graph(tmp_path: Path):
    """Write a graph that takes an image of a size and answers `outputs` whatever it shows."""

    def write(
        outputs: dict[str, NDArray[np.float32]],
        size: tuple[int, int],
        metadata: dict[str, str] | None = None,
    ) -> Path:
        image = helper.make_tensor_value_info("image", TensorProto.FLOAT, [1, 3, *size])
        zero = helper.make_node("ReduceSum", ["image"], ["sum"], keepdims=0)
        nothing = helper.make_node("Mul", ["sum", "none"], ["nothing"])
        constants = [numpy_helper.from_array(np.float32(0), "none")]
        nodes, infos = [zero, nothing], []
        for name, value in outputs.items():
            constants.append(numpy_helper.from_array(value.astype(np.float32), name + ".value"))
            nodes.append(helper.make_node("Add", [name + ".value", "nothing"], [name]))
            infos.append(helper.make_tensor_value_info(name, TensorProto.FLOAT, value.shape))
        graph = helper.make_graph(nodes, "constant", [image], infos, constants)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
        helper.set_model_props(model, metadata or {})
        path = tmp_path / "graph.onnx"
        onnx.save(model, str(path))
        return path

    return write


@pytest.fixture
def prompted_graph(tmp_path: Path):
    """Write a graph that takes an image and texts (slots, D): location i, at `boxes[i]` (corners in
    network px), is what `regions[i]` (D,) says, whatever is shown. score = texts . region."""

    def write(
        boxes: NDArray[np.float32],
        regions: NDArray[np.float32],
        size: tuple[int, int],
        slots: int | str = "n",
        batched: bool = False,
        joined: bool = False,
    ) -> Path:
        count, width = regions.shape
        shapes = {
            "images": [1, 3, *size],
            "texts": [1, slots, width] if batched else [slots, width],
            "boxes": [1, count, 4],
            "scores": [1, count, slots],
            "output": [1, "four_and_n", count],
        }
        info = {
            k: helper.make_tensor_value_info(k, TensorProto.FLOAT, v) for k, v in shapes.items()
        }
        nodes = _prompted_nodes()
        if joined:
            half = (boxes[:, 2:] - boxes[:, :2]) / 2
            boxes = np.concatenate((boxes[:, :2] + half, 2 * half), axis=1)
            nodes.append(helper.make_node("Concat", ["boxes", "scores"], ["wide"], axis=2))
            nodes.append(helper.make_node("Transpose", ["wide"], ["output"], perm=[0, 2, 1]))
        values = {
            "zero": np.float32(0),
            "regions": regions[None].astype(np.float32),
            "boxes.value": boxes[None].astype(np.float32),
            "rows.shape": np.array([1, -1, width], np.int64),
        }
        constants = [numpy_helper.from_array(v, name) for name, v in values.items()]
        outputs = [info["output"]] if joined else [info["boxes"], info["scores"]]
        inputs = [info["images"], info["texts"]]
        graph = helper.make_graph(nodes, "prompted", inputs, outputs, constants)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
        path = tmp_path / "prompted.onnx"
        onnx.save(model, str(path))
        return path

    return write


def _prompted_nodes() -> list[onnx.NodeProto]:
    """boxes, whatever is shown; scores = texts . regions."""
    return [
        helper.make_node("ReduceSum", ["images"], ["sum"], keepdims=0),
        helper.make_node("Mul", ["sum", "zero"], ["nothing"]),
        helper.make_node("Add", ["boxes.value", "nothing"], ["boxes"]),
        helper.make_node("Reshape", ["texts", "rows.shape"], ["rows"]),
        helper.make_node("Transpose", ["rows"], ["columns"], perm=[0, 2, 1]),
        helper.make_node("MatMul", ["regions", "columns"], ["scores"]),
    ]
