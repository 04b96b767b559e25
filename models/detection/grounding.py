"""Networks that find what a caption names, as MDETR works.

Contract "grounding":

| | | |
|---|---|---|
| input | image (1, 3, H, W) float32 | RGB, ImageNet's normalisation, stretched |
| input | `input_ids`, `attention_mask` (1, T) int64 | the caption; T is free or filled up |
| output | (1, Q, 4) | boxes: cx, cy, w, h in 0..1 |
| output | (1, Q, S) | logits of each box over the caption's tokens, the last one "no object" |

`tokenizer.json` lies beside it. The metadata may hold `value.gain`, `value.shift` of a calibration.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
from numpy.typing import NDArray
from tokenizers import Encoding

from models.detection.boxes import scaled, stretch
from models.detection.calibration import read_constants, settled, softmax
from models.detection.detections import NOTHING, Floats, RawDetections, boxes_only, checked
from models.detection.told import IMAGENET
from models.errors import ModelFileError
from models.onnx_session import image_size, run
from models.words.class_names import check_names
from models.words.text_encoder import open_tokenizer

SIDE_PX = 800
"""Height and width where the file leaves them open: about what such networks are trained with."""
CAPTION = ("input_ids", "attention_mask")
EXPECTED = "expected boxes (1, Q, 4) and logits (1, Q, S) over the caption's tokens"
TRIAL = "chair"


class GroundingDetector:
    """The contract above. The caption is the goal's name, and it alone is found, once there is
    one. A box counts when its tokens of the name outweigh "no object"."""

    def __init__(self, session: onnxruntime.InferenceSession, path: Path, tokenizer: Path) -> None:
        self._session, self._path = session, path
        constants = read_constants(session.get_modelmeta().custom_metadata_map, path)
        self._gain, self._shift = constants["gain"], constants["shift"]
        inputs = {i.name: i for i in session.get_inputs()}
        images = [i for i in inputs.values() if len(i.shape) == 4]
        if len(images) != 1 or set(inputs) != {images[0].name, *CAPTION}:
            raise ModelFileError(
                f"{path}: inputs {sorted(inputs)}; expected an image (1, 3, H, W), "
                f"{' and '.join(CAPTION)} (1, T)"
            )
        self._image, self._outputs = str(images[0].name), _outputs(session, path)
        self._size = image_size(images[0].shape, path, SIDE_PX)
        remedy = "give the network's to `rfnav models import` with --texts"
        self._tokenizer = open_tokenizer(tokenizer, remedy)
        length = inputs["input_ids"].shape[-1]
        if isinstance(length, int):
            self._tokenizer.enable_truncation(length)
            self._tokenizer.enable_padding(length=length)
        self._names: tuple[str, ...] = ()
        self._goal: int | None = None
        self._answer(np.full((*self._size, 3), 114, np.uint8), self._tokenizer.encode(TRIAL))
        self.capabilities: dict[str, Any] = {
            "contract": "grounding",
            "open_vocabulary": True,
            "rooms": False,
            "embeddings": False,
            "classes": None,
        }

    def set_vocabulary(self, classes: Sequence[Sequence[str]], rooms: Sequence[str]) -> None:
        """Take the classes' first names. None is the goal any more."""
        check_names([name for names in classes for name in names], "vocabulary")
        self._names, self._goal = tuple(names[0] for names in classes), None
        self.capabilities |= {"matched": {}, "unseen": []}

    def look_for(self, goal: int) -> None:
        """From now on this class of the vocabulary is the goal."""
        self._goal = goal

    def detect(self, rgb: NDArray[np.uint8]) -> RawDetections:
        """(H, W, 3) uint8 RGB -> detections of the goal."""
        checked(rgb)
        if self._goal is None:
            return boxes_only(*NOTHING)
        caption = self._tokenizer.encode(self._names[self._goal])
        boxes, logits = self._answer(rgb, caption)
        chances = softmax(logits)
        named = np.flatnonzero(np.array(caption.special_tokens_mask) == 0)
        name = chances[:, named[named < logits.shape[1] - 1]].sum(axis=1)
        scores = np.where(name > chances[:, -1], name, 0)
        half, frame = boxes[:, 2:] / 2, np.array([*rgb.shape[1::-1]] * 2, np.float32)
        corners = np.concatenate((boxes[:, :2] - half, boxes[:, :2] + half), axis=1) * frame
        labels = np.full(len(boxes), self._goal, np.int32)
        found = boxes_only(corners.clip(0, frame), scores, labels)
        return found._replace(scores=settled(found.scores, self._gain, self._shift))

    def _answer(self, rgb: NDArray[np.uint8], caption: Encoding) -> tuple[Floats, Floats]:
        """(Q, 4) boxes and (Q, S) logits."""
        feeds: dict[str, NDArray[Any]] = {
            self._image: scaled(stretch(rgb, *self._size)[0], IMAGENET)[None],
            "input_ids": np.array([caption.ids]),
            "attention_mask": np.array([caption.attention_mask]),
        }
        boxes, logits = (run(self._session, feeds, self._path)[i] for i in self._outputs)
        if boxes.shape[::2] != (1, 4) or logits.shape[:2] != boxes.shape[:2]:
            raise ModelFileError(f"{self._path}: outputs {boxes.shape}, {logits.shape}; {EXPECTED}")
        return boxes[0], logits[0]


def _outputs(session: onnxruntime.InferenceSession, path: Path) -> tuple[int, int]:
    """Which output is the boxes, by its four values, and which the logits."""
    shapes = [list(out.shape) for out in session.get_outputs()]
    boxes = [i for i, shape in enumerate(shapes) if len(shape) == 3 and shape[2] == 4]
    logits = [i for i, shape in enumerate(shapes) if len(shape) == 3 and i not in boxes]
    if len(boxes) != 1 or len(logits) != 1:
        raise ModelFileError(f"{path}: outputs {shapes}; {EXPECTED}")
    return boxes[0], logits[0]
