"""Contact sheets: what a detector says about frames or pictures, drawn for a person to judge."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from models.detection.boxes import letterbox
from models.detection.detections import Detector, RawDetections
from models.errors import ModelFileError
from models.evaluation.naming import asked_for
from models.evaluation.truth import FrameTruth, Marks, NameLists

COLUMNS, ROWS = 4, 6
WIDTH, HEIGHT = 640, 480
"""Of one picture on the sheet, px."""
GAP, LONGEST = 4, 40
"""Between pictures, px; of a picture's name, characters."""
SHOWN = 0.3
"""Weaker detections are not drawn."""
NO_MARKS = Marks(np.zeros((0, 4), np.float32), np.zeros(0, np.int64), np.zeros(0, bool))
TRUE = (255, 255, 255)
FONT, SIZE = cv2.FONT_HERSHEY_SIMPLEX, 0.5
# Colours that differ from each other and from rooms, dark enough for white letters.
PALETTE = (
    (200, 30, 30), (20, 110, 200), (20, 130, 40), (160, 40, 160), (190, 95, 0), (0, 125, 125),
    (120, 80, 30), (80, 60, 200), (170, 20, 90), (70, 110, 0),
)  # fmt: skip

Image = NDArray[np.uint8]
Place = tuple[int, int, int]
"""Of a written line: its left, its foot, its width, px."""


def draw_sheet(detector: Detector, truth: FrameTruth, words: NameLists, out: Path) -> None:
    """COLUMNS x ROWS frames, evenly drawn from those with objects, with truth in thin white."""
    full = [k for k, m in enumerate(truth.marks) if len(m.kinds) - int(m.crowd.sum()) >= 2]
    full = full or list(range(len(truth.marks)))
    chosen = [full[i] for i in np.linspace(0, len(full) - 1, COLUMNS * ROWS).astype(int)]
    detector.set_vocabulary(asked_for(truth), words.rooms)
    pictures = []
    for k in dict.fromkeys(chosen):
        image = truth.table["images"][k]
        rgb = truth.picture(image["file_name"])
        seen = detector.detect(rgb)
        room = words.rooms[int(seen.rooms.argmax())] if len(seen.rooms) else "no rooms"
        caption = f"{room} ({seen.rooms.max():.2f})" if len(seen.rooms) else room
        caption += f", truth: {image.get('room') or 'unknown'}"
        pictures.append(_fitted(rgb, seen, truth.marks[k], truth.categories, caption))
    _write_sheet(pictures, out)


def draw_pictures(
    pictures: Sequence[tuple[str, Image]], seen: Sequence[RawDetections], classes: Sequence[str],
    out: Path,
) -> None:  # fmt: skip
    """Pictures of any size, each (name, (H, W, 3) RGB), with what was detected in each."""
    drawn = []
    for (name, rgb), found in zip(pictures, seen, strict=True):
        shown = int((found.scores >= SHOWN).sum())
        size = f"{rgb.shape[1]} x {rgb.shape[0]}"
        caption = f"{name[-LONGEST:]}, {size}: {shown or 'nothing'} with a score of {SHOWN} or more"
        drawn.append(_fitted(rgb, found, NO_MARKS, classes, caption))
    _write_sheet(drawn, out)


def _fitted(
    rgb: Image, seen: RawDetections, marks: Marks, categories: Sequence[str], caption: str
) -> Image:
    """(H, W, 3) of any size -> (HEIGHT, WIDTH, 3), drawn."""
    fitted, fit = letterbox(rgb, HEIGHT, WIDTH)
    shift = np.array([fit.left, fit.top] * 2, np.float32)
    seen = seen._replace(boxes_px=seen.boxes_px * np.float32(fit.scale) + shift)
    marks = replace(marks, boxes=marks.boxes * np.float32(fit.scale) + shift)
    return draw(fitted, seen, marks, categories, caption)


def _write_sheet(pictures: list[Image], out: Path) -> None:
    pictures = [np.pad(p, ((0, GAP), (0, GAP), (0, 0))) for p in pictures]
    pictures += [np.zeros_like(pictures[0])] * (-len(pictures) % COLUMNS)
    lines = [np.hstack(pictures[i : i + COLUMNS]) for i in range(0, len(pictures), COLUMNS)]
    try:
        written = cv2.imwrite(str(out), np.vstack(lines)[..., ::-1])
    except cv2.error:  # no ending that it knows
        written = False
    if not written:
        raise ModelFileError(f"{out}: cannot be written; name a .png in a directory that is there")


def draw(
    rgb: Image, seen: RawDetections, marks: Marks, categories: Sequence[str], caption: str
) -> Image:
    """(H, W, 3) RGB with boxes, names and scores; truth that counts in white."""
    out = rgb.copy()
    for box in marks.boxes[~marks.crowd]:
        x0, y0, x1, y1 = (int(v) for v in box)
        cv2.rectangle(out, (x0, y0), (x1, y1), TRUE, 1)
    shown = np.flatnonzero(seen.scores >= SHOWN)[::-1]  # the best on top
    for k in shown:
        colour = PALETTE[int(seen.labels[k]) % len(PALETTE)]
        x0, y0, x1, y1 = (int(v) for v in seen.boxes_px[k])
        cv2.rectangle(out, (x0, y0), (x1, y1), colour, 2)
    taken = [_write(out, caption, 0, len(out), (40, 40, 40), [])]
    for k in shown[::-1]:  # the best choose first where to stand
        name = f"{categories[int(seen.labels[k])]} {seen.scores[k]:.2f}"
        x, y = (int(v) for v in seen.boxes_px[k][:2])
        taken.append(_write(out, name, x, y, PALETTE[int(seen.labels[k]) % len(PALETTE)], taken))
    return out


def _write(
    out: Image, text: str, x: int, y: int, colour: tuple[int, int, int], taken: Sequence[Place]
) -> Place:
    """A line of white text on a filled ground, above (x, y) or, where others stand, below, kept
    inside the picture."""
    (width, height), below = cv2.getTextSize(text, FONT, SIZE, 1)
    width, height = width + 4, height + below + 4
    x = max(0, min(x, out.shape[1] - width))
    y = min(max(y, height), out.shape[0])
    while y + height <= out.shape[0] and any(
        x < left + wide and left < x + width and abs(y - foot) < height
        for left, foot, wide in taken
    ):
        y += height
    cv2.rectangle(out, (x, y - height), (x + width, y), colour, -1)
    cv2.putText(out, text, (x + 2, y - below - 1), FONT, SIZE, (255, 255, 255), 1, cv2.LINE_AA)
    return x, y, width
