"""Detectors: ours, whose classes are text chosen at run time, and YOLO files with a fixed list."""

import ast
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from models import layouts
from models.boxes import letterbox, suppress
from models.errors import ModelError
from models.session import open_session
from models.text import TextEncoder
from models.words import ClassText, check_names, read_names, room_rows

MIN_SCORE = 0.02
SAME_CLASS_IOU, OTHER_CLASS_IOU = 0.55, 0.8
MAX_DETECTIONS = 100
FORMAT = "rf-nav-detector/1"
NAME_MATCH = 0.6
"""Cosine from which a fixed class name counts as one of a vocabulary class's names."""

Floats = NDArray[np.float32]


class RawDetections(NamedTuple):
    """One frame's detections, best first, and what room it shows.

    `boxes_px` (N, 4) x0, y0, x1, y1 in image px; `scores` (N,) in 0..1; `labels` (N,) index into
    the classes; `embeddings` (N, D) unit rows in the text encoder's space, or (N, 0); `rooms`
    (R,) probabilities in the order given, or (0,); `scene` (D,) the whole image's unit row, or
    (0,).
    """

    boxes_px: Floats
    scores: Floats
    labels: NDArray[np.int32]
    embeddings: Floats
    rooms: Floats
    scene: Floats


class Detector(Protocol):
    """What the runtime asks of a detector. One thread at a time may use it."""

    capabilities: dict[str, Any]

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Choose the classes (each its names, canonical first) and the room types."""

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections."""


def open_detector(
    path: Path,
    kind: Literal["rfnav", "yolo"],
    encoder: TextEncoder,
    threads: int = 1,
    classes_file: Path | None = None,
) -> Detector:
    """Open an ONNX detector. Raises ModelError when the file or its class list cannot be used."""
    session = open_session(Path(path), threads)
    if kind == "rfnav":
        return OpenDetector(session, Path(path), encoder)
    if kind == "yolo":
        return YoloDetector(session, Path(path), encoder, classes_file)
    raise ModelError(f"{path}: detector kind {kind!r} is unknown; known are rfnav, yolo")


class OpenDetector:
    """Our network: boxes, objectness and region embeddings; words are compared here, outside it.

    score = sigmoid(gain * logit(objectness * sigmoid(scale * cosine + bias)) + shift), where gain
    and shift were fitted so that a score is the share of such detections that are right.
    """

    def __init__(
        self, session: onnxruntime.InferenceSession, path: Path, encoder: TextEncoder
    ) -> None:
        self._session, self._encoder = session, encoder
        constants = _constants(session, path)
        self._scale, self._bias = constants["scale"], constants["bias"]
        self._room_scale = constants["room_scale"]
        self._gain, self._shift = constants.get("gain", 1.0), constants.get("shift", 0.0)
        self._input = session.get_inputs()[0]
        self._size = (int(self._input.shape[2]), int(self._input.shape[3]))
        self._text: ClassText | None = None
        self._rooms: Floats = np.zeros((0, encoder.dimension), np.float32)
        self.capabilities: dict[str, Any] = {
            "open_vocabulary": True,
            "rooms": True,
            "classes": None,
        }

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Embed the names; the next frames are compared with them."""
        self._text = ClassText(classes, self._encoder)
        self._rooms = room_rows(rooms, self._encoder)

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections. Each location is given its one best class."""
        if self._text is None:
            raise ModelError("the detector has no vocabulary; set one before the first frame")
        image, fit = letterbox(_checked(rgb), *self._size)
        feed = np.ascontiguousarray(image.transpose(2, 0, 1)[None], np.float32)
        boxes, objectness, regions, scene = self._session.run(None, {self._input.name: feed})
        logits = self._text.similarity(regions[0]) * self._scale + self._bias
        labels = logits.argmax(axis=1).astype(np.int32)
        scores = self.calibrated(objectness[0], logits[np.arange(len(labels)), labels])
        placed = fit.undo(boxes[0], rgb.shape[0], rgb.shape[1])
        kept = _select(placed, scores, labels)
        rooms = _softmax(self._rooms @ scene[0] * self._room_scale)
        return RawDetections(
            placed[kept], scores[kept], labels[kept], regions[0][kept], rooms, scene[0]
        )

    def calibrated(self, objectness: Floats, logits: Floats) -> Floats:
        """(N,) objectness in 0..1 and (N,) word logits -> (N,) scores."""
        p = np.clip(objectness / (1 + np.exp(-logits)), 1e-6, 1 - 1e-6)
        odds = self._gain * np.log(p / (1 - p)) + self._shift
        return np.asarray(1 / (1 + np.exp(-odds)), np.float32)


class YoloDetector:
    """A YOLO export with a fixed class list; its names are matched to the vocabulary by meaning."""

    def __init__(
        self,
        session: onnxruntime.InferenceSession,
        path: Path,
        encoder: TextEncoder,
        classes_file: Path | None,
    ) -> None:
        self._session, self._encoder = session, encoder
        self._input = session.get_inputs()[0]
        self._size = _input_size(self._input.shape, path)
        output = self._run(np.full((*self._size, 3), 114, np.uint8), "v8", path)
        self._layout, count = layouts.recognise(output.shape, *self._size, str(path))
        self._names = _class_names(session, classes_file, count, path)
        self._matched = np.full(count, -1, np.int32)
        self.capabilities: dict[str, Any] = {
            "open_vocabulary": False,
            "rooms": False,
            "classes": list(self._names),
        }

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Match each fixed class with the vocabulary class whose name is nearest, or with none."""
        text = ClassText(classes, self._encoder)
        cosine = text.similarity(self._encoder.embed(self._names))
        best = cosine.argmax(axis=1)
        near = cosine[np.arange(len(best)), best] >= NAME_MATCH
        self._matched = np.where(near, best, -1).astype(np.int32)

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections of the matched classes."""
        image, fit = letterbox(_checked(rgb), *self._size, centred=self._layout != "X")
        decoded = layouts.decode(self._run(image, self._layout, None), self._layout, *self._size)
        best = decoded.scores.argmax(axis=1)
        labels = self._matched[best]
        scores = np.where(labels >= 0, decoded.scores[np.arange(len(best)), best], 0.0)
        scores = np.nan_to_num(scores).astype(np.float32)
        placed = fit.undo(np.nan_to_num(decoded.boxes), rgb.shape[0], rgb.shape[1])
        kept = _select(placed, scores, labels)
        none, nothing = np.zeros((len(kept), 0), np.float32), np.zeros(0, np.float32)
        return RawDetections(placed[kept], scores[kept], labels[kept], none, nothing, nothing)

    def _run(self, image: NDArray[np.uint8], layout: layouts.Layout, path: Path | None) -> Floats:
        planes = image.transpose(2, 0, 1)[None].astype(np.float32)
        # YOLOX takes BGR in 0..255, the others RGB in 0..1
        feed = np.ascontiguousarray(planes[:, ::-1] if layout == "X" else planes / 255, np.float32)
        try:
            return np.asarray(self._session.run(None, {self._input.name: feed})[0], np.float32)
        except Exception as error:  # onnxruntime's exceptions share no base but Exception
            reason = " ".join(str(error).split())[:120]
            raise ModelError(f"{path}: does not run on a {image.shape} image ({reason})") from error


def _checked(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8 or not rgb.size:
        raise ModelError(f"a frame is (H, W, 3) uint8 RGB, not {rgb.shape} {rgb.dtype}")
    return rgb


def _select(boxes: Floats, scores: Floats, labels: NDArray[np.int32]) -> NDArray[np.int64]:
    """Indices of what is reported: scored, of some area, not covered by a better box."""
    area = (boxes[:, 2:] - boxes[:, :2]).clip(0).prod(axis=1)
    candidates = np.flatnonzero((scores >= MIN_SCORE) & (area > 0) & (labels >= 0))
    candidates = candidates[np.argsort(-scores[candidates], kind="stable")][: 4 * MAX_DETECTIONS]
    kept = suppress(
        boxes[candidates], scores[candidates], labels[candidates], SAME_CLASS_IOU, OTHER_CLASS_IOU
    )
    return candidates[kept][:MAX_DETECTIONS]


def _softmax(logits: Floats) -> Floats:
    if not len(logits):
        return np.zeros(0, np.float32)
    weights = np.exp(logits - logits.max())
    return np.asarray(weights / weights.sum(), np.float32)


def _constants(session: onnxruntime.InferenceSession, path: Path) -> dict[str, float]:
    metadata = session.get_modelmeta().custom_metadata_map
    if metadata.get("format") != FORMAT:
        raise ModelError(
            f"{path}: not an RF-NAV detector (format {metadata.get('format', 'missing')!r}, "
            f'expected {FORMAT!r}); for a YOLO file set models.detector_kind = "yolo"'
        )
    return {k[6:]: float(v) for k, v in metadata.items() if k.startswith("value.")}


def _input_size(shape: Sequence[Any], path: Path) -> tuple[int, int]:
    if len(shape) != 4 or shape[1] != 3:
        raise ModelError(f"{path}: input {list(shape)} is not an image; expected (1, 3, H, W)")
    height, width = (int(s) if isinstance(s, int) and s > 0 else 640 for s in shape[2:])
    return height, width


def _class_names(
    session: onnxruntime.InferenceSession, file: Path | None, count: int, path: Path
) -> tuple[str, ...]:
    if file is not None:
        names, where = read_names(Path(file)), str(file)
    else:
        written = session.get_modelmeta().custom_metadata_map.get("names", "")
        names, where = _parse_names(written), str(path)
        if not names:
            raise ModelError(
                f"{path}: its {count} classes have no names; set models.detector_classes to a text "
                "file with one name a line"
            )
        check_names(names, where)
    if len(names) != count:
        raise ModelError(f"{where}: {len(names)} names for {count} classes; they must be equal")
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
