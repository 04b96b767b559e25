"""Detectors by contract; ours, whose classes are text chosen at run time."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from models.checksum import sha256
from models.detection.boxes import letterbox
from models.detection.calibration import calibrated, read_constants, sigmoid, softmax
from models.detection.clip import ClipDetector
from models.detection.detections import NO_FEATURES, Floats, checked, likeliest, select
from models.detection.detections import Detector as Detector
from models.detection.detections import RawDetections as RawDetections
from models.detection.fixed_list import FixedListDetector
from models.detection.grounding import GroundingDetector
from models.detection.prompted import PromptedDetector, open_prompts
from models.detection.told import CLASSES_FILE, MAP_FILE
from models.errors import ModelFileError
from models.onnx_session import image_size, open_session, run
from models.words.class_names import ClassText, room_rows
from models.words.text_encoder import TextEncoder

FORMAT = "rf-nav-detector/1"
PHOTOGRAPHS = "photographs"
"""Key of the metadata: JSON, how the scene vector tells photographs from renderings."""
MODEL_FILE = "model.onnx"
TEXTS_FILE, TOWER_FILE, TOKENIZER_FILE = "texts.npz", "text.onnx", "tokenizer.json"
"""An imported detector's files."""
OUTPUTS = ("boxes", "objectness", "embeddings", "scene")
FEATURES = "features"
"""An output more, of files that models.train.features has made."""
NO_VOCABULARY = "the detector has no vocabulary; set one before the first frame"

Kind = Literal["auto", "rfnav", "prompted", "yolo", "clip", "grounding"]

CONTRACTS = f"""known contracts:
  rfnav     input image (1, 3, H, W), metadata format = {FORMAT}
  prompted  inputs images (1, 3, H, W) and texts (N, D) or (1, N, D)
  yolo      input images (1, 3, H, W), a fixed list; outputs of YOLO, DETR or NanoDet
  clip      input images (N, 3, H, W), output (N, D)
  grounding inputs images (1, 3, H, W), input_ids and attention_mask (1, T)"""


def open_detector(
    path: Path,
    kind: Kind,
    encoder: TextEncoder,
    threads: int = 1,
    classes_file: Path | None = None,
    texts: Path | None = None,
) -> Detector:
    """Open an ONNX detector. Raises ModelFileError when it, or what belongs to it, is of no use.

    `path` is the file, or a directory as `rfnav models import` makes it: `model.onnx` with its
    `classes.txt` or `classes.toml`, `contract.toml` (told.py), `texts.npz`, text tower or
    `tokenizer.json`. `texts`: the embeddings or the tower of a "prompted" or "clip" one, the
    tokenizer of a "grounding" one; that may lie beside the file.
    """
    path = Path(path)
    if path.is_dir():
        lists = [_companion(path, name) for name in (CLASSES_FILE, MAP_FILE)]
        classes_file = classes_file or lists[0] or lists[1]
        texts = texts or _companion(path, TEXTS_FILE) or _companion(path, TOWER_FILE)
        path = path / MODEL_FILE
    session = open_session(path, threads)
    contract = contract_of(session, path) if kind == "auto" else kind
    if contract == "rfnav":
        return OpenDetector(session, path, encoder)
    if contract in ("prompted", "clip"):
        if texts is None:
            raise ModelFileError(
                f"{path}: it takes embedded texts; give them, or its text tower with "
                "tokenizer.json beside it, to `rfnav models import` or `add` with --texts"
            )
        made = PromptedDetector if contract == "prompted" else ClipDetector
        return made(session, path, open_prompts(texts))
    if contract == "grounding":
        return GroundingDetector(session, path, texts or path.parent / TOKENIZER_FILE)
    if contract == "yolo":
        return FixedListDetector(session, path, encoder, classes_file)
    raise ModelFileError(
        f"{path}: detector kind {kind!r} is unknown; known are {', '.join(get_args(Kind))}"
    )


def contract_of(session: onnxruntime.InferenceSession, path: Path) -> Kind:
    """Which contract a graph's metadata and inputs say it keeps; ModelFileError for none."""
    if "format" in session.get_modelmeta().custom_metadata_map:
        return "rfnav"
    inputs = session.get_inputs()
    ranks = sorted(len(i.shape) for i in inputs)
    floats = all(i.type == "tensor(float)" for i in inputs)
    if floats and ranks in ([4], [2, 4]) and any(len(o.shape) == 2 for o in session.get_outputs()):
        return "clip"
    if {"input_ids", "attention_mask"} < {i.name for i in inputs} and ranks == [2, 2, 4]:
        return "grounding"
    if floats and ranks in ([2, 4], [3, 4]):
        return "prompted"
    if floats and ranks == [4]:
        return "yolo"
    have = ", ".join(f"{i.name} {i.shape} {i.type}" for i in inputs)
    raise ModelFileError(f"{path}: no detector of a known contract (inputs {have}); {CONTRACTS}")


def _companion(directory: Path, name: str) -> Path | None:
    return directory / name if (directory / name).is_file() else None


class DetectorView(NamedTuple):
    """What the network makes of a frame, before any word: K candidates.

    `boxes_px` (K, 4) image px; `objectness` (K,) in 0..1; `regions` (K, D) and `scene` (D,) unit
    rows in the text encoder's space; `features` (C, h, w) what the backbone has of each part of
    the image, bars of the letterbox and all, or (0, 0, 0) for a file that does not tell.
    """

    boxes_px: Floats
    objectness: Floats
    regions: Floats
    scene: Floats
    features: Floats = NO_FEATURES


class OpenDetector:
    """Our network: boxes, objectness and region embeddings; words are compared here, outside it.

    score = sigmoid(gain * logit(objectness * sigmoid(scale * cosine + bias)) + shift), where gain
    and shift were fitted so that a score is the share of such detections that are right.
    """

    def __init__(
        self, session: onnxruntime.InferenceSession, path: Path, encoder: TextEncoder
    ) -> None:
        self._session, self._encoder, self._path = session, encoder, path
        self.sha256 = sha256(path)  # of what was loaded: the file may be another one later
        constants = _constants(session, path)
        try:
            self._scale, self._bias = constants["scale"], constants["bias"]
            self._room_scale = constants["room_scale"]
        except KeyError as error:
            raise ModelFileError(f"{path}: its metadata lacks value.{error.args[0]}") from error
        self.gain, self.shift = constants["gain"], constants["shift"]
        _count_outputs(session, path)
        self._photographs = _direction(session, path)
        self._input = session.get_inputs()[0]
        self.size = image_size(self._input.shape, path)
        self.tells_features = len(session.get_outputs()) > len(OUTPUTS)
        self._text: ClassText | None = None
        self._rooms: Floats = np.zeros((0, encoder.dimension), np.float32)
        self.capabilities: dict[str, Any] = {
            "contract": "rfnav",
            "open_vocabulary": True,
            "rooms": True,
            "embeddings": True,
            "classes": None,
        }

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Embed the names; the next frames are compared with them."""
        self._text = ClassText(classes, self._encoder)
        self._rooms = room_rows(rooms, self._encoder)
        # Any text can be compared with a region: none is seen by way of another's name.
        self.capabilities |= {"matched": {}, "unseen": []}

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections. A place is given its best classes, NAMES of them."""
        if self._text is None:
            raise ModelFileError(NO_VOCABULARY)
        return self.name(self.look(rgb))

    def look(self, rgb: NDArray[np.uint8]) -> DetectorView:
        """(H, W, 3) uint8 RGB -> what is there, not yet named."""
        image, fit = letterbox(checked(rgb), *self.size)
        feed = np.ascontiguousarray(image.transpose(2, 0, 1)[None], np.float32)
        outputs = run(self._session, {self._input.name: feed}, self._path)
        boxes, objectness, regions, *of_image = (out[0] for out in outputs)
        return DetectorView(fit.undo(boxes, *rgb.shape[:2]), objectness, regions, *of_image)

    def name(self, view: DetectorView) -> RawDetections:
        """Compare a view with the vocabulary."""
        if self._text is None:
            raise ModelFileError(NO_VOCABULARY)
        return self.named(view, self._text.similarity(view.regions))

    def named(self, view: DetectorView, cosines: Floats) -> RawDetections:
        """Detections, given the (K, C) cosines of a view's regions with each class."""
        called = likeliest(cosines)
        labels = called.reshape(-1).astype(np.int32)
        place = np.repeat(np.arange(len(cosines)), called.shape[1])
        scores = self.score(view.objectness[place], cosines[place, labels]).astype(np.float32)
        kept = select(view.boxes_px[place], scores, labels, across=1.0)
        boxes, regions = view.boxes_px[place[kept]], view.regions[place[kept]]
        return RawDetections(
            boxes, scores[kept], labels[kept], regions, self.room(view), view.scene, view.features
        )

    def room(self, view: DetectorView) -> Floats:
        """(R,) probabilities of the room types."""
        return softmax(self._rooms @ view.scene * self._room_scale)

    def photograph_odds(self, scene: Floats) -> float | None:
        """Log odds that an image with this (D,) scene vector is a photograph and no rendering; None
        where the file does not say how that is told."""
        if self._photographs is None:
            return None
        return float(self._photographs[:-1] @ scene + self._photographs[-1])

    def score(self, objectness: Floats, cosines: Floats) -> NDArray[np.float64]:
        """(...) objectness in 0..1 and (...) cosines with a word -> (...) calibrated scores."""
        return calibrated(objectness * self._word(cosines), self.gain, self.shift)

    def words(self, view: DetectorView) -> Floats:
        """(K, C) with what probability each place is called each class, if it is anything."""
        if self._text is None:
            raise ModelFileError(NO_VOCABULARY)
        return self._word(self._text.similarity(view.regions)).astype(np.float32)

    def _word(self, cosines: Floats) -> NDArray[np.float64]:
        """With what probability what is there is called so."""
        return sigmoid(cosines.astype(np.float64) * self._scale + self._bias)


def _count_outputs(session: onnxruntime.InferenceSession, path: Path) -> None:
    """ModelFileError where there are not as many as ours have: they go by their order."""
    count = len(session.get_outputs())
    if count not in (len(OUTPUTS), len(OUTPUTS) + 1):
        raise ModelFileError(
            f"{path}: {count} outputs; expected {', '.join(OUTPUTS)}, and perhaps {FEATURES}"
        )


def _direction(session: onnxruntime.InferenceSession, path: Path) -> Floats | None:
    """(D + 1,) weights of the scene vector, and a constant, that tell photographs; None without."""
    written = session.get_modelmeta().custom_metadata_map.get(PHOTOGRAPHS)
    if written is None:
        return None
    try:
        row = np.array(json.loads(written), np.float32)
    except (ValueError, TypeError):
        row = np.zeros(0, np.float32)
    width = session.get_outputs()[OUTPUTS.index("scene")].shape[-1]
    if row.shape != (width + 1,) or not np.isfinite(row).all():
        raise ModelFileError(
            f"{path}: {PHOTOGRAPHS} in its metadata is no list of {width + 1} numbers; make it "
            "anew with models.train.fuse"
        )
    return row


def _constants(session: onnxruntime.InferenceSession, path: Path) -> dict[str, float]:
    metadata = session.get_modelmeta().custom_metadata_map
    if metadata.get("format") != FORMAT:
        raise ModelFileError(
            f"{path}: not an RF-NAV detector (format {metadata.get('format', 'missing')!r}, "
            f"expected {FORMAT!r}); {CONTRACTS}"
        )
    return read_constants(metadata, path)
