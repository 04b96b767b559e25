"""Small drawn frames in the format of `hil-sim frames`: to try the trainer without a renderer."""

import json
from pathlib import Path

import cv2
import numpy as np

SHAPES = ("bed", "toilet", "plant", "television")
ROOMS = {"kitchen": (200, 200, 235), "bathroom": (235, 215, 190)}


def draw_frames(out: Path, frames: int, seed: int = 0, width: int = 416, height: int = 320) -> None:
    """Write `frames` images and annotations.json: four kinds of shape on two kinds of wall."""
    rng = np.random.default_rng(seed)
    (out / "images").mkdir(parents=True, exist_ok=True)
    images: list[dict[str, object]] = []
    annotations: list[dict[str, object]] = []
    for i in range(frames):
        room = list(ROOMS)[int(rng.integers(len(ROOMS)))]
        canvas = np.empty((height, width, 3), np.uint8)
        canvas[:] = ROOMS[room]
        canvas[height * 2 // 3 :] = (90, 120, 150)
        for _ in range(int(rng.integers(1, 4))):
            kind = int(rng.integers(len(SHAPES)))
            w, h = (int(v) for v in rng.integers(40, 140, 2))
            x, y = int(rng.integers(0, width - w)), int(rng.integers(0, height - h))
            _draw(canvas, kind, x, y, w, h)
            annotations.append(
                {
                    "id": len(annotations) + 1,
                    "image_id": i,
                    "category_id": kind + 1,
                    "bbox": [x, y, w, h],
                    "area": w * h,
                    "iscrowd": 0,
                }
            )
        name = f"{i:05d}.jpg"
        cv2.imwrite(str(out / "images" / name), canvas)
        size = {"width": width, "height": height}
        images.append({"id": i, "file_name": name, **size, "room": room})
    categories = [{"id": k + 1, "name": name} for k, name in enumerate(SHAPES)]
    table = {"images": images, "annotations": annotations, "categories": categories}
    (out / "annotations.json").write_text(json.dumps(table))


def _draw(canvas: np.ndarray, kind: int, x: int, y: int, w: int, h: int) -> None:
    centre, half = (x + w // 2, y + h // 2), (w // 2, h // 2)
    if kind == 0:
        cv2.rectangle(canvas, (x, y), (x + w, y + h), (60, 60, 190), -1)
        cv2.rectangle(canvas, (x, y), (x + w // 4, y + h), (240, 240, 240), -1)
    elif kind == 1:
        cv2.ellipse(canvas, centre, half, 0, 0, 360, (250, 250, 250), -1)
    elif kind == 2:
        corners = np.array([[x, y + h], [x + w // 2, y], [x + w, y + h]])
        cv2.fillPoly(canvas, [corners], (40, 150, 50))
    else:
        cv2.rectangle(canvas, (x, y), (x + w, y + h), (20, 20, 20), -1)
