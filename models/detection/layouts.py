"""Output layouts of YOLO exports, decoded to boxes and class scores.

| layout | output | boxes | score |
|---|---|---|---|
| v5 | (1, N, 5 + C), N = 3 per cell | cx, cy, w, h px | objectness * class |
| v8 | (1, 4 + C, N) | cx, cy, w, h px | class |
| X | (1, N, 5 + C), N = 1 per cell | cell offsets and log sizes, undecoded | objectness * class |
"""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError

STRIDES = (8, 16, 32)
ANCHORS_V5 = 3

Floats = NDArray[np.float32]
Layout = Literal["v5", "v8", "X"]


class Decoded(NamedTuple):
    """`boxes` (N, 4) corners in network px, `scores` (N, C)."""

    boxes: Floats
    scores: Floats


def recognise(shape: tuple[int, ...], height: int, width: int, where: str) -> tuple[Layout, int]:
    """Layout and number of classes from an output's shape and the input's size."""
    if len(shape) == 3 and shape[0] == 1:
        cells = sum((height // s) * (width // s) for s in STRIDES)
        if shape[2] == cells and shape[1] > 4:
            return "v8", shape[1] - 4
        if shape[1] == cells and shape[2] > 5:
            return "X", shape[2] - 5
        if shape[1] == ANCHORS_V5 * cells and shape[2] > 5:
            return "v5", shape[2] - 5
    raise ModelFileError(
        f"{where}: output {shape} for input {height}x{width} is no known YOLO layout; "
        "expected (1, N, 5+C) as YOLOv5 or YOLOX give it, or (1, 4+C, N) as YOLOv8 does"
    )


def decode(output: Floats, layout: Layout, height: int, width: int) -> Decoded:
    """One network output -> corners in network px and scores per class."""
    rows = output[0].T if layout == "v8" else output[0]
    if layout == "v8":
        return Decoded(_corners(rows[:, :4]), rows[:, 4:])
    scores = rows[:, 4:5] * rows[:, 5:]
    if layout == "v5":
        return Decoded(_corners(rows[:, :4]), scores)
    origin, stride = _cells(height, width)
    middle = (rows[:, :2] + origin) * stride
    size = np.exp(np.minimum(rows[:, 2:4], 20.0)) * stride
    return Decoded(_corners(np.concatenate((middle, size), axis=1)), scores)


def _corners(cxcywh: Floats) -> Floats:
    half = cxcywh[:, 2:] / 2
    return np.concatenate((cxcywh[:, :2] - half, cxcywh[:, :2] + half), axis=1)


def _cells(height: int, width: int) -> tuple[Floats, Floats]:
    """(N, 2) cell columns and rows, (N, 1) strides, finest level first."""
    origins, strides = [], []
    for stride in STRIDES:
        y, x = np.mgrid[: height // stride, : width // stride]
        origin = np.stack((x, y), -1).reshape(-1, 2).astype(np.float32)
        origins.append(origin)
        strides.append(np.full((len(origin), 1), stride, np.float32))
    return np.concatenate(origins), np.concatenate(strides)


def decode_prompted(outputs: list[Floats], prompts: int, where: str) -> Decoded:
    """Outputs of a network that takes texts -> corners in network px and a score per prompt."""
    shapes = [out.shape for out in outputs]
    by_shape = {out.shape[2]: out for out in outputs if out.ndim == 3 and out.shape[0] == 1}
    if len(outputs) == 1 and shapes[0][:2] == (1, 4 + prompts) and len(shapes[0]) == 3:
        rows = outputs[0][0].T
        return Decoded(_corners(rows[:, :4]), rows[:, 4:])
    if len(outputs) == 2 and prompts != 4 and set(by_shape) == {4, prompts}:
        boxes, scores = by_shape[4][0], by_shape[prompts][0]
        if len(boxes) == len(scores):
            return Decoded(boxes, scores)
    if shapes[0] == shapes[-1] and prompts == 4 and len(outputs) == 2:
        return Decoded(outputs[0][0], outputs[1][0])  # as documented: boxes, then scores
    raise ModelFileError(
        f"{where}: outputs {shapes} for {prompts} texts; expected boxes (1, L, 4) and scores "
        f"(1, L, {prompts}), or (1, {4 + prompts}, L)"
    )
