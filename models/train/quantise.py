"""The exported network in 8 bits: convolutions of the body; what answers in numbers stays float.

Weights are int8 with a scale a channel, activations uint8 with ranges seen on training frames.
Boxes, objectness and embeddings come from float layers behind the towers, and the stem stays float:
an integer convolution of three channels is slower than a float one.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnxruntime.quantization import (
    CalibrationDataReader,
    CalibrationMethod,
    QuantFormat,
    QuantType,
    quantize_static,
)
from onnxruntime.quantization.quant_utils import add_pre_process_metadata

from models.detection.boxes import letterbox
from models.train.data import load

QUANTISED = ["Conv", "Clip", "Relu", "Add", "MaxPool", "Resize"]
BODY = ("/backbone/", "/pyramid/", "/head/where", "/head/what")
STEM = "/backbone/stem/"
FRAMES = 48
"""Training frames whose activations give the ranges."""


class _Frames(CalibrationDataReader):
    """Frames as the network takes them, one after the other."""

    def __init__(self, paths: Sequence[Path], size: tuple[int, int]) -> None:
        self._paths, self._size = iter(paths), size

    def get_next(self) -> dict[str, Any] | None:  # type: ignore[override]
        path = next(self._paths, None)
        if path is None:
            return None
        image, _ = letterbox(load(path), self._size[1], self._size[0])
        return {"image": np.ascontiguousarray(image.transpose(2, 0, 1)[None], np.float32)}


def quantise(source: Path, out: Path, frames: Sequence[Path], size: tuple[int, int]) -> None:
    """Write `source`, a float network of `size` (width, height), in 8 bits.

    `frames`: images to take ranges from; FRAMES of them, evenly drawn, are used.
    """
    model = onnx.load(str(source))
    add_pre_process_metadata(model)  # constants are folded and shapes known already
    nodes = [n.name for n in model.graph.node if _belongs(n.name)]
    chosen = [
        frames[i] for i in np.linspace(0, len(frames) - 1, min(FRAMES, len(frames))).astype(int)
    ]
    quantize_static(
        model,
        str(out),
        _Frames(chosen, size),
        quant_format=QuantFormat.QDQ,
        op_types_to_quantize=QUANTISED,
        nodes_to_quantize=nodes,
        per_channel=True,
        activation_type=QuantType.QUInt8,
        weight_type=QuantType.QInt8,
        calibrate_method=CalibrationMethod.MinMax,
    )


def _belongs(name: str) -> bool:
    return any(part in name for part in BODY) and STEM not in name
