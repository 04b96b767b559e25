"""Recall by size: what share of the objects that are so many pixels large a detector reports, and
the curve through that, which tells a search what it may have missed."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np

from models.detection.boxes import pairwise_iou
from models.detection.detections import RawDetections
from models.evaluation.judged import Doubles
from models.evaluation.truth import GOALS, FrameTruth

REPORTED: Final = 0.3
"""The calibrated score from which on an object counts as reported: a few such looks make a
candidate."""
OVERLAP: Final = 0.3
"""IoU: of a small thing a box that is a few pixels off still tells where it is."""
IMAGE_PX: Final = 640
"""Sizes are those in an image so wide."""
BINS: Final = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 640)
_TOPS = np.arange(0.5, 1.0, 0.02)
_HALVES = np.arange(2.0, 8.0, 0.1)
_GAINS = np.arange(0.4, 4.0, 0.1)


@dataclass(frozen=True)
class Curve:
    """`top` / (1 + exp(-gain (log2 px - log2 half_px))) of what is px large."""

    top: float
    half_px: float
    gain: float

    def of(self, size_px: Doubles) -> Doubles:
        """(N,) px -> (N,) share that is found."""
        odds = self.gain * (np.log2(size_px) - np.log2(self.half_px))
        return np.asarray(self.top / (1.0 + np.exp(-odds)))


def sizes_found(
    truth: FrameTruth, found: Sequence[RawDetections], names: Collection[str]
) -> tuple[Doubles, Doubles]:
    """Of every object of these categories that counts: its size, the root of its box's area, px of
    an image IMAGE_PX wide; and whether it was reported by its name."""
    sizes, seen = [], []
    wanted = np.array([name in names for name in truth.categories], np.bool_)
    for image, marks, told in zip(truth.table["images"], truth.marks, found, strict=True):
        asked = ~marks.crowd & wanted[marks.kinds]
        boxes, kinds = marks.boxes[asked], marks.kinds[asked]
        sizes.append(
            np.sqrt((boxes[:, 2:] - boxes[:, :2]).prod(axis=1)) * IMAGE_PX / image["width"]
        )
        same = told.labels[:, None] == kinds[None]
        near = pairwise_iou(told.boxes_px, boxes) >= OVERLAP
        seen.append((same & near & (told.scores >= REPORTED)[:, None]).any(axis=0))
    return np.concatenate(sizes).astype(np.float64), np.concatenate(seen).astype(np.float64)


def fitted(sizes_px: Doubles, seen: Doubles) -> Curve:
    """The likeliest curve, by trying."""
    x = np.log2(np.maximum(sizes_px, 1.0))
    best, chosen = np.inf, Curve(0.9, 32.0, 1.0)
    for gain in _GAINS:
        share = 1.0 / (1.0 + np.exp(-gain * (x[None] - _HALVES[:, None])))
        for top in _TOPS:
            p = np.clip(top * share, 1e-6, 1 - 1e-6)
            cost = -(np.log(p) @ seen + np.log(1 - p) @ (1 - seen))
            least = int(cost.argmin())
            if cost[least] < best:
                best = float(cost[least])
                chosen = Curve(float(top), float(2.0 ** _HALVES[least]), float(gain))
    return chosen


def recall_by_size(truth: FrameTruth, found: Sequence[RawDetections]) -> dict[str, Any]:
    """Of what is searched for, the share by size, and the curve."""
    sizes, seen = sizes_found(truth, found, GOALS)
    curve = fitted(sizes, seen)
    rows = []
    for low, high in pairwise((0, *BINS)):
        mine = (sizes >= low) & (sizes < high)
        if mine.any():
            share, told = float(seen[mine].mean()), float(curve.of(sizes[mine]).mean())
            row = {"from_px": low, "to_px": high, "objects": int(mine.sum())}
            rows.append(row | {"recall": share, "curve": told})
    return {"score": REPORTED, "sizes": rows, "curve": vars(curve)}
