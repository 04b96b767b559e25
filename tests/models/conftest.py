"""What several tests share: the text encoder, and small ONNX graphs with known outputs."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from models import store
from models.text import TextEncoder


@pytest.fixture(scope="session")
def encoder() -> TextEncoder:
    return TextEncoder(store.fetch("minilm"))


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
