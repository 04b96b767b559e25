"""A second look at what the detector has no word for: an ImageNet classifier and its 1,000 names.

Our detector sees that something is there, but knows no name that it was not trained with. So of a
frame's places that are surely a thing, and unlike all that it has a word for, a few are shown to
the classifier one by one. What is sought may be any text: the classes with the most similar names
stand for it, as far as a place looks more like them than places usually do.
"""

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from models.detection.boxes import suppress
from models.detection.calibration import sigmoid, softmax
from models.detection.detections import Floats, RawDetections, boxes_only
from models.detection.detector import DetectorView, OpenDetector
from models.errors import ModelFileError
from models.onnx_session import image_size, open_session, run
from models.words.text_encoder import TextEncoder

FORMAT = "rf-nav-second-look/1"
PLACES = 15
"""Of a frame, among which those that are least known are looked at."""
LOOKS = 5
"""So many of them, where nothing else is said: what evidence is worth was fitted with these."""
APART_IOU = 0.5
CHOSEN, FITTED = (
    ("margin", "alike", "spread"),
    ("resemblance", "objectness", "strangeness", "shift"),
)
SAME_ROW = 0.01
"""How far values of two text rows may lie apart that are from one encoder."""
LEAST = 1e-6
"""Of a probability, before its logarithm is taken."""


class SecondLookEvidence(NamedTuple):
    """What speaks for N places being what is sought, each natural logarithms (N,): how much more it
    looks like it than places usually do, how surely it is a thing, how surely an unknown one."""

    resemblance: Floats
    objectness: Floats
    strangeness: Floats


class SecondLook:
    """The classifier.

    Its file: `crops` (N, 3, H, W) float32 RGB 0..255 -> `logits` (N, C); metadata `format`, `names`
    and `usual` (JSON, C of them each: what a class is called, and its probability in the mean of
    all places); constants `value.margin`, of a square crop around a box; `value.alike`, the cosine
    of two names from which on one may stand for the other, and `value.spread`, by which a less
    similar one than the best counts e times less; `value.resemblance`, `.objectness`,
    `.strangeness` and `.shift`: the log odds per unit of evidence, and without any. It may hold
    `rows`, base64: the names' embeddings (C, D) float16.
    """

    def __init__(self, path: Path, encoder: TextEncoder, threads: int = 1) -> None:
        self._path, self._encoder = path, encoder
        self._session = open_session(path, threads)
        table = self._session.get_modelmeta().custom_metadata_map
        if table.get("format") != FORMAT:
            raise ModelFileError(
                f"{path}: not a classifier for second looks (format "
                f"{table.get('format', 'missing')!r}, expected {FORMAT!r})"
            )
        try:
            self.names: tuple[str, ...] = tuple(json.loads(table["names"]))
            self._usual = np.array(json.loads(table["usual"]), np.float32)
            value = {k: float(table[f"value.{k}"]) for k in (*CHOSEN, *FITTED)}
            rows = np.frombuffer(base64.b64decode(table.get("rows", "")), np.float16)
        except (KeyError, ValueError, TypeError) as error:
            raise ModelFileError(
                f"{path}: of its metadata is missing or no use: {error}"
            ) from error
        classes = self._session.get_outputs()[0].shape[-1]
        if not len(self.names) == self._usual.size == classes:
            raise ModelFileError(
                f"{path}: {classes} classes, but {len(self.names)} names and {self._usual.size} "
                "usual probabilities; make it anew with models.train.second_look"
            )
        self._value = value
        self._weights = np.array([value[k] for k in FITTED[:3]], np.float32)
        self._input = self._session.get_inputs()[0].name
        self._size = image_size(self._session.get_inputs()[0].shape, path)
        self._rows = self._named(rows.astype(np.float32))

    def _named(self, rows: Floats) -> Floats:
        """The names' embeddings (C, D), as the file has them (C * D,) if they are this encoder's:
        embedding a thousand takes seconds."""
        shape = len(self.names), self._encoder.dimension
        probe = [0, len(self.names) // 2, len(self.names) - 1]
        if rows.size == shape[0] * shape[1] and np.isfinite(rows).all():
            kept = rows.reshape(shape)
            own = self._encoder.embed([self.names[i] for i in probe])
            if np.abs(kept[probe] - own).max() < SAME_ROW:
                return kept
        return self._encoder.embed(self.names)

    def likeness(self, names: Sequence[str]) -> Floats:
        """(C,) how far each class stands for what is called so, the best with 1; all 0: none does.
        The first name counts; the others, which may mean something else, too (a bicycle is also a
        wheel), when no class is like that."""
        cosines = self._rows @ self._encoder.embed(names).T
        for cosine in (cosines[:, 0], cosines.max(axis=1)):
            weights = np.exp((cosine - cosine.max()) / self._value["spread"])
            likeness = np.where(cosine >= self._value["alike"], weights, 0).astype(np.float32)
            if likeness.any():
                break
        return likeness

    def classify(self, rgb: NDArray[np.uint8], boxes_px: Floats) -> Floats:
        """(H, W, 3) RGB, (N, 4) -> (N, C) with what probability each place is of each class."""
        if not len(boxes_px):
            return np.zeros((0, len(self.names)), np.float32)
        crops = np.stack([self._crop(rgb, box) for box in boxes_px])
        feed = np.ascontiguousarray(crops.transpose(0, 3, 1, 2), np.float32)
        (logits,) = run(self._session, {self._input: feed}, self._path)
        return softmax(logits)

    def evidence(
        self, classes: Floats, likeness: Floats, objectness: Floats, strangeness: Floats
    ) -> SecondLookEvidence:
        """Of N places: `classes` (N, C) from `classify`, `likeness` (C,) of what is sought,
        `objectness` and `strangeness` (N,) in 0..1."""
        resemblance = _log(classes @ likeness) - _log(self._usual @ likeness)
        return SecondLookEvidence(resemblance, _log(objectness), _log(strangeness))

    def probability(self, evidence: SecondLookEvidence) -> Floats:
        """(N,) with what probability each place is what is sought."""
        odds = self._weights @ np.stack(evidence) + self._value["shift"]
        return sigmoid(np.asarray(odds, np.float32))

    def _crop(self, rgb: NDArray[np.uint8], box: Floats) -> NDArray[np.uint8]:
        """A square around a box, whose rim is repeated beyond the image."""
        height, width = self._size
        x0, y0, x1, y1 = (float(v) for v in box)
        side = max(self._value["margin"] * max(x1 - x0, y1 - y0), 1.0)
        zoom = min(height, width) / side
        left, top = width / 2 - zoom * (x0 + x1) / 2, height / 2 - zoom * (y0 + y1) / 2
        warp = np.array([[zoom, 0, left], [0, zoom, top]], np.float32)
        crop = cv2.warpAffine(rgb, warp, (width, height), borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(crop, np.uint8)


def _log(p: Floats) -> Floats:
    return np.asarray(np.log(np.maximum(p, LEAST)), np.float32)


def places(view: DetectorView) -> NDArray[np.int64]:
    """(N,) the likeliest places of a view, none twice."""
    one = np.zeros(len(view.boxes_px), np.int32)
    return suppress(view.boxes_px, view.objectness, one, APART_IOU, APART_IOU)[:PLACES]


def strangest(objectness: Floats, words: Floats, most: int) -> tuple[NDArray[np.int64], Floats]:
    """Of N places the `most` that are most surely things that there is no word for, and the
    strangeness of all (N,); `words` (N, C) with what probability each is called each word."""
    strangeness = np.asarray(1 - words.max(axis=1, initial=0.0), np.float32)
    return np.argsort(-objectness * strangeness, kind="stable")[:most], strangeness


@dataclass(frozen=True)
class Sought:
    """The class that is looked for twice: its index in the detector's vocabulary, how far each of
    the classifier's classes stands for it, and how many places of a frame are looked at again."""

    label: int
    likeness: Floats
    places: int


def look_twice(
    detector: OpenDetector, second: SecondLook, sought: Sought, rgb: NDArray[np.uint8],
    view: DetectorView,
) -> RawDetections:  # fmt: skip
    """(H, W, 3) uint8 RGB and the detector's view of it -> what the classifier finds of what is
    sought."""
    at = places(view)
    others = np.delete(detector.words(view)[at], sought.label, axis=1)
    best, strangeness = strangest(view.objectness[at], others, sought.places)
    at, strangeness = at[best], strangeness[best]
    classes = second.classify(rgb, view.boxes_px[at])
    told = second.evidence(classes, sought.likeness, view.objectness[at], strangeness)
    labels = np.full(len(at), sought.label, np.int32)
    return boxes_only(view.boxes_px[at], second.probability(told), labels)
