"""A small file of the contract that models/language/scene_layout.py reads."""

import json
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

ROW, TOKENS, WIDTH = 384, 8, 576


def write_layout(
    path: Path, parts: tuple[int, int, int], detector: str, language: str, speaks: bool = True
) -> None:
    """Its evidence and its tokens follow the mean of the first features of a view (C, h, w)."""
    rng, channels = np.random.default_rng(0), parts[0]
    constants = {
        "axes": np.array([2, 3]),
        "to_row": rng.normal(0, 1, (channels, ROW + 2)).astype(np.float32),
        "to_tokens": rng.normal(0, 0.1, (channels, TOKENS * WIDTH)).astype(np.float32),
        "shape": np.array([-1, TOKENS, WIDTH]),
        "none": np.zeros((TOKENS, WIDTH), np.float32),
    }
    nodes = [
        helper.make_node("ReduceMean", ["features", "axes"], ["mean"], keepdims=0),
        helper.make_node("MatMul", ["mean", "to_row"], ["beyond"]),
        helper.make_node("Identity", ["beyond"], ["view"]),
        helper.make_node("MatMul", ["mean", "to_tokens"], ["flat"]),
        helper.make_node("Reshape", ["flat", "shape"], ["tokens"]),
        helper.make_node("Identity", ["none"], ["blank"]),
    ]

    def told(name: str, *shape: int | str) -> onnx.ValueInfoProto:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)

    inputs = [told("features", "n", *parts), told("depth", "n", 2, *parts[1:]), told("way", "n", 2)]
    outputs = [told("beyond", "n", ROW + 2), told("view", "n", ROW + 2),
               told("tokens", "n", TOKENS, WIDTH), told("blank", TOKENS, WIDTH)]  # fmt: skip
    outputs = outputs if speaks else outputs[:2]
    held = [numpy_helper.from_array(value, name) for name, value in constants.items()]
    graph = helper.make_graph(nodes, "layout", inputs, outputs, held)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)
    says = {"beyond": " Further on there is a", "view": " In view there is a",
            "room": " This room is a"}  # fmt: skip
    about = {"format": "rf-nav-scene-layout/1", "detector": detector, "language": language,
             "text": "{}", "templates": json.dumps(says)}  # fmt: skip
    helper.set_model_props(model, about)
    onnx.save(model, str(path))
