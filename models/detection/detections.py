"""What every detector gives and takes, whatever its contract."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from models.detection.boxes import suppress
from models.errors import ModelFileError

MIN_SCORE = 0.01
SAME_CLASS_IOU, OTHER_CLASS_IOU = 0.5, 0.8
MAX_DETECTIONS = 100
NAMES = 2
"""How many classes a place may be called, each with its own score: a mug is often called a cup too.
With one, less is found at the same rate of false sightings."""

Floats = NDArray[np.float32]
NOTHING: tuple[Floats, Floats, NDArray[np.int32]] = (
    np.zeros((0, 4), np.float32), np.zeros(0, np.float32), np.zeros(0, np.int32),
)  # fmt: skip
"""Boxes, scores and labels of none."""


NO_FEATURES: Floats = np.zeros((0, 0, 0), np.float32)


class RawDetections(NamedTuple):
    """One frame's detections, best first, and what room it shows.

    `boxes_px` (N, 4) x0, y0, x1, y1 in image px; `scores` (N,) in 0..1; `labels` (N,) index into
    the classes; `embeddings` (N, D) unit rows in the text encoder's space, or (N, 0); `rooms`
    (R,) probabilities in the order given, or (0,); `scene` (D,) the whole image's unit row, or
    (0,); `features` (C, h, w) what the backbone has of each part of the image, or (0, 0, 0).
    """

    boxes_px: Floats
    scores: Floats
    labels: NDArray[np.int32]
    embeddings: Floats
    rooms: Floats
    scene: Floats
    features: Floats = NO_FEATURES


class Detector(Protocol):
    """What the runtime asks of a detector. One thread at a time may use it.

    `capabilities` is JSON: `contract`, `open_vocabulary`, `rooms`, `embeddings`, `classes` (its
    fixed list or None), for a fixed list `class_map` (whose map it is matched by, or None), and
    once there is a vocabulary `matched` (class -> what stands for it, with
    a cosine where it is by similarity) and `unseen` (classes that it cannot see).
    """

    @property
    def capabilities(self) -> dict[str, Any]: ...

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Choose the classes (each its names, canonical first) and the room types."""

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections."""


def checked(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The frame itself, or ModelFileError for what is none."""
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8 or not rgb.size:
        raise ModelFileError(f"a frame is (H, W, 3) uint8 RGB, not {rgb.shape} {rgb.dtype}")
    return rgb


def select(
    boxes: Floats, scores: Floats, labels: NDArray[np.int32], across: float = OTHER_CLASS_IOU,
    within: float = SAME_CLASS_IOU,
) -> NDArray[np.int64]:  # fmt: skip
    """Indices of what is reported: scored, of some area, not covered by more than `within` by a
    better box of its class, nor by more than `across` by one of another."""
    area = (boxes[:, 2:] - boxes[:, :2]).clip(0).prod(axis=1)
    candidates = np.flatnonzero((scores >= MIN_SCORE) & (area > 0) & (labels >= 0))
    candidates = candidates[np.argsort(-scores[candidates], kind="stable")][: 4 * MAX_DETECTIONS]
    kept = suppress(boxes[candidates], scores[candidates], labels[candidates], within, across)
    return candidates[kept][:MAX_DETECTIONS]


def likeliest(values: Floats) -> NDArray[np.int64]:
    """(K, C) -> (K, min(NAMES, C)) columns of each row's largest values."""
    count = min(NAMES, values.shape[1])
    if not count:
        return np.zeros((len(values), 0), np.int64)
    return np.argpartition(-values, count - 1, axis=1)[:, :count]


def boxes_only(
    boxes: Floats, scores: Floats, labels: NDArray[np.int32], across: float = OTHER_CLASS_IOU,
    within: float = SAME_CLASS_IOU,
) -> RawDetections:  # fmt: skip
    """Detections of a network that says nothing of regions or rooms; not finite is not there."""
    sound = np.isfinite(boxes).all(axis=1) & np.isfinite(scores)
    scores = np.where(sound, scores, 0).astype(np.float32)
    boxes = np.where(sound[:, None], boxes, 0).astype(np.float32)
    kept = select(boxes, scores, labels, across, within)
    return unembedded(boxes[kept], scores[kept], labels[kept])


def unembedded(boxes: Floats, scores: Floats, labels: NDArray[np.int32]) -> RawDetections:
    """These detections, all of them, without regions, rooms or a scene."""
    none = np.zeros(0, np.float32)
    return RawDetections(boxes, scores, labels, np.zeros((len(boxes), 0), np.float32), none, none)
