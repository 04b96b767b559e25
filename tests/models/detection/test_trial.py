"""Hostile graphs end in one line, in a process of their own; pictures of every kind are read."""

from pathlib import Path

import cv2
import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from models.detection.trial import RENDERS, Limits, read_picture, tried
from models.errors import ModelFileError

SIZE = (64, 96)
CELLS = 8 * 12 + 4 * 6 + 2 * 3
ENOUGH = Limits(seconds=120)


def save(path: Path, nodes: list[onnx.NodeProto], constants: dict[str, np.ndarray]) -> Path:
    """A graph from an image to (1, 7, CELLS): `zero`, what the nodes make of the image, is added to
    an empty answer."""
    values = {"none": np.zeros((1, 7, CELLS), np.float32), **constants}
    nodes = [*nodes, helper.make_node("Add", ["none", "zero"], ["out"])]
    graph = helper.make_graph(
        nodes,
        "hostile",
        [helper.make_tensor_value_info("image", TensorProto.FLOAT, [1, 3, *SIZE])],
        [helper.make_tensor_value_info("out", TensorProto.FLOAT, [1, 7, CELLS])],
        [numpy_helper.from_array(v, name) for name, v in values.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, {"names": "['couch', 'giraffe', 'tv']"})
    onnx.save(model, str(path))
    return path


def endless() -> tuple[list[onnx.NodeProto], dict[str, np.ndarray]]:
    """A loop of 2^62 rounds."""
    body = helper.make_graph(
        [helper.make_node("Identity", [a], [b]) for a, b in (("go", "on"), ("v", "w"))],
        "body",
        [
            helper.make_tensor_value_info("i", TensorProto.INT64, []),
            helper.make_tensor_value_info("go", TensorProto.BOOL, []),
            helper.make_tensor_value_info("v", TensorProto.FLOAT, []),
        ],
        [
            helper.make_tensor_value_info("on", TensorProto.BOOL, []),
            helper.make_tensor_value_info("w", TensorProto.FLOAT, []),
        ],
    )
    nodes = [
        helper.make_node("ReduceMax", ["image"], ["most"], keepdims=0),
        helper.make_node("Loop", ["rounds", "yes", "most"], ["zero"], body=body),
    ]
    return nodes, {"rounds": np.array(2**62), "yes": np.array(True)}


def huge() -> tuple[list[onnx.NodeProto], dict[str, np.ndarray]]:
    """The image, 30,000 times over: 2 TB."""
    nodes = [
        helper.make_node("Expand", ["image", "wide"], ["much"]),
        helper.make_node("ReduceMax", ["much"], ["zero"], keepdims=0),
    ]
    return nodes, {"wide": np.array([30_000_000, 3, *SIZE])}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("graph", "limits", "said"),
    [
        (endless, Limits(seconds=10), "had not answered after 10 s of its trial; it may never end"),
        (huge, ENOUGH, "asks for more memory than 4000 MB"),
    ],
)
def test_a_hostile_graph_is_one_line(graph, limits: Limits, said: str, tmp_path: Path) -> None:
    path = save(tmp_path / "net.onnx", *graph())
    with pytest.raises(ModelFileError, match=said) as told:
        tried(path, limits)
    assert str(told.value).startswith(f"{path}: ")
    assert "\n" not in str(told.value)


@pytest.mark.slow
def test_every_kind_of_picture(constant_graph, tmp_path: Path) -> None:
    out = np.zeros((1, 7, CELLS), np.float32)
    out[0, :, 0] = (48, 32, 40, 20, 0.9, 0.0, 0.0)
    path = constant_graph({"out": out}, SIZE, {"names": "['couch', 'giraffe', 'tv']"})
    colour = read_picture(RENDERS[0])
    kinds = {
        "one.png": colour[:1, :1],
        "grey.png": colour[..., 0],
        "deep.png": colour.astype(np.uint16) * 257,
        "alpha.png": np.dstack((colour, colour[..., 0])),
        "black.png": colour * 0,
        "large.jpg": np.zeros((6000, 8000, 3), np.uint8),
    }
    for name, picture in kinds.items():
        cv2.imwrite(str(tmp_path / name), picture)
    found = tried(path, ENOUGH, [tmp_path / name for name in kinds])
    assert found.capabilities["contract"] == "yolo v8"
    assert found.frame_ms > 0
    for seen in found.seen:
        assert seen.scores.tolist() == [pytest.approx(0.9)]
        assert seen.embeddings.shape == (1, 0)
    assert read_picture(tmp_path / "deep.png").dtype == np.uint8
    np.testing.assert_array_equal(read_picture(tmp_path / "deep.png"), colour[..., ::-1])
    assert read_picture(tmp_path / "grey.png").shape == colour.shape
    with pytest.raises(ModelFileError, match=r"none\.png: no such picture"):
        tried(path, ENOUGH, [tmp_path / "none.png"])


def test_what_is_no_picture(tmp_path: Path) -> None:
    for content in (b"", b"no picture", RENDERS[0].read_bytes()[:20]):
        (tmp_path / "a.png").write_bytes(content)
        with pytest.raises(ModelFileError, match=r"a\.png: not a picture that can be read"):
            read_picture(tmp_path / "a.png")


def test_the_bundled_renders_are_small() -> None:
    assert [read_picture(path).shape for path in RENDERS] == [(480, 640, 3)] * 3
    assert sum(path.stat().st_size for path in RENDERS) < 150_000
