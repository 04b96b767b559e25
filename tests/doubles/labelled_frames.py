"""Labelled frames of one colour, and a detector that sees a sofa in each."""

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from models.evaluation.truth import FrameTruth, read_truth
from models.words.text_encoder import TextEncoder

CATEGORIES = ("sofa", "toilet", "guitar")
SOFA = [1, [10, 10, 50, 40], 0]
"""In view whole, where the detector sees one."""


def write_frames(folder: Path, notes: list[list[tuple[int, list[float], int]]]) -> FrameTruth:
    """One 96x64 frame a list of (category id, x y w h, ignored)."""
    (folder / "images").mkdir(parents=True)
    images, rows = [], []
    for k, marks in enumerate(notes, 1):
        name = f"{k}.png"
        cv2.imwrite(str(folder / "images" / name), np.full((64, 96, 3), 90, np.uint8))
        images.append({"id": k, "file_name": name, "width": 96, "height": 64, "room": "bathroom"})
        for category, box, crowd in marks:
            area = box[2] * box[3]
            row = {"image_id": k, "category_id": category, "bbox": box, "iscrowd": crowd}
            rows.append({"id": len(rows) + 1, **row, "area": area})
    categories = [{"id": i, "name": name} for i, name in enumerate(CATEGORIES, 1)]
    table = {"images": images, "annotations": rows, "categories": categories}
    (folder / "annotations.json").write_text(json.dumps(table))
    return read_truth(folder)


def sofa_graph(constant_graph: Callable[..., Path], encoder: TextEncoder) -> Path:
    """A file of our contract: a sofa, 10..60 by 10..50 px, whatever is shown, in a bathroom."""
    sofa, bathroom = encoder.embed(["sofa", "a bathroom"])
    outputs = {
        "boxes": np.array([[[10, 10, 60, 50], [70, 2, 90, 20]]], np.float32),
        "objectness": np.array([[0.9, 0.1]], np.float32),
        "embeddings": np.stack((sofa, sofa))[None],
        "scene": bathroom[None],
    }
    values = {"scale": "20.0", "bias": "-12.0", "room_scale": "10.0", "gain": "1.5"}
    metadata = {f"value.{k}": v for k, v in values.items()} | {"format": "rf-nav-detector/1"}
    return constant_graph(outputs, (64, 96), metadata)
