"""YOLO exports with a fixed class list, whose names are matched to the vocabulary: COCO's by the
map in models/words/coco.toml, others by meaning."""

import ast
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from models.detection import layouts
from models.detection.boxes import letterbox
from models.detection.calibration import calibrated, read_constants
from models.detection.detections import Floats, RawDetections, boxes_only, checked, likeliest
from models.errors import ModelFileError
from models.onnx_session import image_size, run
from models.words.class_names import ClassText, check_names, read_names
from models.words.coco import coco_map, is_coco, stands_for
from models.words.text_encoder import TextEncoder

NAME_MATCH = 0.6
"""Cosine from which a fixed class name counts as one of a vocabulary class's names."""


class YoloDetector:
    """A YOLO export with a fixed class list. Where its file has a calibration, by the keys of an
    RF-NAV detector's, `gain` and `shift` make its scores the share of such detections that are
    right."""

    def __init__(
        self,
        session: onnxruntime.InferenceSession,
        path: Path,
        encoder: TextEncoder,
        classes_file: Path | None,
    ) -> None:
        self._session, self._encoder, self._path = session, encoder, path
        constants = read_constants(session.get_modelmeta().custom_metadata_map, path)
        self.gain, self.shift = constants["gain"], constants["shift"]
        self._input = session.get_inputs()[0]
        self._size = image_size(self._input.shape, path)
        output = self._run(np.full((*self._size, 3), 114, np.uint8), "v8")
        self._layout, count = layouts.recognise(output.shape, *self._size, str(path))
        self._names = _class_names(session, classes_file, count, path)
        self._matched = np.full(count, -1, np.int32)
        self.capabilities: dict[str, Any] = {
            "contract": f"yolo {self._layout}",
            "open_vocabulary": False,
            "rooms": False,
            "embeddings": False,
            "classes": list(self._names),
        }

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Match each fixed class with a class of the vocabulary, or with none: COCO's as the map
        says, others with the class whose name is nearest."""
        if is_coco(self._names):
            check_names([name for names in classes for name in names], "vocabulary")
            likeness = stands_for(self._names, classes, coco_map())
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
        image, fit = letterbox(checked(rgb), *self._size, centred=self._layout != "X")
        decoded = layouts.decode(self._run(image, self._layout), self._layout, *self._size)
        best = likeliest(decoded.scores)
        labels, place = (
            self._matched[best].reshape(-1),
            np.repeat(np.arange(len(best)), best.shape[1]),
        )
        scores = np.where(labels >= 0, np.take_along_axis(decoded.scores, best, 1).reshape(-1), 0.0)
        boxes = fit.undo(decoded.boxes, *rgb.shape[:2])[place]
        found = boxes_only(boxes, scores, labels, across=1.0)
        # After selection, so that what is found, and in which order, is what it was.
        return found._replace(scores=self._settled(found.scores))

    def _settled(self, scores: Floats) -> Floats:
        """Calibrated where the file says how."""
        if (self.gain, self.shift) == (1.0, 0.0):
            return scores
        return calibrated(scores.astype(np.float64), self.gain, self.shift).astype(np.float32)

    def _run(self, image: NDArray[np.uint8], layout: layouts.Layout) -> Floats:
        planes = image.transpose(2, 0, 1)[None].astype(np.float32)
        # YOLOX takes BGR in 0..255, the others RGB in 0..1
        feed = np.ascontiguousarray(planes[:, ::-1] if layout == "X" else planes / 255, np.float32)
        return run(self._session, {self._input.name: feed}, self._path)[0]


def _class_names(
    session: onnxruntime.InferenceSession, file: Path | None, count: int, path: Path
) -> tuple[str, ...]:
    if file is not None:
        names, where = read_names(Path(file)), str(file)
    else:
        written = session.get_modelmeta().custom_metadata_map.get("names", "")
        names, where = _parse_names(written), str(path)
        if not names:
            raise ModelFileError(
                f"{path}: its {count} classes have no names; give a text file with one name a line "
                "(models.detector_classes, or --classes of `rfnav models import`)"
            )
        check_names(names, where)
    if len(names) != count:
        raise ModelFileError(f"{where}: {len(names)} names for {count} classes; they must be equal")
    return names


def _parse_names(written: str) -> tuple[str, ...]:
    """Ultralytics writes a Python dict or list literal into the file's metadata."""
    try:
        value = ast.literal_eval(written)
    except (ValueError, SyntaxError):
        return ()
    if isinstance(value, dict):
        value = [value[key] for key in sorted(value)]
    return tuple(str(v) for v in value) if isinstance(value, list | tuple) else ()
