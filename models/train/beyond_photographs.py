"""What the detector's backbone has of photographs of rooms: they keep the scene-layout expert
honest where images are no renderings."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from models.checksum import sha256
from models.detection.boxes import letterbox
from models.detection.detector import FEATURES
from models.errors import ModelFileError
from models.onnx_session import image_size, open_session
from models.train.beyond_data import Change
from models.train.beyond_head import Photographs
from models.train.labelled import read_frames

TOLD_EVERY = 500


def read_photographs(
    folder: Path, detector: Path, kept: Path, rooms: tuple[str, ...], change: Change | None,
    say: Callable[[str], None],
) -> Photographs:  # fmt: skip
    """The folder's images that have a room type, as `detector` sees them; `kept` is a file that
    remembers it, of one detector: another one looks again. `change` is applied to the features.
    Raises ModelFileError."""
    own = sha256(detector)
    if _seen_by(kept) != own:
        frames = [f for f in read_frames(folder, ()) if f.room in rooms]
        if not frames:
            raise ModelFileError(f"{folder}: no image has one of the rooms {', '.join(rooms)}")
        features = look(detector, [f.path for f in frames], say)
        partial = kept.with_suffix(".partial.npz")
        np.savez(partial, features=features, room=np.array([f.room for f in frames]), detector=own)
        partial.replace(kept)
    with np.load(kept, allow_pickle=False) as file:
        features, named = file["features"], file["room"].tolist()
    seen = features.astype(np.float32)
    seen = seen if change is None else change(seen)
    room = torch.tensor([rooms.index(name) for name in named])
    return Photographs(torch.from_numpy(seen), room)


def _seen_by(kept: Path) -> str:
    """The digest of the detector whose features are kept; "" where none is, or it is not told."""
    if not kept.exists():
        return ""
    with np.load(kept, allow_pickle=False) as file:
        return str(file["detector"]) if "detector" in file else ""


def look(detector: Path, images: list[Path], say: Callable[[str], None]) -> NDArray[np.float16]:
    """(P, C, h, w) of image files. Raises ModelFileError for a detector that does not tell."""
    session = open_session(detector, 1)
    if FEATURES not in {o.name for o in session.get_outputs()}:
        raise ModelFileError(f"{detector}: has no output {FEATURES}; see models.train.features")
    own = session.get_inputs()[0]
    size = image_size(own.shape, detector)
    seen = []
    for path in images:
        bgr = cv2.imread(str(path))
        if bgr is None:
            raise ModelFileError(f"{path}: cannot be read as an image; delete it or fetch it again")
        image, _ = letterbox(np.ascontiguousarray(bgr[..., ::-1], np.uint8), *size)
        feed = np.ascontiguousarray(image.transpose(2, 0, 1)[None], np.float32)
        seen.append(session.run([FEATURES], {own.name: feed})[0][0].astype(np.float16))
        if len(seen) % TOLD_EVERY == 0:
            say(f"photographs: {len(seen)} of {len(images)}")
    return np.stack(seen)
