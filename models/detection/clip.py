"""Image and text towers of CLIP's kind, put to find things in the three ways of the CoW baselines.

Contract "clip":

| | | |
|---|---|---|
| input | image (N, 3, H, W) float32 | RGB, CLIP's normalisation, stretched; N is free or 1 |
| input | texts (T, D) float32, where there is a relevance map | unit rows; T is free or 1 |
| output | (N, D) | the image's row in the text tower's space |
| output | (1, h, w) or (1, T, h, w), where it takes texts | relevance of the places for the text |

Its metadata may hold `value.scale`, what cosines are multiplied by, and `value.gain`, `value.shift`
of a calibration. Texts are embedded as for contract "prompted"; rows computed beforehand (.npz) go
by the whole sentence. (Gadre et al., CoWs on Pasture, CVPR 2023: CLIP-Patch, CLIP-Ref., CLIP-Grad.)
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import cv2
import numpy as np
import onnxruntime
from numpy.typing import NDArray

from models.detection.boxes import Scaling, scaled, stretch
from models.detection.calibration import read_constants, settled, softmax
from models.detection.detections import NOTHING, Floats, RawDetections, boxes_only, checked
from models.detection.prompted import Prompts
from models.errors import ModelFileError
from models.onnx_session import image_size, run
from models.words.class_names import check_names

Way = Literal["patch", "reference", "grad"]
SCALING = Scaling(
    False, (122.7709383, 116.7460125, 104.09373615), (68.5005327, 66.6321579, 70.32316305)
)
"""CLIP's mean and deviation."""
SIDE_PX = 224
"""Of an image whose size the file leaves open."""
SCALE = 100.0
"""What CLIP's cosines are multiplied by before the softmax, where the file does not say."""
SENTENCE = "a photo of a {}"
BACKGROUND = ("wall", "floor", "ceiling", "window", "empty room")
"""What most of a home's images show: competes with the words that are looked for."""
PLACED = tuple(
    f"a photo of a {{}} {where} of the image"
    for where in (
        "in the top left", "at the top", "in the top right",
        "on the left", "in the middle", "on the right",
        "in the bottom left", "at the bottom", "in the bottom right",
    )
)  # fmt: skip
"""Reference sentences, one for each ninth of the image, row by row."""
RELEVANT = 0.5
"""Of a relevance map's range, from which on a place belongs to a region."""
FEW = 8
"""Patches along the longer side of an image, at least half of one apart."""

Found = tuple[Floats, Floats, NDArray[np.int32]]


class TowerAnswer(NamedTuple):
    """What the tower makes of N pictures: `rows` (N, D) unit rows; `relevance` (h, w) of the first
    one's places, if it has that."""

    rows: Floats
    relevance: Floats | None


class ClipDetector:
    """The contract above. Patches are called what they look like most; by reference and by
    relevance only the goal is looked for, once there is one. A class of several names has the score
    of its best one."""

    def __init__(self, session: onnxruntime.InferenceSession, path: Path, prompts: Prompts) -> None:
        self._session, self._path, self._prompts = session, path, prompts
        constants = read_constants(session.get_modelmeta().custom_metadata_map, path)
        self._scale = np.float32(constants.get("scale", SCALE))
        if self._scale <= 0:
            raise ModelFileError(f"{path}: value.scale {self._scale} of no use; it must be above 0")
        self._gain, self._shift = constants["gain"], constants["shift"]
        self._image, self._texts = _inputs(session, path)
        self._size = image_size(self._image.shape, path, SIDE_PX)
        self._rows: Floats = np.zeros((0, prompts.dimension), np.float32)
        self._owner: NDArray[np.int64] = np.zeros(0, np.int64)
        self._names: tuple[str, ...] = ()
        self._way: Way = "patch"
        self._goal: int | None = None
        seen = self._look([np.full((*self._size, 3), 114, np.uint8)])
        self._relevance = seen.relevance is not None
        self.capabilities: dict[str, Any] = {
            "contract": "clip with relevance" if self._relevance else "clip",
            "open_vocabulary": True,
            "rooms": False,
            "embeddings": False,
            "classes": None,
        }

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Embed a sentence a name; classes without any are said in the capabilities. No class is
        the goal any more."""
        names = [name for called in classes for name in called]
        check_names(names, "vocabulary")
        others = [(name,) for name in BACKGROUND if name not in names]
        found = [
            (k, row)
            for k, called in enumerate((*classes, *others))
            for name in called
            if (row := self._prompts.row(SENTENCE.format(name))) is not None
        ]
        self._owner = np.array([k for k, _ in found], np.int64)
        width = self._prompts.dimension
        self._rows = np.array([row for _, row in found], np.float32).reshape(-1, width)
        self._names, self._goal = tuple(called[0] for called in classes), None
        unseen = [name for k, name in enumerate(self._names) if k not in self._owner]
        self.capabilities |= {"matched": {}, "unseen": unseen}

    def find_by(self, way: Way) -> None:
        """Choose the way; ModelFileError when the file lacks what it needs."""
        if way == "grad" and not self._relevance:
            raise ModelFileError(
                f"{self._path}: gives no relevance map (1, h, w) or (1, T, h, w) for a text; "
                "export it with that and texts (T, D) as input, or find by patch or reference"
            )
        self._way = way

    def look_for(self, goal: int) -> None:
        """From now on this class of the vocabulary is the goal."""
        self._goal = goal

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections."""
        checked(rgb)
        if self._way == "patch":
            boxes, scores, labels = self._by_patch(rgb)
        elif self._goal is None or self._names[self._goal] in self.capabilities["unseen"]:
            boxes, scores, labels = NOTHING
        elif self._way == "reference":
            boxes, scores, labels = self._by_reference(rgb, self._goal)
        else:
            boxes, scores, labels = self._by_relevance(rgb, self._goal)
        found = boxes_only(boxes, scores, labels)
        return found._replace(scores=settled(found.scores, self._gain, self._shift))

    def _by_patch(self, rgb: NDArray[np.uint8]) -> Found:
        """Each patch is what its picture looks like most."""
        if not len(self._names):
            return NOTHING
        boxes = patches(*rgb.shape[:2])
        seen = self._look([rgb[y0:y1, x0:x1] for x0, y0, x1, y1 in boxes.tolist()])
        chances = self._chances(seen.rows)
        best = chances.argmax(axis=1)
        scores = chances[np.arange(len(best)), best]
        return boxes.astype(np.float32), scores, best.astype(np.int32)

    def _by_reference(self, rgb: NDArray[np.uint8], goal: int) -> Found:
        """The goal is in that ninth of the image whose sentence the whole is most like: as likely
        as it is in the image, and there rather than elsewhere."""
        sentences = [sentence.format(self._names[goal]) for sentence in PLACED]
        rows = [self._prompts.row(sentence) for sentence in sentences]
        if any(row is None for row in rows):
            return NOTHING
        seen = self._look([rgb])
        where = softmax(self._logits(seen.rows, np.array(rows, np.float32)))[0]
        down, along = divmod(int(where.argmax()), 3)
        height, width = rgb.shape[:2]
        ninth = np.array([along, down, along + 1, down + 1]) / 3
        box = np.asarray(ninth[None] * [width, height, width, height], np.float32)
        chance = np.asarray(where.max() * self._chances(seen.rows)[:, goal], np.float32)
        return box, chance, np.array([goal], np.int32)

    def _by_relevance(self, rgb: NDArray[np.uint8], goal: int) -> Found:
        """The goal is where the map for its sentence is high, as likely as it is in the image."""
        seen = self._look([rgb], self._rows[self._owner == goal][:1])
        if seen.relevance is None:
            return NOTHING
        boxes, peaks = regions(seen.relevance, self._size, rgb.shape[:2])
        chance = self._chances(seen.rows)[0, goal]
        return boxes, chance * peaks, np.full(len(boxes), goal, np.int32)

    def _chances(self, rows: Floats) -> Floats:
        """(N, D) unit rows -> (N, C) how likely each picture shows each class, rather than another
        class or none."""
        count = max(int(self._owner.max(initial=0)) + 1, len(self._names))
        best = np.full((count, len(rows)), -np.inf, np.float32)
        np.maximum.at(best, self._owner, self._logits(rows, self._rows).T)
        return softmax(best.T)[:, : len(self._names)]

    def _logits(self, rows: Floats, texts: Floats) -> Floats:
        """(N, D) and (M, D) unit rows -> (N, M)."""
        return np.asarray(self._scale * (rows @ texts.T), np.float32)

    def _look(
        self, pictures: Sequence[NDArray[np.uint8]], text: Floats | None = None
    ) -> TowerAnswer:
        """Pictures, each (h, w, 3), by the tower; at once where it allows that."""
        fitted = [stretch(picture, *self._size)[0] for picture in pictures]
        batch = np.stack([scaled(picture, SCALING) for picture in fitted])
        if self._texts is None and not isinstance(self._image.shape[0], int):
            return self._answer(batch, text)
        seen = [self._answer(batch[i : i + 1], text) for i in range(len(batch))]
        return TowerAnswer(np.concatenate([one.rows for one in seen]), seen[0].relevance)

    def _answer(self, batch: Floats, text: Floats | None) -> TowerAnswer:
        """(N, 3, H, W) and (1, D), where the tower takes it."""
        width, feeds = self._prompts.dimension, {str(self._image.name): batch}
        if self._texts is not None:
            any_text = np.full((1, width), 1 / math.sqrt(width), np.float32)
            feeds[str(self._texts.name)] = any_text if text is None else text
        outputs = run(self._session, feeds, self._path)
        rows = [out for out in outputs if out.shape == (len(batch), width)]
        if not rows:
            raise ModelFileError(
                f"{self._path}: outputs {[out.shape for out in outputs]}; expected "
                f"({len(batch)}, {width}), the texts' width; export both towers with projection"
            )
        maps = [out for out in outputs if out.ndim in (3, 4) and len(out) == 1]
        if self._texts is None or not maps:
            return TowerAnswer(_unit(rows[0]), None)
        return TowerAnswer(_unit(rows[0]), maps[0].reshape(-1, *maps[0].shape[-2:])[0])


def _inputs(session: onnxruntime.InferenceSession, path: Path) -> tuple[Any, Any | None]:
    """The image, and the texts where it takes any; ModelFileError when it is no image tower."""
    images = [i for i in session.get_inputs() if len(i.shape) == 4]
    texts = [i for i in session.get_inputs() if len(i.shape) == 2]
    if len(images) != 1 or len(texts) != len(session.get_inputs()) - 1 or len(texts) > 1:
        have = ", ".join(f"{i.name} {i.shape}" for i in session.get_inputs())
        raise ModelFileError(f"{path}: inputs {have} are no image tower's; expected (N, 3, H, W)")
    for name, free in ((i.name, i.shape[0]) for i in (*images, *texts)):
        if isinstance(free, int) and free != 1:
            raise ModelFileError(
                f"{path}: takes {free} of {name} at once; export it for one or any number"
            )
    return images[0], texts[0] if texts else None


def patches(height: int, width: int) -> NDArray[np.int64]:
    """(P, 4) corners in px of squares that cover an image, as a rule half as high as it and half
    of one apart."""
    side = max(min(height, width) / 2, max(height, width) / FEW, 1.0)
    (top, bottom), (left, right) = _spans(height, side), _spans(width, side)
    rows, columns = (grid.ravel() for grid in np.mgrid[: len(top), : len(left)])
    return np.stack((left[columns], top[rows], right[columns], bottom[rows]), axis=1)


def _spans(length: int, side: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where pieces of `side` px begin and end along `length` px."""
    side = min(side, length)
    begins = np.linspace(0, length - side, math.ceil(2 * (length - side) / side) + 1)
    return begins.astype(np.int64), np.ceil(begins + side).astype(np.int64).clip(max=length)


def regions(
    relevance: Floats, size: tuple[int, int], image: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """A map (h, w) that spans a picture -> boxes (R, 4), image px, around the connected parts that
    are high, and the peak (R,) in 0..1 of each. It is looked at as large as `size`; `image` is the
    image's height and width. A flat map has none."""
    low, high = float(relevance.min()), float(relevance.max())
    if not (math.isfinite(low) and math.isfinite(high) and high > low):
        return NOTHING[:2]
    level = cv2.resize((relevance - low) / np.float32(high - low), (size[1], size[0]))
    mask = (level >= RELEVANT).astype(np.uint8)
    count, parts, stats, _ = cv2.connectedComponentsWithStats(mask)
    peaks = np.zeros(count, np.float32)
    np.maximum.at(peaks, np.asarray(parts, np.int64).ravel(), level.ravel())
    corners = np.concatenate((stats[1:, :2], stats[1:, :2] + stats[1:, 2:4]), axis=1)
    grow = np.array([image[1] / size[1], image[0] / size[0]] * 2, np.float32)
    return np.asarray(corners * grow, np.float32), peaks[1:]


def _unit(rows: Floats) -> Floats:
    """Rows of length 1; what is not finite is none."""
    finite = np.nan_to_num(rows, nan=0.0, posinf=0.0, neginf=0.0)
    return np.asarray(finite / np.linalg.norm(finite, axis=1, keepdims=True).clip(1e-12))
