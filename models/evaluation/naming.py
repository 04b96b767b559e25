"""Frames looked at once, and named as often as vocabularies are tried."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.detections import Detector, RawDetections, select
from models.detector import OpenDetector, View
from models.evaluation.truth import Truth
from models.text import TextEncoder

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Looked:
    """An open detector's views of all frames; a class is one name here."""

    detector: OpenDetector
    categories: tuple[str, ...]
    views: tuple[View, ...]
    rooms: tuple[int, ...]  # index of each frame's likeliest room
    cosines: tuple[Floats, ...]  # (K, C) a frame
    found: tuple[RawDetections, ...]

    def with_name(self, label: int, row: Floats) -> tuple[RawDetections, ...]:
        """Detections when class `label` is asked for by another text row (D,) instead."""
        out = []
        for view, cosines, before in zip(self.views, self.cosines, self.found, strict=True):
            column = view.regions.astype(np.float32) @ row
            best = cosines.argmax(axis=1)
            rest = np.delete(cosines, label, axis=1).max(axis=1, initial=-1.0)
            if not ((best == label) | (column > rest)).any():
                out.append(before)  # nothing was of this class, nothing becomes it
                continue
            changed = cosines.copy()
            changed[:, label] = column
            out.append(name(self.detector, view, changed))
        return tuple(out)


def name(detector: OpenDetector, view: View, cosines: Floats) -> RawDetections:
    """Detections of one view, given the (K, C) cosines of its regions with each class."""
    labels = cosines.argmax(axis=1).astype(np.int32)
    scores = detector.score(view.objectness, cosines[np.arange(len(labels)), labels])
    kept = select(view.boxes_px, scores, labels)
    none = np.zeros((len(kept), 0), np.float32)
    nothing = np.zeros(0, np.float32)
    return RawDetections(view.boxes_px[kept], scores[kept], labels[kept], none, nothing, nothing)


def look(detector: OpenDetector, truth: Truth, encoder: TextEncoder, rooms: list[str]) -> Looked:
    """Run the network on every frame once. Regions are kept in half precision: 1,000 frames of 100
    take 80 MB."""
    rows = encoder.embed(truth.categories)
    detector.set_vocabulary([(c,) for c in truth.categories], rooms)
    views, likeliest, cosines, found = [], [], [], []
    for rgb in truth.pictures():
        view = detector.look(rgb)
        likeliest.append(int(detector.room(view).argmax()))
        cosines.append(view.regions @ rows.T)
        found.append(name(detector, view, cosines[-1]))
        views.append(view._replace(regions=view.regions.astype(np.float16)))
    parts = tuple(views), tuple(likeliest), tuple(cosines), tuple(found)
    return Looked(detector, truth.categories, *parts)


def detect_all(
    detector: Detector, truth: Truth, rooms: list[str]
) -> tuple[tuple[RawDetections, ...], tuple[int, ...]]:
    """Detections and likeliest room of every frame, by a detector of any contract; -1: none."""
    detector.set_vocabulary([(c,) for c in truth.categories], rooms)
    found = tuple(detector.detect(rgb) for rgb in truth.pictures())
    return found, tuple(int(f.rooms.argmax()) if len(f.rooms) else -1 for f in found)
