"""Rewriting an exported graph into one that runs faster, or that is smaller; same answers."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

from models.detection.calibration import PREFIX
from models.errors import ModelFileError

SMALL = 64
"""Constants with fewer values stay in single precision."""


def simplified(path: Path) -> onnx.ModelProto:
    """The graph with constants folded and shapes known, as onnxruntime's basic passes make it."""
    options = onnxruntime.SessionOptions()
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_BASIC
    folded = path.with_suffix(".folded")
    options.optimized_model_filepath = str(folded)
    options.log_severity_level = 3
    onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    try:
        model = onnx.load(str(folded))
    finally:
        folded.unlink()
    fuse_pads(model)
    used = {name for node in model.graph.node for name in node.input}
    for tensor in [t for t in model.graph.initializer if t.name not in used]:
        model.graph.initializer.remove(tensor)
    return onnx.shape_inference.infer_shapes(model)


def fuse_pads(model: onnx.ModelProto) -> int:
    """Move zero paddings into the convolutions behind them; returns how many.

    TensorFlow's SAME padding is lopsided and is exported as a node of its own. onnxruntime leaves
    its blocked layout for each: at 640x480 that took a third of the whole time.
    """
    graph = model.graph
    constants = _constants(graph)
    pads = {n.output[0]: n for n in graph.node if n.op_type == "Pad" and _is_zero(n, constants)}
    uses: dict[str, int] = {}
    for node in graph.node:
        for name in node.input:
            uses[name] = uses.get(name, 0) + 1
    fused = []
    for node in graph.node:
        pad = pads.get(node.input[0]) if node.op_type == "Conv" else None
        if pad is None or uses[node.input[0]] > 1:
            continue
        around = constants[pad.input[1]].reshape(2, -1)
        if around[:, :2].any() or (around < 0).any():
            continue
        for own in [a for a in node.attribute if a.name in ("pads", "auto_pad")]:
            if own.name == "pads":
                around[:, 2:] += np.array(own.ints).reshape(2, 2)
            node.attribute.remove(own)
        values = [int(v) for v in around[:, 2:].reshape(-1)]
        node.attribute.append(helper.make_attribute("pads", values))
        node.input[0] = pad.input[0]
        fused.append(pad)
    for pad in fused:
        graph.node.remove(pad)
    return len(fused)


def _constants(graph: onnx.GraphProto) -> dict[str, np.ndarray]:
    found = {t.name: numpy_helper.to_array(t).copy() for t in graph.initializer}
    for node in graph.node:
        if node.op_type == "Constant":
            found[node.output[0]] = numpy_helper.to_array(node.attribute[0].t).copy()
    return found


def _is_zero(node: onnx.NodeProto, constants: dict[str, np.ndarray]) -> bool:
    """A constant padding with zeros whose widths are known."""
    mode = next((a.s for a in node.attribute if a.name == "mode"), b"constant")
    value = node.input[2] if len(node.input) > 2 else ""
    zero = not value or (value in constants and not constants[value].any())
    return mode == b"constant" and node.input[1] in constants and zero


def halve(model: onnx.ModelProto) -> None:
    """Store float32 weights as float16 with a Cast behind each, done when the file is loaded."""
    graph = model.graph
    casts = []
    for tensor in graph.initializer:
        values = numpy_helper.to_array(tensor)
        if tensor.data_type != TensorProto.FLOAT or values.size < SMALL:
            continue
        name, half = tensor.name, tensor.name + ".half"
        tensor.CopyFrom(numpy_helper.from_array(values.astype(np.float16), half))
        casts.append(helper.make_node("Cast", [half], [name], to=TensorProto.FLOAT))
    nodes = [*casts, *graph.node]
    del graph.node[:]
    graph.node.extend(nodes)


def read_metadata(model: onnx.ModelProto) -> dict[str, str]:
    """The file's metadata by key."""
    return {p.key: p.value for p in model.metadata_props}


def set_metadata(model: onnx.ModelProto, entries: Mapping[str, str]) -> None:
    """Set these; the others stay."""
    helper.set_model_props(model, {**read_metadata(model), **entries})


def write_metadata(path: Path, entries: Mapping[str, str]) -> None:
    """Set these in a file."""
    model = onnx.load(str(path))
    set_metadata(model, entries)
    onnx.save(model, str(path))


def constants(values: Mapping[str, float]) -> dict[str, str]:
    """Metadata that hold these."""
    return {f"{PREFIX}{k}": repr(float(v)) for k, v in values.items()}


def parse_size(text: str) -> tuple[int, int]:
    """ "416x320" -> (416, 320)."""
    try:
        width, height = (int(part) for part in text.split("x"))
    except ValueError:
        raise ModelFileError(
            f"size {text!r} is none; write WIDTHxHEIGHT, such as 416x320"
        ) from None
    return width, height
