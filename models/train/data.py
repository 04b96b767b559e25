"""Labelled frames read, augmented and put together into batches."""

import contextlib
import functools
import queue
import threading
from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from models.errors import ModelFileError
from models.train.labelled import Labelled

WIDTH, HEIGHT = FULL = 416, 320
SMALL = 320, 256
"""Sizes (width, height) px. A frame at SMALL takes 0.62 of the time of one at FULL."""
ZOOMED, ZOOM = 0.75, (0.7, 2.3)
"""Share of the frames that are zoomed, and by how much: what is in a frame at 640 px is seen at the
size it has there by networks that take smaller ones."""
STRETCH = 1.1
"""How much more a frame may be stretched one way than the other; what is left over is grey."""
KEEP_FRACTION = 0.3
"""A box of which a crop leaves less than this becomes an ignore region."""
SMALLEST_PX2 = 64.0
"""So does one with less area, a cell of the finest level."""

NOISE_SLACK = 128
Image = NDArray[np.uint8]


class Batch(NamedTuple):
    """`image` (B, 3, H, W) float32 0..255; lists hold one tensor per image; room -1: unknown;
    `boxed` (B, C) 0..1: how surely there is none of a category without a box."""

    image: Tensor
    boxes: list[Tensor]
    labels: list[Tensor]
    ignore: list[Tensor]
    surety: list[Tensor]
    room: Tensor
    boxed: Tensor


def load(path: Path) -> Image:
    """(H, W, 3) uint8 RGB."""
    bgr = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if bgr is None:
        raise ModelFileError(f"{path}: not a readable image; render the frames again")
    return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)


def augment(
    image: Image, frame: Labelled, rng: np.random.Generator, size: tuple[int, int] = FULL
) -> tuple[Image, Labelled]:
    """Flip, zoom and shift, then what cameras do; boxes follow and are clipped."""
    height, width = image.shape[:2]
    fit = np.array((size[0] / width, size[1] / height))
    fit = np.minimum(fit, STRETCH * fit.min())
    if rng.random() < ZOOMED:
        fit *= float(np.exp(rng.uniform(*np.log(ZOOM))))
    move = np.hstack((np.diag(fit), np.zeros((2, 1))))
    move[:, 2] = (np.array(size) - fit * (width, height)) * rng.random(2)
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
    whole = (visible > KEEP_FRACTION) & ((boxes[:, 2:] - boxes[:, :2]).prod(1) > SMALLEST_PX2)
    kept = visible > 0.02
    ignore = frame.ignore | ~whole
    return _photograph(image, rng), replace(
        frame,
        boxes=boxes[kept],
        labels=frame.labels[kept],
        ignore=ignore[kept],
        surety=frame.surety[kept],
    )


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
    images, shown = [], []
    for frame in frames:
        image, seen = augment(load(frame.path), frame, rng, size)
        images.append(torch.from_numpy(image))
        shown.append(seen)
    stack = torch.stack(images).permute(0, 3, 1, 2).float()
    return Batch(
        image=stack.contiguous(memory_format=torch.channels_last),
        boxes=[torch.from_numpy(seen.boxes) for seen in shown],
        labels=[torch.from_numpy(seen.labels) for seen in shown],
        ignore=[torch.from_numpy(seen.ignore) for seen in shown],
        surety=[torch.from_numpy(seen.surety) for seen in shown],
        room=torch.tensor([rooms.index(f.room) if f.room in rooms else -1 for f in shown]),
        boxed=torch.from_numpy(np.stack([seen.boxed for seen in shown])),
    )


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
