"""A `Keepsake` as the bytes of one file: a zip of raw arrays and of JSON that says what they
are. What is read is bounded before anything is made of it."""

import io
import json
import zipfile
import zlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from runtime.core.geometry import GridFrame
from runtime.core.keepsake import LAYERS, OBJECTS_KEPT, VIEWS_KEPT, Keepsake
from runtime.core.mapping.drops import DROP_MOST
from runtime.core.mapping.grid import EVIDENCE_MAX, RESOLUTION_M
from runtime.core.mapping.keyframes import KEYFRAMES_KEPT, Keyframe
from runtime.core.mapping.laser_layer import MOST
from runtime.core.objects.instances import LOG_ODDS_MAX, Evidence, Instance
from runtime.core.types import F32, Pose
from runtime.core.world import MOST_SIDE_M
from runtime.errors import SavedError, SensorError
from runtime.log import say
from runtime.robot.json_text import parse_json
from runtime.service.saved import put_aside, saved

VERSION: Final = 1
_UNREADABLE: Final = (
    ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError, RuntimeError,
    EOFError, NotImplementedError, zipfile.BadZipFile, zlib.error, SensorError,
)  # fmt: skip
ABOUT: Final = "about.json"
ABOUT_BYTES: Final = 16 << 20
FILE_BYTES: Final = 256 << 20  # of the whole, packed
SIDE: Final = round(MOST_SIDE_M / RESOLUTION_M) + 256  # cells; a grid grows by blocks
ROOMS, NAMES, LETTERS, EMBEDDING = 64, 64, 200, 8192  # at most, and how long
FAR_M: Final = 1e5
ROOM_MOST: Final = 60_000.0  # of half precision
_LIMITS: Final = {
    "evidence": (-EVIDENCE_MAX, EVIDENCE_MAX), "drops": (0, DROP_MOST), "driven": (0, 1),
    "laser": (0, MOST),
}  # fmt: skip


def packed(known: Keepsake) -> bytes:
    """The file."""
    things, frames = known.instances, known.keyframes
    sums = [thing.embedding_sum for thing in things]
    scenes = [frame.embedding for frame in frames]
    cells = [known.frame.cells(thing.cells_xy) for thing in things]
    arrays: dict[str, NDArray[Any]] = {
        **{name: layer.astype(LAYERS[name]) for name, layer in known.layers.items()},
        "rooms": np.minimum(known.rooms, ROOM_MOST).astype(np.float16),
        "cells": np.concatenate(cells or [np.zeros((0, 2), np.int32)]).astype(np.int32),
        "embeddings": _joined(sums),
        "scenes": _joined(scenes),
    }
    f = known.frame
    about = {
        "version": VERSION,
        "frame": [f.x0_m, f.y0_m, f.resolution_m, f.rows, f.cols],
        "on": _listed(known.on),
        "looks": known.looks,
        "rooms": known.room_names,
        "things": [_thing(t, len(c)) for t, c in zip(things, cells, strict=True)],
        "keyframes": [[*_listed(k.pose), k.sharpness, len(k.embedding)] for k in frames],
    }
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr(ABOUT, json.dumps(about))
        for name, array in arrays.items():
            archive.writestr(name, np.ascontiguousarray(array).tobytes())
    return file.getvalue()


def remembered(path: Path) -> Keepsake | None:
    """What the file holds; None where there is none, and for one that cannot be used: that is said,
    and put aside, for another takes its place."""
    try:
        return saved(path, unpacked, FILE_BYTES)
    except SavedError as error:
        say(f"memory: {error}")
    if path.exists():  # it could not even be read
        with suppress(SavedError):
            put_aside(path)
    return None


def unpacked(raw: bytes) -> Keepsake:
    """ValueError, in words, for what is no such file, or not of this version."""
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            about = parse_json(_member(archive, ABOUT, ABOUT_BYTES), ABOUT, ABOUT_BYTES)
            if about.get("version") != VERSION:
                raise ValueError(f"of version {about.get('version')!s:.20}, not {VERSION}")
            return _read(about, archive)
    except _UNREADABLE as error:
        raise ValueError(f"no memory of rfnav's ({error!s:.200})") from error


def _read(about: Mapping[str, Any], archive: zipfile.ZipFile) -> Keepsake:
    frame = _frame(about["frame"])
    room_names = tuple(_text(name) for name in _items(about["rooms"], ROOMS))
    shape = frame.shape
    layers = {}
    for name, dtype in LAYERS.items():
        read = np.uint8 if dtype is np.bool_ else dtype
        cells = _array(archive, name, read, shape)
        low, high = _LIMITS.get(name, (0, 1))
        layers[name] = np.clip(cells, low, high).astype(dtype)
    rooms = _array(archive, "rooms", np.float16, (len(room_names), *shape)).astype(np.float32)
    if not (np.isfinite(rooms).all() and (rooms >= 0).all()):
        raise ValueError("rooms are no shares")
    told = _items(about["things"], OBJECTS_KEPT)
    ends = [_count(item["cells"], SIDE * SIDE) for item in told]
    cells = _array(archive, "cells", np.int32, (sum(ends), 2))
    if not ((cells >= 0) & (cells < shape)).all():
        raise ValueError("cells of an object off the map")
    sums = _rows(archive, "embeddings", [item["embedding"] for item in told])
    things, first = [], 0
    for item, many, total in zip(told, ends, sums, strict=True):
        things.append(_instance(item, frame.centres(cells[first : first + many]), total))
        first += many
    views = _items(about["keyframes"], KEYFRAMES_KEPT)
    scenes = _rows(archive, "scenes", [item[4] for item in views])
    frames = tuple(
        Keyframe(_pose(item[:3]), scene, _number(item[3], 0.0, 1e9))
        for item, scene in zip(views, scenes, strict=True)
    )
    on, looks = _pose(about["on"]), _text(about["looks"])
    return Keepsake(frame, layers, room_names, rooms, tuple(things), frames, on, looks)


def _joined(rows: Sequence[F32]) -> F32:
    return np.concatenate([np.zeros(0, np.float32), *rows]).astype(np.float32)


def _thing(thing: Instance, cells: int) -> dict[str, object]:
    return {
        "xyz": [*thing.xy, thing.z_m, thing.low_m, thing.high_m],
        "score": thing.best_score,
        "range_m": min(thing.range_m, FAR_M),
        "names": [[n, of.odds, of.rejections, of.since] for n, of in thing.evidence.items()],
        "views": [_listed(view) for view in thing.views],
        "cells": cells,
        "embedding": len(thing.embedding_sum),
    }


def _instance(item: Mapping[str, Any], cells_xy: NDArray[np.float64], total: F32) -> Instance:
    x, y, z, low, high = (_number(v, -FAR_M, FAR_M) for v in item["xyz"])
    evidence = {
        _text(name): Evidence(
            _number(odds, -LOG_ODDS_MAX, LOG_ODDS_MAX),
            rejections=_count(rejections, 1000),
            since=_count(since, VIEWS_KEPT),
        )
        for name, odds, rejections, since in _items(item["names"], NAMES)
    }
    views = [_pose(view) for view in _items(item["views"], VIEWS_KEPT)]
    if not evidence or not len(cells_xy):
        raise ValueError("an object without a name, or nowhere")
    thing = Instance(0, evidence, (x, y), z, cells_xy, low, high, total)
    score, range_m = _number(item["score"], 0.0, 1.0), _number(item["range_m"], 0.0, FAR_M)
    return replace(thing, best_score=score, range_m=range_m, views=views)


def _member(archive: zipfile.ZipFile, name: str, most_bytes: int) -> bytes:
    with archive.open(name) as file:
        raw = file.read(most_bytes + 1)
    if len(raw) > most_bytes:
        raise ValueError(f"{name}: more than {most_bytes} bytes")
    return raw


def _array(archive: zipfile.ZipFile, name: str, dtype: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    size = int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize
    raw = _member(archive, name, size)
    if len(raw) != size:
        raise ValueError(f"{name}: {len(raw)} bytes, not {size}")
    return np.frombuffer(raw, dtype).reshape(shape)


def _rows(archive: zipfile.ZipFile, name: str, lengths: Iterable[object]) -> list[F32]:
    sizes = [_count(length, EMBEDDING) for length in lengths]
    flat = _array(archive, name, np.float32, (sum(sizes),))
    if not np.isfinite(flat).all():
        raise ValueError(f"{name}: not finite")
    ends = np.cumsum(sizes).tolist()
    return [flat[end - size : end] for size, end in zip(sizes, ends, strict=True)]


def _frame(told: object) -> GridFrame:
    x0, y0, resolution, rows, cols = _items(told, 5)
    if resolution != RESOLUTION_M:
        raise ValueError(f"cells of {resolution!s:.20} m, not {RESOLUTION_M}")
    x0_m, y0_m = _number(x0, -FAR_M, FAR_M), _number(y0, -FAR_M, FAR_M)
    return GridFrame(x0_m, y0_m, RESOLUTION_M, _count(rows, SIDE), _count(cols, SIDE))


def _listed(pose: Pose) -> list[float]:
    return [pose.x_m, pose.y_m, pose.yaw_rad]


def _pose(told: object) -> Pose:
    x_m, y_m, yaw_rad = _items(told, 3)
    far = -FAR_M, FAR_M
    return Pose(_number(x_m, *far), _number(y_m, *far), _number(yaw_rad, -4.0, 4.0))


def _items(value: object, most: int) -> Sequence[Any]:
    if not isinstance(value, list) or len(value) > most:
        raise ValueError(f"{value!s:.40} is no list of at most {most}")
    return value


def _number(value: object, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(f"{value!s:.40} is not {low:g} to {high:g}")
    return float(value)


def _count(value: object, most: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= most:
        raise ValueError(f"{value!s:.40} is no count up to {most}")
    return value


def _text(value: object) -> str:
    if not isinstance(value, str) or len(value) > LETTERS or not value.isprintable():
        raise ValueError(f"{value!s:.40} is no name")
    return value
