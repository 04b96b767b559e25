"""Detections that come over the bus, as JSON: {"boxes": [[x0, y0, x1, y1], ...] px, "names": [...],
"scores": [...], "depths_m": [...] (of the object's own pixels; may be left out), "room": "kitchen"
or null}."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from runtime.core.types import Detections
from runtime.errors import SensorError

ROOM_SURE = 0.9  # share of the room's name that was told; the rest is spread over the others

FARTHEST_PX = 1e6


def read_labels(
    message: Mapping[str, Any], names: Sequence[str], room_names: Sequence[str]
) -> Detections:
    """A message -> detections of the vocabulary's `names`; things of other names are left out.
    SensorError when it is not of that form."""
    try:
        boxes = np.array(message["boxes"], np.float64).reshape(-1, 4)
        scores = np.array(message["scores"], np.float64).reshape(-1)
        index = {name: i for i, name in enumerate(names)}
        depths = np.array(message.get("depths_m", []), np.float64).reshape(-1)
        labels = np.array([index.get(str(name), -1) for name in message["names"]], np.int32)
        room = message.get("room")
    except (KeyError, TypeError, ValueError) as error:
        raise SensorError(f"detections: {error!r}: send boxes, names, scores and room") from error
    if not (len(boxes) == len(scores) == len(labels)) or len(depths) not in (0, len(boxes)):
        raise SensorError("detections: boxes, names, scores and depths must be equally many")
    if not (np.abs(depths) < FARTHEST_PX).all() or not (
        (np.abs(boxes) < FARTHEST_PX).all() and ((scores >= 0) & (scores <= 1)).all()
    ):
        raise SensorError("detections: boxes must be in pixels and scores in 0..1")
    known = labels >= 0
    none = np.zeros((int(known.sum()), 0), np.float32)
    return Detections(
        boxes[known].astype(np.float32),
        scores[known].astype(np.float32),
        labels[known],
        none,
        _rooms(room, tuple(room_names)),
        depths_m=depths[known[: len(depths)]].astype(np.float32),
    )


def _rooms(room: object, names: tuple[str, ...]) -> np.ndarray[Any, np.dtype[np.float32]]:
    if room not in names:
        return np.zeros(0, np.float32)
    p = np.full(len(names), (1 - ROOM_SURE) / max(1, len(names) - 1), np.float32)
    p[names.index(str(room))] = ROOM_SURE
    return p
