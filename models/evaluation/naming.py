"""Frames looked at once, and named as often as vocabularies are tried."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.detection.detections import NAMES, Detector, RawDetections
from models.detection.detector import DetectorView, OpenDetector
from models.evaluation.truth import FrameTruth
from models.words.text_encoder import TextEncoder

Floats = NDArray[np.float32]
NOTHING = ("thing",)
"""What frames without any category are asked for."""
NONE = np.zeros((0, 0), np.float32)
"""Not kept: embeddings of what was found are in the views."""


@dataclass(frozen=True)
class Looked:
    """An open detector's views of all frames; a class is one name here."""

    detector: OpenDetector
    categories: tuple[str, ...]
    views: tuple[DetectorView, ...]
    rooms: tuple[int, ...]  # index of each frame's likeliest room
    cosines: tuple[Floats, ...]  # (K, C) a frame
    found: tuple[RawDetections, ...]

    def with_names(self, label: int, rows: Floats) -> tuple[RawDetections, ...]:
        """Detections when class `label` is asked for by other text rows (M, D) instead."""
        out = []
        for view, cosines, before in zip(self.views, self.cosines, self.found, strict=True):
            column = (view.regions.astype(np.float32) @ rows.T).max(axis=1)
            others = np.delete(cosines, label, axis=1)
            enough = others.shape[1] >= NAMES
            last = np.partition(others, -NAMES, axis=1)[:, -NAMES] if enough else np.float32(-1)
            if not ((cosines[:, label] >= last) | (column >= last)).any():
                out.append(before)  # no place was called this, none will be
                continue
            changed = cosines.copy()
            changed[:, label] = column
            out.append(self.detector.named(view, changed))
        return tuple(out)


def asked_for(truth: FrameTruth) -> list[tuple[str, ...]]:
    """The vocabulary that a detector is asked by: each category by its one name."""
    return [(c,) for c in truth.categories or NOTHING]


def _known(found: RawDetections, truth: FrameTruth) -> RawDetections:
    """Nothing where nothing is boxed: frames whose room alone is known."""
    if truth.categories:
        return found
    none = np.zeros(0, np.float32)
    return found._replace(boxes_px=NONE.reshape(0, 4), scores=none, labels=none.astype(np.int32))


def look(
    detector: OpenDetector, truth: FrameTruth, encoder: TextEncoder, rooms: list[str]
) -> Looked:
    """Run the network on every frame once. Regions are kept in half precision: 1,000 frames of 300
    take 240 MB."""
    rows = encoder.embed(truth.categories or NOTHING)
    detector.set_vocabulary(asked_for(truth), rooms)
    views, likeliest, cosines, found = [], [], [], []
    for rgb in truth.pictures():
        view = detector.look(rgb)
        likeliest.append(int(detector.room(view).argmax()))
        cosines.append(view.regions @ rows.T)
        named = detector.named(view, cosines[-1])._replace(embeddings=NONE)
        found.append(_known(named, truth))
        views.append(view._replace(regions=view.regions.astype(np.float16)))
    parts = tuple(views), tuple(likeliest), tuple(cosines), tuple(found)
    return Looked(detector, truth.categories, *parts)


def detect_all(
    detector: Detector, truth: FrameTruth, rooms: list[str]
) -> tuple[tuple[RawDetections, ...], tuple[int, ...]]:
    """Detections and likeliest room of every frame, by a detector of any contract; -1: none."""
    detector.set_vocabulary(asked_for(truth), rooms)
    found = tuple(_known(detector.detect(rgb), truth) for rgb in truth.pictures())
    return found, tuple(int(f.rooms.argmax()) if len(f.rooms) else -1 for f in found)
