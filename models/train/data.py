"""Frames as `hil-sim frames` writes them (COCO detection JSON), and their augmentation."""

import contextlib
import functools
import json
import queue
import threading
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from models.errors import ModelFileError

WIDTH, HEIGHT = FULL = 416, 320
SMALL = 320, 256
"""Sizes (width, height) px. A frame at SMALL takes 0.62 of the time of one at FULL."""
ZOOMED, ZOOM = 0.75, (0.65, 2.0)
"""Share of the frames that are zoomed, and by how much: what is in a frame at 640 px is seen at the
size it has there by networks that take smaller ones."""
KEEP_FRACTION = 0.3
"""A box of which a crop leaves less than this becomes an ignore region."""

SCARCE = 0.03
"""A category that fewer of the frames show than this is shown again (`repeated`)."""

NOISE_SLACK = 128
UNLEARNED = -1
"""The label of what is of a held-out category, which is ignored."""

Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Labelled:
    """One frame: boxes (N, 4) px corners, labels (N,) category indices or UNLEARNED, ignore (N,)
    bool."""

    path: Path
    boxes: NDArray[np.float32]
    labels: NDArray[np.int64]
    ignore: NDArray[np.bool_]
    room: str


class Batch(NamedTuple):
    """`image` (B, 3, H, W) float32 0..255; lists hold one tensor per image; room -1: unknown."""

    image: Tensor
    boxes: list[Tensor]
    labels: list[Tensor]
    ignore: list[Tensor]
    room: Tensor


def read_frames(
    directory: Path, categories: Sequence[str], held_out: Sequence[str] = ()
) -> list[Labelled]:
    """All finished frames of a directory, labels as indices into `categories`; what is of a
    `held_out` category becomes an ignore region.

    Reads annotations.json where it is there, and the shards of a rendering that still runs.
    """
    index = {name: i for i, name in enumerate(categories)} | dict.fromkeys(held_out, UNLEARNED)
    frames: dict[Path, Labelled] = {}
    for path in sorted(directory.rglob("*.json")):
        try:
            table = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue  # still being written; the next scan finds it whole
        for row in _rows(table):
            image = _find(path.parent, row["file_name"])
            if image is not None and image not in frames:
                frames[image] = _labelled(image, row, index)
    if not frames:
        raise ModelFileError(f"{directory}: no annotated frames; make some with `hil-sim frames`")
    return list(frames.values())


def repeated(frames: Sequence[Labelled], rng: np.random.Generator) -> list[Labelled]:
    """The frames, those with a scarce category several times over: sqrt(SCARCE / its share of the
    frames) times on average, by the scarcest that a frame shows (Gupta et al. 2019)."""
    shown = [np.unique(frame.labels[~frame.ignore]) for frame in frames]
    found = np.bincount(np.concatenate(shown))
    times = np.sqrt(np.maximum(1.0, SCARCE * len(frames) / np.maximum(found, 1)))
    wanted = np.array([times[labels].max(initial=1.0) for labels in shown])
    counts = np.floor(wanted + rng.random(len(frames))).astype(int)
    return [frame for frame, count in zip(frames, counts, strict=True) for _ in range(count)]


def _rows(table: Any) -> list[dict[str, Any]]:
    """A shard's rows; a COCO table is brought into the same form."""
    if isinstance(table, list):
        return [r for r in table if isinstance(r, dict) and "objects" in r]
    if not isinstance(table, dict) or "images" not in table or "annotations" not in table:
        return []
    names = {c["id"]: c["name"] for c in table["categories"]}
    objects: dict[int, list[dict[str, Any]]] = {}
    for mark in table["annotations"]:
        row = {"category": names[mark["category_id"]], "bbox": mark["bbox"]}
        row["ignore"] = bool(mark.get("iscrowd"))
        objects.setdefault(mark["image_id"], []).append(row)
    return [{**image, "objects": objects.get(image["id"], [])} for image in table["images"]]


def _labelled(path: Path, row: dict[str, Any], index: dict[str, int]) -> Labelled:
    marks = row["objects"]
    for mark in marks:
        if mark["category"] not in index:
            raise ModelFileError(
                f"{path}: category {mark['category']!r} has no names in names.toml"
            )
    labels = np.array([index[m["category"]] for m in marks], np.int64)
    xywh = np.array([m["bbox"] for m in marks], np.float32).reshape(-1, 4)
    return Labelled(
        path=path,
        boxes=np.concatenate((xywh[:, :2], xywh[:, :2] + xywh[:, 2:]), axis=1),
        labels=labels,
        ignore=np.array([bool(m["ignore"]) for m in marks], np.bool_) | (labels == UNLEARNED),
        room=str(row.get("room") or ""),
    )


def _find(root: Path, name: str) -> Path | None:
    for folder in (root / "images", root, root.parent / "images", root.parent):
        if (folder / name).is_file():
            return (folder / name).resolve()
    return None


def load(path: Path) -> Image:
    """(H, W, 3) uint8 RGB."""
    bgr = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if bgr is None:
        raise ModelFileError(f"{path}: not a readable image; render the frames again")
    return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)


def augment(
    image: Image, frame: Labelled, rng: np.random.Generator, size: tuple[int, int] = FULL
) -> tuple[Image, NDArray[np.float32], NDArray[np.int64], NDArray[np.bool_]]:
    """Flip, zoom and shift, then what cameras do; boxes follow and are clipped."""
    height, width = image.shape[:2]
    move = np.array([[size[0] / width, 0, 0], [0, size[1] / height, 0]], np.float64)
    if rng.random() < ZOOMED:
        zoom = float(np.exp(rng.uniform(*np.log(ZOOM))))
        slack = np.array(size) * (1 - zoom)
        move = move * zoom
        move[:, 2] += slack * rng.random(2)
    if rng.random() < 0.5:
        move[0] *= -1
        move[0, 2] += size[0]
    fill = tuple(int(v) for v in rng.integers(60, 180, 3))
    pixels = move.copy()  # boxes are of edges, pixels of middles: half a pixel apart
    pixels[:, 2] += 0.5 * move[:, :2].sum(axis=1) - 0.5
    image = np.asarray(
        cv2.warpAffine(image, pixels, size, flags=cv2.INTER_LINEAR, borderValue=fill),
        np.uint8,
    )
    boxes, visible = _moved(frame.boxes, move, size)
    whole = visible > KEEP_FRACTION
    kept = visible > 0.02
    ignore = frame.ignore | ~whole
    return _photograph(image, rng), boxes[kept], frame.labels[kept], ignore[kept]


def _moved(
    boxes: NDArray[np.float32], move: NDArray[np.float64], size: tuple[int, int]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Boxes after an axis-aligned move, clipped, and the fraction of each that is left."""
    x = boxes[:, 0::2] * move[0, 0] + move[0, 2]
    y = boxes[:, 1::2] * move[1, 1] + move[1, 2]
    full = np.stack((x.min(1), y.min(1), x.max(1), y.max(1)), 1) if len(boxes) else boxes
    limit = np.array([*size, *size], np.float32)
    cut = np.clip(full, 0, limit).astype(np.float32)
    area = np.maximum((full[:, 2:] - full[:, :2]).prod(1), 1e-6)
    return cut, ((cut[:, 2:] - cut[:, :2]).prod(1) / area).astype(np.float32)


def _photograph(image: Image, rng: np.random.Generator) -> Image:
    """Exposure, white balance, saturation, blur, noise and compression, each at random."""
    if rng.random() < 0.8:
        image = _recolour(image, rng)
    if rng.random() < 0.2:
        image = np.asarray(cv2.GaussianBlur(image, (5, 5), rng.uniform(0.4, 1.5)), np.uint8)
    if rng.random() < 0.3:
        height, width = image.shape[:2]
        y, x = (int(v) for v in rng.integers(0, NOISE_SLACK, 2))
        grain = _noise()[y : y + height, x : x + width] * np.float32(rng.uniform(2, 12))
        image = np.asarray(cv2.add(image, grain, dtype=cv2.CV_8U), np.uint8)
    if rng.random() < 0.2:
        quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(35, 90))]
        image = np.asarray(cv2.imdecode(cv2.imencode(".jpg", image, quality)[1], 1), np.uint8)
    return image


def _recolour(image: Image, rng: np.random.Generator) -> Image:
    """One affine map of RGB: saturation about grey, contrast and level, gains per channel."""
    level = float(image[::8, ::8].mean())
    saturation, contrast = rng.uniform(0.5, 1.4), rng.uniform(0.7, 1.25)
    mix = saturation * np.eye(3) + (1 - saturation) / 3
    gains = contrast * rng.uniform(0.9, 1.1, 3)
    shift = level * (rng.uniform(0.7, 1.25) - contrast) * np.ones((3, 1))
    return np.asarray(cv2.transform(image, np.hstack((mix * gains[:, None], shift))), np.uint8)


@functools.cache
def _noise() -> NDArray[np.float32]:
    shape = (HEIGHT + NOISE_SLACK, WIDTH + NOISE_SLACK, 3)
    return np.random.default_rng(0).standard_normal(shape, np.float32)


def collate(
    frames: Sequence[Labelled],
    rooms: Sequence[str],
    rng: np.random.Generator,
    size: tuple[int, int] = FULL,
) -> Batch:
    """Read and augment frames into one batch; a frame that cannot be read is an error."""
    images, boxes, labels, ignore, room = [], [], [], [], []
    for frame in frames:
        image, b, c, i = augment(load(frame.path), frame, rng, size)
        images.append(torch.from_numpy(image))
        boxes.append(torch.from_numpy(b))
        labels.append(torch.from_numpy(c))
        ignore.append(torch.from_numpy(i))
        room.append(rooms.index(frame.room) if frame.room in rooms else -1)
    stack = torch.stack(images).permute(0, 3, 1, 2).float()
    stack = stack.contiguous(memory_format=torch.channels_last)
    return Batch(stack, boxes, labels, ignore, torch.tensor(room))


def batches(
    frames: Sequence[Labelled],
    rooms: Sequence[str],
    count: int,
    rng: np.random.Generator,
    size: Callable[[], tuple[int, int]] = lambda: FULL,
) -> Generator[Batch]:
    """One pass in random order, prepared ahead in a thread; the last short batch is dropped.

    `size` is asked anew for every batch.
    """
    order = rng.permutation(len(frames))
    ready: queue.Queue[Batch | BaseException | None] = queue.Queue(maxsize=2)
    stopped = threading.Event()

    def produce() -> None:
        try:
            for i in range(0, len(order) - count + 1, count):
                if stopped.is_set():
                    return
                chosen = [frames[j] for j in order[i : i + count]]
                ready.put(collate(chosen, rooms, rng, size()))
            ready.put(None)
        except BaseException as error:  # noqa: BLE001 raised again where the batch is awaited
            ready.put(error)

    producer = threading.Thread(target=produce, daemon=True)
    producer.start()
    try:
        while (item := ready.get()) is not None:
            if isinstance(item, BaseException):
                raise item
            yield item
    finally:
        stopped.set()  # a thread that works while the process ends may abort it
        while producer.is_alive():
            with contextlib.suppress(queue.Empty):
                ready.get(timeout=0.05)
