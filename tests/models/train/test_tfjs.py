"""Graph models of TensorFlow.js: small ones against the same computed in NumPy, and bad ones."""

import base64
import json
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from onnx import TensorProto, helper

from models.errors import ModelFileError
from models.train.tfjs import Translation, Written, read_graph_model

NHWC = {"s": base64.b64encode(b"NHWC").decode()}


def padding(how: str) -> dict[str, str]:
    return {"s": base64.b64encode(how.encode()).decode()}


def ints(*values: int) -> dict[str, Any]:
    return {"list": {"i": [str(v) for v in values]}}


class Drawn:
    """A graph model put together node by node."""

    def __init__(self, size: tuple[int, ...]) -> None:
        self.size, self.nodes, self.table, self.data = size, [], [], b""
        self.node("Placeholder", "x", [])

    def node(self, op: str, name: str, inputs: list[str], **attributes: Any) -> None:
        self.nodes.append({"name": name, "op": op, "input": inputs, "attr": attributes})

    def const(self, name: str, value: np.ndarray) -> str:
        entry = {"name": name, "shape": list(value.shape), "dtype": str(value.dtype)}
        if value.dtype == np.float32:
            entry["quantization"] = {"dtype": "float16", "original_dtype": "float32"}
            value = value.astype(np.float16)
        self.node("Const", name, [])
        self.table.append(entry)
        self.data += value.tobytes()
        return name

    def text(self, outputs: dict[str, tuple[int, ...]]) -> bytes:
        def shapes(of: dict[str, tuple[int, ...]]) -> dict[str, Any]:
            return {
                f"{name}:0": {"tensorShape": {"dim": [{"size": str(s)} for s in shape]}}
                for name, shape in of.items()
            }

        return json.dumps({
            "modelTopology": {"node": self.nodes},
            "weightsManifest": [{"paths": ["w.bin"], "weights": self.table}],
            "signature": {"inputs": shapes({"x": self.size}), "outputs": shapes(outputs)},
        }).encode()  # fmt: skip

    def run(self, outputs: dict[str, tuple[int, ...]], image: np.ndarray) -> list[np.ndarray]:
        """What the translated graph makes of an image."""
        model = read_graph_model(self.text(outputs), self.data, "drawn")
        written = Written()
        stretch = (image.shape[2] / self.size[2], image.shape[3] / self.size[3])
        names = Translation(model, written, "x", stretch).run()
        shown = helper.make_tensor_value_info("x", TensorProto.FLOAT, image.shape)
        said = [
            helper.make_tensor_value_info(names[o], TensorProto.FLOAT, [*"abcd"[: len(shape)]])
            for o, shape in outputs.items()
        ]
        graph = helper.make_graph(written.nodes, "drawn", [shown], said, written.constants)
        opset = [helper.make_opsetid("", 18)]
        file = helper.make_model(graph, opset_imports=opset, ir_version=8)
        onnx.checker.check_model(file)
        session = onnxruntime.InferenceSession(file.SerializeToString())
        return session.run(None, {"x": image})


def image(height: int, width: int) -> np.ndarray:
    return np.random.default_rng(1).normal(size=(1, 2, height, width)).astype(np.float32)


def halves(*shape: int) -> np.ndarray:
    """Values that half precision holds."""
    return np.random.default_rng(2).integers(-8, 8, shape).astype(np.float32) / 4


def convolved() -> tuple[Drawn, np.ndarray, np.ndarray]:
    """A padded convolution with bias and leak, channels last inside: y (1, 3, H, W)."""
    drawn, kernel, bias = Drawn((1, 2, 4, 6)), halves(3, 3, 2, 3), halves(3)
    around = drawn.const("around", np.array([[0, 0], [0, 0], [1, 1], [2, 0]], np.int32))
    drawn.node("Pad", "padded", ["x", around])
    last = drawn.const("last", np.array([0, 2, 3, 1], np.int32))
    drawn.node("Transpose", "t", ["padded", last])
    drawn.node(
        "Conv2D", "conv", ["t", drawn.const("kernel", kernel)], data_format=NHWC,
        padding=padding("VALID"), strides=ints(1, 1, 1, 1), dilations=ints(1, 1, 1, 1),
    )  # fmt: skip
    drawn.node("Add", "biased", ["conv", drawn.const("bias", bias)])
    first = drawn.const("first", np.array([0, 3, 1, 2], np.int32))
    drawn.node("Transpose", "u", ["biased", first])
    drawn.node("LeakyRelu", "y", ["u"], alpha={"f": 0.25})
    return drawn, kernel, bias


def in_numpy(x: np.ndarray, kernel: np.ndarray, bias: np.ndarray) -> np.ndarray:
    padded = np.pad(x, ((0, 0), (0, 0), (1, 1), (2, 0)))
    windows = sliding_window_view(padded, (3, 3), axis=(2, 3))
    y = np.einsum("nchwij,ijcd->ndhw", windows, kernel) + bias[:, None, None]
    return np.where(y > 0, y, y / 4)


def test_a_convolution_and_what_is_around_it() -> None:
    drawn, kernel, bias = convolved()
    x = image(4, 6)
    (y,) = drawn.run({"y": (1, 3, 4, 6)}, x)
    np.testing.assert_allclose(y, in_numpy(x, kernel, bias), atol=1e-5)


def test_parts_are_split_joined_and_reshaped_along_tensorflows_axes() -> None:
    drawn, kernel, bias = convolved()
    # The axes come last here: 3 is the channel.
    drawn.node("Transpose", "z", ["y", "last"])
    sizes, three = drawn.const("sizes", np.array([1, 2], np.int32)), np.array(3, np.int32)
    drawn.node("SplitV", "parts", ["z", sizes, drawn.const("three", three)])
    drawn.node("ConcatV2", "joined", ["parts:1", "parts", "three"])
    nothing = drawn.const("nothing", np.zeros((0, 1), np.int32))
    of = drawn.const("of", np.array([3], np.int32))
    none = drawn.const("none", np.zeros(0, np.int32))
    zero = drawn.const("zero", np.array(0, np.int32))
    drawn.node("SparseToDense", "zeros", [nothing, of, none, zero])
    drawn.node("AddV2", "shape", ["zeros", drawn.const("s", np.array([1, -1, 3], np.int32))])
    drawn.node("Reshape", "rows", ["joined", "shape"])
    drawn.node("Sigmoid", "out", ["rows"])
    x = image(4, 6)
    (out,) = drawn.run({"out": (1, 24, 3)}, x)
    y = in_numpy(x, kernel, bias).transpose(0, 2, 3, 1)
    rows = np.concatenate((y[..., 1:], y[..., :1]), axis=3).reshape(1, 24, 3)
    np.testing.assert_allclose(out, 1 / (1 + np.exp(-rows)), atol=1e-5)


def test_a_larger_image_is_resized_to_as_much_more() -> None:
    drawn, *_ = convolved()
    drawn.node("Transpose", "z", ["x", "last"])
    window = {"ksize": ints(1, 2, 2, 1), "strides": ints(1, 2, 2, 1)}
    drawn.node("MaxPool", "small", ["z"], data_format=NHWC, padding=padding("VALID"), **window)
    size = drawn.const("size", np.array([4, 6], np.int32))
    half = {"half_pixel_centers": {"b": True}, "align_corners": {"b": False}}
    drawn.node("ResizeBilinear", "large", ["small", size], **half)
    drawn.node("Transpose", "back", ["large", "first"])
    drawn.node("Add", "sum", ["x", "back"])
    x = image(8, 6)
    (out,) = drawn.run({"sum": (1, 2, 4, 6)}, x)
    pooled = x.reshape(1, 2, 4, 2, 3, 2).max(axis=(3, 5))
    for axis in (2, 3):  # twice as large, in the middles of pixels: 3 parts of the nearer one
        before = np.concatenate((pooled.take([0], axis), pooled), axis)
        after = np.concatenate((pooled, pooled.take([-1], axis)), axis)
        count = pooled.shape[axis]
        low = 0.75 * pooled + 0.25 * before.take(range(count), axis)
        high = 0.75 * pooled + 0.25 * after.take(range(1, count + 1), axis)
        shape = [*pooled.shape[:axis], 2 * count, *pooled.shape[axis + 1 :]]
        pooled = np.stack((low, high), axis + 1).reshape(shape)
    np.testing.assert_allclose(out, x + pooled, atol=1e-5)


def test_an_operator_without_a_translation_is_named() -> None:
    drawn = Drawn((1, 2, 4, 6))
    drawn.node("Erf", "odd", ["x"])
    with pytest.raises(ModelFileError, match=r"^odd: operator Erf has no translation$"):
        drawn.run({"odd": (1, 2, 4, 6)}, image(4, 6))


def test_files_that_are_no_graph_model_are_refused() -> None:
    drawn, *_ = convolved()
    text = drawn.text({"y": (1, 3, 4, 6)})
    with pytest.raises(ModelFileError, match=r"drawn: \d+ bytes of weights; its table has \d+"):
        read_graph_model(text, drawn.data + b"\0", "drawn")
    for bad, data in ((b"{", b""), (b"[]", b""), (b"{}", b""), (text, drawn.data[:-2])):
        with pytest.raises(ModelFileError, match="drawn: not a graph model"):
            read_graph_model(bad, data, "drawn")
