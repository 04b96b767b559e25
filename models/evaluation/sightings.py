"""What a second look finds, on labelled frames."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from models.detection.detections import Floats, RawDetections
from models.detection.detector import OpenDetector
from models.detection.second_look import SecondLook, SecondLookEvidence, places, strangest
from models.evaluation.truth import FrameTruth, NameLists


@dataclass(frozen=True)
class Places:
    """The likeliest of one frame: `boxes_px` (N, 4), `objectness` (N,), `words` (N, T) of the
    trained categories and `classes` (N, C) of the classifier."""

    boxes_px: Floats
    objectness: Floats
    words: Floats
    classes: Floats


@dataclass(frozen=True)
class Sightings:
    """Of one frame: M places, each as what it may be (`labels`), and what speaks for that."""

    boxes_px: Floats
    labels: np.ndarray
    evidence: SecondLookEvidence

    def scored(self, second: SecondLook) -> tuple[RawDetections, np.ndarray]:
        """As detections, best first, and which each is of these."""
        scores = second.probability(self.evidence)
        order = np.argsort(-scores, kind="stable")
        none, nothing = np.zeros((len(order), 0), np.float32), np.zeros(0, np.float32)
        boxes, labels = self.boxes_px[order], self.labels[order]
        return RawDetections(boxes, scores[order], labels, none, nothing, nothing), order


def look_at_all(
    detector: OpenDetector, second: SecondLook, truth: FrameTruth, words: NameLists
) -> tuple[Places, ...]:
    """Both networks on every frame."""
    detector.set_vocabulary([(name,) for name in words.trained], [])
    found = []
    for rgb in truth.pictures():
        view = detector.look(rgb)
        at = places(view)
        boxes, called = view.boxes_px[at], detector.words(view)[at]
        found.append(Places(boxes, view.objectness[at], called, second.classify(rgb, boxes)))
    return tuple(found)


def sightings(
    looked: Sequence[Places], second: SecondLook, truth: FrameTruth, words: NameLists,
    sought: Mapping[str, Sequence[str]], looks: int,
) -> tuple[Sightings, ...]:  # fmt: skip
    """Of every frame, each of the categories `sought` as a goal of its own, by these names, at
    `looks` places at most. A trained one is sought as if the detector alone had no word for it."""
    trained = list(words.trained)
    own = {name: [trained.index(name)] if name in words.trained else [] for name in sought}
    likeness = {
        label: second.likeness(sought[name])
        for label, name in enumerate(truth.categories)
        if name in sought
    }
    known = {k: v for k, v in likeness.items() if v.any()}
    return tuple(_sighted(part, second, truth.categories, known, own, looks) for part in looked)


def _sighted(
    seen: Places, second: SecondLook, categories: Sequence[str], likeness: Mapping[int, Floats],
    own: Mapping[str, list[int]], looks: int,
) -> Sightings:  # fmt: skip
    boxes, labels = [np.zeros((0, 4), np.float32)], [np.zeros(0, np.int32)]
    told = [np.zeros((3, 0), np.float32)]
    for label, stands in likeness.items():
        others = np.delete(seen.words, own[categories[label]], axis=1)
        at, strangeness = strangest(seen.objectness, others, looks)
        parts = seen.objectness[at], strangeness[at]
        told.append(np.stack(second.evidence(seen.classes[at], stands, *parts)))
        boxes.append(seen.boxes_px[at])
        labels.append(np.full(len(at), label, np.int32))
    evidence = SecondLookEvidence(*np.concatenate(told, axis=1))
    return Sightings(np.concatenate(boxes), np.concatenate(labels), evidence)
