"""Networks of the paper's baselines that answer in a known way: towers by colour and place, and one
that knows a few words of a caption."""

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from tokenizers import Tokenizer

from models.detection.clip import SCALING
from models.store import manifest

MEAN, STD = np.array(SCALING[1:], np.float32) / 255
WIDTH = 6
"""Of the towers' rows: red, green, blue, how far to the right and how far down that is, and what
all have."""
MEANS = {
    "sofa": (1, 0, 0, 0, 0, 0),
    "toilet": (0, 0, 1, 0, 0, 0),
    "wall": (0, 1, 0, 0, 0, 0),
    "floor": (0, 1, 0, 0, 0, 0),
    "left": (0, 0, 0, -1, 0, 0),
    "right": (0, 0, 0, 1, 0, 0),
    "top": (0, 0, 0, 0, -1, 0),
    "bottom": (0, 0, 0, 0, 1, 0),
}
EVERY_WORD = np.array((0, 0, 0, 0, 0, 0.02))
TOKENIZER = "tokenizer.json"


def sentence_row(sentence: str) -> NDArray[np.float32]:
    """(6,) what the text tower gives: the sum over the words."""
    rows = [np.array(MEANS.get(word, np.zeros(WIDTH))) + EVERY_WORD for word in sentence.split()]
    return np.sum(rows, axis=0).astype(np.float32)


def image_tower(
    path: Path,
    side: int = 16,
    batch: int | str = "n",
    grid: int = 0,
    rank: int = 3,
    metadata: dict[str, str] | None = None,
) -> Path:
    """Any number of pictures, or `batch`, to (N, 6). With a `grid` it takes a text, too, and gives
    (1, grid, grid), or (1, 1, grid, grid) for rank 4: how far each cell has the text's colour."""
    across = (np.arange(side) + 0.5) / side * 2 - 1
    kernel = np.zeros((WIDTH, 3, side, side), np.float32)
    for colour in range(3):
        kernel[colour, colour] = STD[colour] / side**2
        kernel[3, colour] = 4 * across[None] * STD[colour] / side**2
        kernel[4, colour] = 4 * across[:, None] * STD[colour] / side**2
    bias = np.array([*MEAN, 0, 0, 0.02], np.float32)
    constants = {"kernel": kernel, "bias": bias}
    nodes = [
        helper.make_node("Conv", ["image", "kernel", "bias"], ["wide"]),
        helper.make_node("Flatten", ["wide"], ["embedding"]),
    ]
    inputs: dict[str, list[int | str]] = {"image": [batch, 3, side, side]}
    outputs: dict[str, list[int | str]] = {"embedding": [batch, WIDTH]}
    if grid:
        inputs["text"] = ["t", WIDTH]
        outputs["relevance"] = [1] * (rank - 2) + [grid, grid]
        nodes += _relevance_nodes(side // grid)
        constants |= {
            "std": np.array(STD).reshape(1, 3, 1, 1),
            "mean": np.array(MEAN).reshape(1, 3, 1, 1),
            "cells": np.array([3, grid * grid], np.int64),
            "begin": np.array([0], np.int64),
            "end": np.array([3], np.int64),
            "axis": np.array([1], np.int64),
            "map": np.array(outputs["relevance"], np.int64),
        }
    return _saved(path, nodes, inputs, outputs, constants, metadata)


def _relevance_nodes(cell: int) -> list[onnx.NodeProto]:
    return [
        helper.make_node("Mul", ["image", "std"], ["scaled"]),
        helper.make_node("Add", ["scaled", "mean"], ["colour"]),
        helper.make_node(
            "AveragePool", ["colour"], ["coarse"], kernel_shape=[cell, cell], strides=[cell, cell]
        ),
        helper.make_node("Reshape", ["coarse", "cells"], ["columns"]),
        helper.make_node("Slice", ["text", "begin", "end", "axis"], ["wanted"]),
        helper.make_node("MatMul", ["wanted", "columns"], ["flat"]),
        helper.make_node("Reshape", ["flat", "map"], ["relevance"]),
    ]


def text_tower(folder: Path) -> Path:
    """A text tower that adds up words as `sentence_row` does, its tokenizer beside it."""
    folder.mkdir()
    shutil.copy(manifest.fetch("minilm") / TOKENIZER, folder)
    tokenizer = Tokenizer.from_file(str(folder / TOKENIZER))
    table = np.tile(EVERY_WORD, (tokenizer.get_vocab_size(), 1)).astype(np.float32)
    for word, row in MEANS.items():
        table[tokenizer.token_to_id(word)] += np.array(row, np.float32)
    nodes = [
        helper.make_node("Gather", ["table", "input_ids"], ["words"]),
        helper.make_node("Unsqueeze", ["attention_mask", "last"], ["mask"]),
        helper.make_node("Cast", ["mask"], ["share"], to=TensorProto.FLOAT),
        helper.make_node("Mul", ["words", "share"], ["counted"]),
        helper.make_node("ReduceSum", ["counted", "axis"], ["text_embeds"], keepdims=0),
    ]
    constants = {
        "table": table, "axis": np.array([1], np.int64), "last": np.array([2], np.int64)
    }  # fmt: skip
    caption: dict[str, list[int | str]] = {"input_ids": [1, 77], "attention_mask": [1, 77]}
    return _saved(folder / "text.onnx", nodes, caption, {"text_embeds": [1, WIDTH]}, constants)


def grounding_network(
    path: Path,
    boxes: Sequence[Sequence[float]],
    words: Sequence[str],
    length: int | str = "t",
    side: int = 32,
    heard: int = 99,
) -> Path:
    """Query i is at `boxes[i]` (cx, cy, w, h in 0..1). Its logit of a token is the image's mean
    where the token is `words[i]`, else -9; that of "no object", the last one, is 1.
    There are logits for so many of the tokens as are `heard`."""
    shutil.copy(manifest.fetch("minilm") / TOKENIZER, path.parent)
    tokenizer = Tokenizer.from_file(str(path.parent / TOKENIZER))
    known = np.array([[[tokenizer.token_to_id(word)] for word in words]], np.int64)
    constants = {
        "known": known,
        "axis": np.array([1], np.int64),
        "begin": np.array([0], np.int64),
        "heard": np.array([heard], np.int64),
        "last": np.array([2], np.int64),
        "low": np.float32(-9),
        "none": np.ones((1, len(words), 1), np.float32),
        "places": np.array([boxes], np.float32),
        "zero": np.float32(0),
    }
    nodes = [
        helper.make_node("ReduceMean", ["image"], ["mean"], keepdims=0),
        helper.make_node("Mul", ["mean", "zero"], ["nothing"]),
        helper.make_node("Add", ["places", "nothing"], ["pred_boxes"]),
        helper.make_node("Unsqueeze", ["input_ids", "axis"], ["ids"]),
        helper.make_node("Equal", ["ids", "known"], ["same"]),
        helper.make_node("Where", ["same", "mean", "low"], ["tokens"]),
        helper.make_node("Unsqueeze", ["attention_mask", "axis"], ["mask"]),
        helper.make_node("Cast", ["mask"], ["real"], to=TensorProto.BOOL),
        helper.make_node("Where", ["real", "tokens", "low"], ["named"]),
        helper.make_node("Slice", ["named", "begin", "heard", "last"], ["first"]),
        helper.make_node("Concat", ["first", "none"], ["pred_logits"], axis=2),
    ]
    inputs = {
        "image": [1, 3, side, side],
        "input_ids": [1, length],
        "attention_mask": [1, length],
    }
    outputs = {"pred_logits": [1, len(words), "s"], "pred_boxes": [1, len(words), len(boxes[0])]}
    return _saved(path, nodes, inputs, outputs, constants)


def _saved(
    path: Path,
    nodes: list[onnx.NodeProto],
    inputs: dict[str, list[int | str]],
    outputs: dict[str, list[int | str]],
    constants: dict[str, NDArray],
    metadata: dict[str, str] | None = None,
) -> Path:
    def told(shapes: dict[str, list[int | str]]) -> list[onnx.ValueInfoProto]:
        kinds = {"input_ids": TensorProto.INT64, "attention_mask": TensorProto.INT64}
        return [
            helper.make_tensor_value_info(name, kinds.get(name, TensorProto.FLOAT), shape)
            for name, shape in shapes.items()
        ]

    values = [numpy_helper.from_array(np.asarray(v), name) for name, v in constants.items()]
    graph = helper.make_graph(nodes, "baseline", told(inputs), told(outputs), values)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, metadata or {})
    onnx.save(model, str(path))
    return path
