"""Detectors that are told what to look for by embedded texts, as YOLO-World works.

Contract "prompted":

| | | |
|---|---|---|
| input | `images` (1, 3, H, W) float32 | RGB in 0..1, letterboxed in the middle with grey 114 |
| input | `texts` (N, D) or (1, N, D) float32 | a row a prompt; where N is fixed, the rest is 0 |
| output | `boxes` (1, L, 4), `scores` (1, L, N) | corners in network px; 0..1; before suppression |
| or | one output (1, 4 + N, L) | cx, cy, w, h in network px, then scores, as YOLOv8 gives it |

Scores that lie outside of 0..1 are logits. Where the file has a calibration, by the keys of an
RF-NAV detector's, `gain` and `shift` make its scores the share of such detections that are right.

Texts are embedded by the network's own tower: an ONNX file (`input_ids` (1, T) int64, with or
without `attention_mask` -> (1, D)) with its `tokenizer.json` beside it, or a file of rows computed
beforehand (.npz, one array (D,) a name).
"""

import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from models.detection import layouts
from models.detection.boxes import letterbox, scaled
from models.detection.calibration import read_constants, settled, sigmoid
from models.detection.detections import NOTHING, Floats, RawDetections, boxes_only, checked
from models.detection.told import NORMALISE
from models.errors import ModelFileError
from models.onnx_session import image_size, open_session, run
from models.words.class_names import check_names
from models.words.text_encoder import open_tokenizer

TRIAL_PROMPTS = 3
TOWER_TOKENS = 77
"""Tokens of a tower that leaves their number open: as many as CLIP's."""


class Prompts(Protocol):
    """Names to rows in the network's own text space."""

    dimension: int

    def row(self, name: str) -> Floats | None:
        """(D,) unit row, or None for a name that cannot be embedded."""


class StoredPrompts:
    """Rows computed beforehand: an .npz with one array (D,) a name."""

    def __init__(self, path: Path) -> None:
        try:
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                rows = {name: np.asarray(file[name], np.float32) for name in file.files}
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            raise ModelFileError(f"{path}: not a readable .npz of text rows ({error})") from error
        check_names(tuple(rows), str(path))
        widths = {row.shape for row in rows.values()}
        if len(widths) != 1 or len(next(iter(widths))) != 1:
            raise ModelFileError(
                f"{path}: every array must be one row (D,), not {sorted(widths)[:3]}"
            )
        self._rows = {name: _unit(row) for name, row in rows.items()}
        self.dimension = int(next(iter(widths))[0])

    def row(self, name: str) -> Floats | None:
        return self._rows.get(name)


class TowerPrompts:
    """A text tower in ONNX, with `tokenizer.json` beside it."""

    def __init__(self, path: Path) -> None:
        self._path, self._session = path, open_session(path)
        self._tokenizer = open_tokenizer(path.parent / "tokenizer.json", "put the tower's there")
        shapes = {i.name: i.shape for i in self._session.get_inputs()}
        if not set(shapes) <= {"input_ids", "attention_mask"} or "input_ids" not in shapes:
            raise ModelFileError(
                f"{path}: inputs {sorted(shapes)} are no text tower's; expected input_ids and "
                "maybe attention_mask"
            )
        length = shapes["input_ids"][-1]
        self._fixed = length if isinstance(length, int) else None
        self._inputs = set(shapes)
        self._tokenizer.enable_truncation(self._fixed or TOWER_TOKENS)
        self._memo: dict[str, Floats] = {}
        self.dimension = len(self._embedded("a"))

    def row(self, name: str) -> Floats | None:
        if name not in self._memo:
            self._memo[name] = self._embedded(name)
        return self._memo[name]

    def _embedded(self, name: str) -> Floats:
        ids = self._tokenizer.encode(name).ids
        mask = [1] * len(ids)
        if self._fixed is not None:
            rest = [0] * (self._fixed - len(ids))
            ids, mask = ids + rest, mask + rest
        feeds = {"input_ids": np.array([ids]), "attention_mask": np.array([mask])}
        outputs = run(
            self._session, {k: v for k, v in feeds.items() if k in self._inputs}, self._path
        )
        rows = [out for out in outputs if out.ndim == 2 and len(out) == 1]
        if not rows:
            raise ModelFileError(
                f"{self._path}: gives no (1, D) row; export it with its projection"
            )
        return _unit(rows[0][0])


def open_prompts(path: Path) -> Prompts:
    """Text rows (.npz) or a text tower (.onnx)."""
    if not path.is_file():
        raise ModelFileError(f"{path}: no such file; expected rows (.npz) or a text tower (.onnx)")
    return StoredPrompts(path) if path.suffix == ".npz" else TowerPrompts(path)


class PromptedDetector:
    """The contract above. A class of several names has the score of its best one."""

    def __init__(self, session: onnxruntime.InferenceSession, path: Path, prompts: Prompts) -> None:
        self._session, self._path, self._prompts = session, path, prompts
        constants = read_constants(session.get_modelmeta().custom_metadata_map, path)
        self.gain, self.shift = constants["gain"], constants["shift"]
        inputs = session.get_inputs()
        self._image = next(i for i in inputs if len(i.shape) == 4)
        self._texts = next(i for i in inputs if len(i.shape) != 4)
        self._size = image_size(self._image.shape, path)
        slots, width = self._texts.shape[-2:]
        self._slots = slots if isinstance(slots, int) else None
        if isinstance(width, int) and width != prompts.dimension:
            raise ModelFileError(
                f"{path}: its texts have {width} values, the rows given {prompts.dimension}; they "
                "are of another text tower"
            )
        self._rows: Floats = np.zeros((0, prompts.dimension), np.float32)
        self._owner: NDArray[np.int32] = np.zeros(0, np.int32)
        self.capabilities: dict[str, Any] = {
            "contract": "prompted",
            "open_vocabulary": True,
            "rooms": False,
            "embeddings": False,
            "classes": None,
        }
        self._logits = False
        trial = np.eye(min(TRIAL_PROMPTS, self._slots or 3), prompts.dimension, dtype=np.float32)
        answer = self._answer(np.full((*self._size, 3), 114, np.uint8), trial)
        self._logits = layouts.are_logits(answer.scores)

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Embed the names; those that have no row are left out, and said in the capabilities."""
        check_names([name for names in classes for name in names], "vocabulary")
        found: list[tuple[int, str, Floats]] = []
        for k, names in enumerate(classes):
            for name in names:
                row = self._prompts.row(name)
                if row is not None:
                    found.append((k, name, row))
        if self._slots is not None and len(found) > self._slots:
            raise ModelFileError(f"{self._path}: takes {self._slots} texts, not {len(found)}")
        self._owner = np.array([k for k, _, _ in found], np.int32)
        width = self._prompts.dimension
        self._rows = np.array([row for _, _, row in found], np.float32).reshape(-1, width)
        matched: dict[str, list[str]] = {}
        for k, name, _ in found:
            matched.setdefault(classes[k][0], []).append(name)
        self.capabilities["matched"] = matched
        self.capabilities["unseen"] = [c[0] for c in classes if c[0] not in matched]

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections. Each location is given its one best class."""
        image, fit = letterbox(checked(rgb), *self._size)
        if not len(self._rows):
            return boxes_only(*NOTHING)
        decoded = self._answer(image, self._rows)
        best = np.nan_to_num(decoded.scores).argmax(axis=1)
        scores = decoded.scores[np.arange(len(best)), best]
        boxes = fit.undo(decoded.boxes, *rgb.shape[:2])
        found = boxes_only(boxes, scores, self._owner[best])
        return found._replace(scores=settled(found.scores, self.gain, self.shift))

    def _answer(self, image: NDArray[np.uint8], rows: Floats) -> layouts.Decoded:
        """Boxes in network px and one column of scores a row."""
        texts = rows
        if self._slots is not None:
            texts = np.concatenate((rows, np.zeros((self._slots - len(rows), rows.shape[1]))))
        batch = texts.reshape(texts.shape if len(self._texts.shape) == 2 else (1, *texts.shape))
        feeds: dict[str, Floats] = {str(self._image.name): scaled(image, NORMALISE["none"])[None]}
        feeds[str(self._texts.name)] = np.asarray(batch, np.float32)
        outputs = run(self._session, feeds, self._path)
        decoded = layouts.decode_prompted(outputs, len(texts), str(self._path))
        scores = decoded.scores[:, : len(rows)]
        return layouts.Decoded(decoded.boxes, sigmoid(scores) if self._logits else scores)


def _unit(row: Floats) -> Floats:
    norm = float(np.linalg.norm(row))
    if not np.isfinite(norm) or norm == 0:
        raise ModelFileError("a text's row is zero or not finite; compute it again")
    return np.asarray(row / norm, np.float32)
