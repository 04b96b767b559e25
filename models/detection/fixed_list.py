"""Detectors with a fixed class list, whose names are matched to the vocabulary: those of lists that
are known, or that come with a map, by a map (models/words/class_maps.py), others by meaning."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from models.detection import layouts
from models.detection.boxes import Letterbox, Stretch, letterbox, scaled, stretch
from models.detection.calibration import read_constants, settled, sigmoid, softmax
from models.detection.detections import (
    SAME_CLASS_IOU,
    Floats,
    RawDetections,
    boxes_only,
    checked,
    likeliest,
)
from models.detection.told import NORMALISE, file_classes, no_names, read_told, scaling
from models.errors import ModelFileError
from models.onnx_session import image_size, run
from models.words.class_maps import coco_91, map_of, stands_for
from models.words.class_names import ClassText, check_names
from models.words.text_encoder import TextEncoder

NAME_MATCH = 0.6
"""Cosine from which a fixed class name counts as one of a vocabulary class's names."""
NO_CLASS = frozenset({"", "n/a", "background", "__background__", "no object"})
"""Names of what a network counts but nothing is."""
MAY_BE_LOGITS: tuple[layouts.Layout, ...] = ("v8", "detr", "nanodet")
FINAL: tuple[layouts.Layout, ...] = ("end-to-end", "detr")
"""Layouts in which the network itself has chosen among overlapping boxes."""
ONE_PLACE = 0.99
"""IoU from which two of its boxes are one, that two of its names stand for."""


class FixedListDetector:
    """A detector of one of the layouts in layouts.py. Where its file has a calibration, by the keys
    of an RF-NAV detector's, `gain` and `shift` make its scores the share of such detections that
    are right."""

    def __init__(
        self,
        session: onnxruntime.InferenceSession,
        path: Path,
        encoder: TextEncoder,
        classes_file: Path | None,
    ) -> None:
        self._session, self._encoder, self._path = session, encoder, path
        metadata = session.get_modelmeta().custom_metadata_map
        constants = read_constants(metadata, path)
        self.gain, self.shift = constants["gain"], constants["shift"]
        self._input = session.get_inputs()[0]
        self._size = image_size(self._input.shape, path)
        told = read_told(path.parent, metadata)
        given = file_classes(classes_file, told, metadata, path)
        self._scaling = NORMALISE["none"]
        grey = np.full((*self._size, 3), 114, np.uint8)
        outputs = self._run(grey)
        names = _numbered(given.names, outputs)
        self._layout, count = layouts.choose(
            outputs, self._size, len(names), told.layout, str(path)
        )
        _check_count(names, count, given.where, path)
        self._scaling = scaling(told.normalise or _usual(self._layout, outputs), path)
        self._count, self._logits = len(names), False
        self._kept = [k for k, name in enumerate(names) if name.lower() not in NO_CLASS]
        self._names = tuple(names[k] for k in self._kept)
        self._map = given.own or map_of(self._names)
        self._matched = np.full(len(self._names), -1, np.int32)
        boxes, scores = self._answer(grey)
        self._logits = self._layout in MAY_BE_LOGITS and layouts.are_logits(scores)
        if self._layout == "detr" and np.nanmax(np.abs(boxes), initial=0) > sum(self._size):
            raise ModelFileError(
                f"{path}: its boxes lie outside of 0..1, which is not layout detr; export it so "
                "that they are cx, cy, w, h in 0..1"
            )
        yolo = "yolo " if self._layout in ("v5", "v8", "X") else ""
        self.capabilities: dict[str, Any] = {
            "contract": yolo + self._layout,
            "open_vocabulary": False,
            "rooms": False,
            "embeddings": False,
            "classes": list(self._names),
            "class_map": self._map.title if self._map else None,
        }

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Match each fixed class with a class of the vocabulary, or with none: as a map says, or
        with the class whose name is nearest."""
        if self._map is not None:
            check_names([name for names in classes for name in names], "vocabulary")
            likeness = stands_for(self._names, classes, self._map)
        else:
            text = ClassText(classes, self._encoder)
            likeness = text.similarity(self._encoder.embed(self._names))
        best = likeness.argmax(axis=1)
        nearness = likeness[np.arange(len(best)), best]
        self._matched = np.where(nearness >= NAME_MATCH, best, -1).astype(np.int32)
        found: dict[str, dict[str, float]] = {}
        for k in np.flatnonzero(self._matched >= 0):
            name = classes[self._matched[k]][0]
            found.setdefault(name, {})[self._names[k]] = round(float(nearness[k]), 2)
        self.capabilities["matched"] = found
        self.capabilities["unseen"] = [c[0] for c in classes if c[0] not in found]

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections of the matched classes."""
        image, fit = self._fitted(checked(rgb))
        decoded = self._answer(image)
        best = likeliest(decoded.scores)
        labels = self._matched[best].reshape(-1)
        place = np.repeat(np.arange(len(best)), best.shape[1])
        scores = np.where(labels >= 0, np.take_along_axis(decoded.scores, best, 1).reshape(-1), 0.0)
        boxes = fit.undo(decoded.boxes, *rgb.shape[:2])[place]
        within = ONE_PLACE if self._layout in FINAL else SAME_CLASS_IOU
        found = boxes_only(boxes, scores, labels, across=1.0, within=within)
        # After selection, so that what is found, and in which order, is what it was.
        return found._replace(scores=settled(found.scores, self.gain, self.shift))

    def _fitted(self, rgb: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], Letterbox | Stretch]:
        if self._layout == "detr":
            return stretch(rgb, *self._size)
        return letterbox(rgb, *self._size, centred=self._layout != "X")

    def _answer(self, image: NDArray[np.uint8]) -> layouts.Decoded:
        """Boxes in network px, and the scores of the classes that are named."""
        boxes, scores = layouts.decode(self._run(image), self._layout, *self._size, self._count)
        if scores.shape[1] > self._count:
            scores = softmax(scores)[:, :-1]
        elif self._logits:
            scores = sigmoid(scores)
        return layouts.Decoded(boxes, scores[:, self._kept])

    def _run(self, image: NDArray[np.uint8]) -> layouts.Outputs:
        feeds = {self._input.name: scaled(image, self._scaling)[None]}
        names = [output.name for output in self._session.get_outputs()]
        return dict(zip(names, run(self._session, feeds, self._path), strict=True))


def _numbered(names: tuple[str, ...], outputs: layouts.Outputs) -> tuple[str, ...]:
    """COCO's by its 91 numbers where a network of DETR's kind counts so, else the names."""
    known = map_of(names)
    if len(outputs) == 2 and (not names or (known is not None and known.title == "COCO's")):
        columns = {out.shape[-1] for out in outputs.values()}
        if columns in ({4, 91}, {4, 92}):
            return coco_91()
    return names


def _usual(layout: layouts.Layout, outputs: Mapping[str, Floats]) -> str:
    """What a layout's networks usually take. Of DETR's kind those take ImageNet's mean and
    deviation that count COCO's classes by its 91 numbers."""
    if layout == "X":
        return "yolox"
    if layout == "nanodet":
        return "nanodet"
    numbered = any(out.shape[-1] in (91, 92) for out in outputs.values())
    return "imagenet" if layout == "detr" and (numbered or "dets" in outputs) else "none"


def _check_count(names: tuple[str, ...], count: int, where: str, path: Path) -> None:
    if not names:
        raise no_names(path, count)
    if not count:
        raise ModelFileError(f"{where}: {len(names)} names do not fit the outputs of {path}")
    if len(names) != count:
        raise ModelFileError(f"{where}: {len(names)} names for {count} classes; they must be equal")
