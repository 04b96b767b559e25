"""A graph model as TensorFlow.js stores it (a GraphDef in JSON, weights beside it), translated to
ONNX operators.

TensorFlow convolves images whose channels come last, ONNX such whose channels come first. Every
tensor therefore carries the order of its axes: a transposition only changes that order, and is
written into the graph where something needs the axes in one order after all.
"""

import base64
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import helper, numpy_helper

from models.errors import ModelFileError

Array = NDArray[Any]
CHANNELS_FIRST = (0, 3, 1, 2)
"""The axes of (N, H, W, C) in the order (N, C, H, W)."""
HEIGHT_WIDTH = slice(1, 3)
"""Of a list for (N, H, W, C), what is for H and W."""
UNARY = {"Sigmoid": "Sigmoid", "Relu": "Relu", "LeakyRelu": "LeakyRelu", "Identity": "Identity"}


class Ordered(NamedTuple):
    """A tensor of the ONNX graph: TensorFlow's axis k is its axis `axes[k]`."""

    name: str
    axes: tuple[int, ...]


class TfNode(NamedTuple):
    name: str
    op: str
    inputs: tuple[str, ...]
    attributes: Mapping[str, Any]


@dataclass(frozen=True)
class GraphModel:
    """`nodes` in the file's order; `weights` by the name of their Const; shapes by node name."""

    nodes: tuple[TfNode, ...]
    weights: Mapping[str, Array]
    inputs: Mapping[str, tuple[int, ...]]
    outputs: Mapping[str, tuple[int, ...]]


@dataclass
class Written:
    """What has been written of an ONNX graph."""

    nodes: list[onnx.NodeProto] = field(default_factory=list)
    constants: list[onnx.TensorProto] = field(default_factory=list)

    def constant(self, value: Array) -> str:
        """Name of a new constant."""
        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(value), name))
        return name

    def add(self, op: str, inputs: Sequence[str], count: int = 1, **attributes: Any) -> list[str]:
        """Names of a new operator's outputs."""
        names = [f"{op.lower()}{len(self.nodes)}.{k}" for k in range(count)]
        self.nodes.append(helper.make_node(op, list(inputs), names, **attributes))
        return names


def read_graph_model(topology: bytes, weights: bytes, where: str) -> GraphModel:
    """The model of a JSON file and its one file of weights. Raises ModelFileError."""
    try:
        model = json.loads(topology)
        nodes = tuple(_node(node) for node in model["modelTopology"]["node"])
        table = [entry for group in model["weightsManifest"] for entry in group["weights"]]
        signature = model["signature"]
        return GraphModel(
            nodes,
            _weights(table, weights, where),
            _shapes(signature["inputs"]),
            _shapes(signature["outputs"]),
        )
    except (ValueError, KeyError, TypeError) as error:
        raise ModelFileError(f"{where}: not a graph model of TensorFlow.js ({error!r})") from error


def _node(node: Mapping[str, Any]) -> TfNode:
    attributes = {key: _attribute(value) for key, value in node.get("attr", {}).items()}
    return TfNode(node["name"], node["op"], tuple(node.get("input", ())), attributes)


def _attribute(value: Mapping[str, Any]) -> Any:
    if "s" in value:
        return base64.b64decode(value["s"]).decode()
    if "list" in value:
        return [int(i) for i in value["list"].get("i", ())]
    return value.get("b", value.get("f"))


def _weights(table: Sequence[Mapping[str, Any]], data: bytes, where: str) -> dict[str, Array]:
    found: dict[str, Array] = {}
    begin = 0
    for entry in table:
        stored = entry.get("quantization", entry)["dtype"]
        if stored not in ("float16", "float32", "int32"):
            raise ModelFileError(f"{where}: weights of {entry['name']} are {stored}; not supported")
        count = math.prod(entry["shape"])
        values = np.frombuffer(data, stored, count, begin).reshape(entry["shape"])
        found[entry["name"]] = values.astype(entry["dtype"])
        begin += values.nbytes
    if begin != len(data):
        raise ModelFileError(f"{where}: {len(data)} bytes of weights; its table has {begin}")
    return found


def _shapes(signature: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
    return {
        name.removesuffix(":0"): tuple(int(d["size"]) for d in entry["tensorShape"]["dim"])
        for name, entry in signature.items()
    }


class Translation:
    """Translates a model's nodes, one after another.

    `stretch` (height, width): how much larger the image is than the one that the model was stored
    for. What is resized to a size is resized to as much more.
    """

    def __init__(
        self, model: GraphModel, written: Written, image: str, stretch: tuple[float, float]
    ) -> None:
        self._model, self._out, self._stretch = model, written, stretch
        self._known: dict[str, Array] = dict(model.weights)
        self._tensors: dict[str, Ordered] = {}
        (placeholder,) = model.inputs
        self._tensors[placeholder] = Ordered(image, tuple(range(4)))
        self._how: dict[str, Callable[[TfNode], list[Ordered]]] = {
            "Add": self._add,
            "AddV2": self._add,
            "ConcatV2": self._concat,
            "Conv2D": self._conv,
            "MaxPool": self._max_pool,
            "Pad": self._pad,
            "PadV2": self._pad,
            "Reshape": self._reshape,
            "ResizeBilinear": self._resize,
            "SplitV": self._split,
            "Transpose": self._transpose,
            **dict.fromkeys(UNARY, self._unary),
        }

    def run(self) -> dict[str, str]:
        """Write all; the names of the outputs' tensors, axes in TensorFlow's order."""
        for node in self._model.nodes:
            if node.op not in ("Const", "Placeholder"):
                self._write(node)
        return {name: self._plain(self._tensors[name]) for name in self._model.outputs}

    def _write(self, node: TfNode) -> None:
        if all(name in self._known for name in node.inputs):
            self._known[node.name] = _computed(node, [self._known[n] for n in node.inputs])
            return
        if node.op not in self._how:
            raise ModelFileError(f"{node.name}: operator {node.op} has no translation")
        for k, tensor in enumerate(self._how[node.op](node)):
            self._tensors[f"{node.name}:{k}" if k else node.name] = tensor

    def _reordered(self, tensor: Ordered, order: Sequence[int]) -> str:
        """The tensor whose axis k is TensorFlow's axis `order[k]`."""
        moved = [tensor.axes[axis] for axis in order]
        if moved == sorted(moved):
            return tensor.name
        return self._out.add("Transpose", [tensor.name], perm=moved)[0]

    def _plain(self, tensor: Ordered) -> str:
        return self._reordered(tensor, range(len(tensor.axes)))

    def _like(self, tensor: Ordered, axes: tuple[int, ...]) -> str:
        """The tensor with its axes in another's order."""
        return self._reordered(tensor, _inverse(axes))

    def _image(self, node: TfNode) -> str:
        """The first input, (N, C, H, W), of an operator that takes (N, H, W, C)."""
        if node.attributes.get("data_format", "NHWC") != "NHWC":
            raise ModelFileError(f"{node.name}: {node.attributes['data_format']} is not supported")
        return self._reordered(self._tensors[node.inputs[0]], CHANNELS_FIRST)

    def _conv(self, node: TfNode) -> list[Ordered]:
        kernel = self._known[node.inputs[1]]  # (H, W, in, out)
        (name,) = self._out.add(
            "Conv",
            [self._image(node), self._out.constant(kernel.transpose(3, 2, 0, 1))],
            strides=node.attributes["strides"][HEIGHT_WIDTH],
            dilations=node.attributes["dilations"][HEIGHT_WIDTH],
            kernel_shape=kernel.shape[:2],
            **_padding(node),
        )
        return [Ordered(name, _inverse(CHANNELS_FIRST))]

    def _max_pool(self, node: TfNode) -> list[Ordered]:
        (name,) = self._out.add(
            "MaxPool",
            [self._image(node)],
            kernel_shape=node.attributes["ksize"][HEIGHT_WIDTH],
            strides=node.attributes["strides"][HEIGHT_WIDTH],
            **_padding(node),
        )
        return [Ordered(name, _inverse(CHANNELS_FIRST))]

    def _resize(self, node: TfNode) -> list[Ordered]:
        size = [s * f for s, f in zip(self._known[node.inputs[1]], self._stretch, strict=True)]
        if any(abs(side - round(side)) > 1e-6 for side in size):
            raise ModelFileError(f"{node.name}: {size} is no size; take an input of other sides")
        size = [round(side) for side in size]
        how = "asymmetric"
        if node.attributes.get("align_corners"):
            how = "align_corners"
        elif node.attributes.get("half_pixel_centers"):
            how = "half_pixel"
        (name,) = self._out.add(
            "Resize",
            [self._image(node), "", "", self._out.constant(np.array(size, np.int64))],
            axes=[2, 3],
            mode="linear",
            coordinate_transformation_mode=how,
        )
        return [Ordered(name, _inverse(CHANNELS_FIRST))]

    def _add(self, node: TfNode) -> list[Ordered]:
        first, second = node.inputs
        if first in self._known:
            first, second = second, first
        tensor = self._tensors[first]
        if second in self._known:
            value = self._known[second]
            value = value.reshape((1,) * (len(tensor.axes) - value.ndim) + value.shape)
            other = self._out.constant(value.transpose(_inverse(tensor.axes)))
        else:
            other = self._like(self._tensors[second], tensor.axes)
        return [Ordered(self._out.add("Add", [tensor.name, other])[0], tensor.axes)]

    def _unary(self, node: TfNode) -> list[Ordered]:
        tensor = self._tensors[node.inputs[0]]
        slope: dict[str, Any] = {}
        if node.op == "LeakyRelu":
            slope["alpha"] = float(node.attributes["alpha"])
        return [Ordered(self._out.add(UNARY[node.op], [tensor.name], **slope)[0], tensor.axes)]

    def _pad(self, node: TfNode) -> list[Ordered]:
        tensor = self._tensors[node.inputs[0]]
        around = self._known[node.inputs[1]][list(_inverse(tensor.axes))]
        fill = self._known[node.inputs[2]] if node.op == "PadV2" else np.float32(0)
        widths = self._out.constant(around.T.reshape(-1).astype(np.int64))
        inputs = [tensor.name, widths, self._out.constant(np.asarray(fill, np.float32))]
        return [Ordered(self._out.add("Pad", inputs)[0], tensor.axes)]

    def _concat(self, node: TfNode) -> list[Ordered]:
        *names, axis = node.inputs
        axes = self._tensors[names[0]].axes
        parts = [self._like(self._tensors[name], axes) for name in names]
        (name,) = self._out.add("Concat", parts, axis=axes[int(self._known[axis])])
        return [Ordered(name, axes)]

    def _split(self, node: TfNode) -> list[Ordered]:
        tensor = self._tensors[node.inputs[0]]
        sizes, axis = (self._known[name] for name in node.inputs[1:])
        inputs = [tensor.name, self._out.constant(sizes.astype(np.int64))]
        names = self._out.add("Split", inputs, len(sizes), axis=tensor.axes[int(axis)])
        return [Ordered(name, tensor.axes) for name in names]

    def _reshape(self, node: TfNode) -> list[Ordered]:
        shape = self._known[node.inputs[1]].astype(np.int64)
        inputs = [self._plain(self._tensors[node.inputs[0]]), self._out.constant(shape)]
        return [Ordered(self._out.add("Reshape", inputs)[0], tuple(range(len(shape))))]

    def _transpose(self, node: TfNode) -> list[Ordered]:
        tensor = self._tensors[node.inputs[0]]
        axes = tuple(tensor.axes[axis] for axis in self._known[node.inputs[1]])
        return [Ordered(tensor.name, axes)]


def _inverse(order: Sequence[int]) -> tuple[int, ...]:
    return tuple(int(axis) for axis in np.argsort(order))


def _padding(node: TfNode) -> dict[str, Any]:
    how = node.attributes["padding"]
    if how not in ("VALID", "SAME"):
        raise ModelFileError(f"{node.name}: padding {how} is not supported")
    return {"auto_pad": "SAME_UPPER"} if how == "SAME" else {"pads": [0, 0, 0, 0]}


def _computed(node: TfNode, values: Sequence[Array]) -> Array:
    """What an operator makes of constants: such compute shapes."""
    if node.op in ("Add", "AddV2"):
        return np.asarray(values[0] + values[1])
    if node.op == "SparseToDense":
        where, shape, given, default = values
        dense = np.full(tuple(shape), default)
        dense[tuple(where.T)] = given
        return dense
    raise ModelFileError(f"{node.name}: operator {node.op} of constants has no translation")
