"""Photographs whose room type is known, as a detector sees them."""

import json
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from hil_sim.expert_bench.seeing import BenchDetector
from hil_sim.expert_bench.view_questions import AHEAD, SightRows
from hil_sim.scenes.format import ROOM_TYPES
from runtime.errors import RfNavError


def load_photographs(folder: Path) -> tuple[SightRows, NDArray[np.int8]]:
    """Those of a folder as `hil-sim frames` writes it whose `room` is one of ROOM_TYPES: what is
    seen of them, without depth, and the room (N,). RfNavError when there are none."""
    listed = _listed(folder)
    detector = BenchDetector.open()
    seen = [detector.models.detect(_picture(folder / "images" / name)) for name, _ in listed]
    detector.models.close()
    features = np.array([s.features for s in seen], np.float16)
    count, parts = len(seen), features.shape[2:]
    sights = SightRows(
        features,
        np.zeros((count, 2, *parts), np.float16),
        np.array([s.scene for s in seen]),
        np.array([s.rooms for s in seen]),
        np.full(count, AHEAD[0]),
        np.full(count, AHEAD[1]),
        tuple(name for name, _ in listed),
    )
    return sights, np.array([ROOM_TYPES.index(room) for _, room in listed], np.int8)


def _listed(folder: Path) -> list[tuple[str, str]]:
    path = folder / "annotations.json"
    try:
        images = json.loads(path.read_text(encoding="utf-8"))["images"]
        found = [(str(i["file_name"]), str(i["room"])) for i in images if i["room"] in ROOM_TYPES]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise RfNavError(f"{path}: not a table of photographs with rooms ({error!r})") from error
    if not found:
        raise RfNavError(f"{path}: no photograph of a room; its images need a `room`")
    return found


def _picture(path: Path) -> NDArray[np.uint8]:
    """(H, W, 3) RGB."""
    bgr = cv2.imread(str(path)) if path.is_file() else None
    if bgr is None:
        raise RfNavError(f"{path}: no such photograph, or it cannot be read")
    return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)
