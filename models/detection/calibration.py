"""What a file's metadata says of its scores: constants, and the calibration among them."""

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from models.errors import ModelFileError

FloatT = TypeVar("FloatT", bound=np.floating)

PREFIX = "value."
"""Of the keys in an ONNX file's metadata that hold a constant."""


def read_constants(metadata: Mapping[str, str], path: Path) -> dict[str, float]:
    """The constants in the metadata of the file at `path`, with gain 1 and shift 0 where it has
    no calibration. Raises ModelFileError for what is no number, and for a gain that would turn
    the order of the scores round."""
    constants = {"gain": 1.0, "shift": 0.0}
    for key, written in metadata.items():
        if key.startswith(PREFIX):
            constants[key.removeprefix(PREFIX)] = _number(key, written, path)
    if constants["gain"] <= 0:
        raise ModelFileError(
            f"{path}: {PREFIX}gain {constants['gain']:g} of no use; it must be above 0"
        )
    return constants


def _number(key: str, written: str, path: Path) -> float:
    try:
        number = float(written)
    except ValueError:
        number = float("nan")
    if not np.isfinite(number):
        raise ModelFileError(
            f"{path}: {key} {written[:40]!r} of no use; it must be a finite number"
        )
    return number


def log_odds(scores: NDArray[np.floating]) -> NDArray[np.float64]:
    """(...) scores in 0..1 -> (...) their log odds, kept finite. In double precision what is very
    likely still differs from what is even more so."""
    p = np.clip(scores, 1e-6, 1 - 1e-6, dtype=np.float64)
    return np.asarray(np.log(p / (1 - p)), np.float64)


def sigmoid(odds: NDArray[FloatT]) -> NDArray[FloatT]:
    """(...) log odds -> (...) in 0..1, as precise as they are."""
    return np.asarray(1 / (1 + np.exp(-np.clip(odds, -60, 60))), odds.dtype)


def softmax(logits: NDArray[np.float32]) -> NDArray[np.float32]:
    """(..., K) -> (..., K) probabilities of each row; what is minus infinity has none."""
    top = logits.max(axis=-1, keepdims=True, initial=-np.inf)
    weights = np.exp(logits - np.where(np.isneginf(top), 0, top))
    return np.asarray(weights / weights.sum(axis=-1, keepdims=True).clip(1e-12), np.float32)


def calibrated(scores: NDArray[np.floating], gain: float, shift: float) -> NDArray[np.float64]:
    """(...) scores in 0..1 -> (...) the same with their log odds times gain plus shift."""
    return sigmoid(gain * log_odds(scores) + shift)


def settled(scores: NDArray[np.float32], gain: float, shift: float) -> NDArray[np.float32]:
    """(N,) scores, calibrated where the file says how."""
    if (gain, shift) == (1.0, 0.0):
        return scores
    return calibrated(scores.astype(np.float64), gain, shift).astype(np.float32)
