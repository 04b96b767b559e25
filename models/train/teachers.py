"""`python -m models.train.teachers --data DIR --teacher FILE --out DIR`: boxes for photographs that
have none, or not of everything, by detectors that know photographs.

What several teachers see at one place and call alike is surer than each; what is sure enough is a
box, what is not an ignore region. What a folder's table says it has boxed throughout is left as it
is. The pictures stay where they are.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
import cv2
import numpy as np
from numpy.typing import NDArray

from models.detection.detections import Detector, RawDetections
from models.detection.detector import open_detector
from models.detection.fusion import paired
from models.errors import ModelFileError, told
from models.evaluation.truth import NameLists, read_truth, read_words
from models.store import manifest
from models.words.text_encoder import TextEncoder

SURE, UNSURE = 0.6, 0.25
"""Probability from which a thing is a box, and from which it is an ignore region."""


class Opinion(NamedTuple):
    """Things in one picture: `boxes` (N, 4) px corners, `labels` (N,), `surety` (N,) in 0..1."""

    boxes: NDArray[np.float32]
    labels: NDArray[np.int32]
    surety: NDArray[np.float32]


def agreed(found: Sequence[RawDetections]) -> Opinion:
    """What the teachers see together, the surest first. Of one thing, a box of each teacher at
    most, the box is the mean by surety, and the probability that not all are wrong its surety."""
    places = paired(found)
    boxes, surety = np.zeros((len(places.labels), 4)), np.zeros(len(places.labels))
    for k, which in enumerate(places.which):
        those = [(f.boxes_px[n], f.scores[n]) for f, n in zip(found, which, strict=True) if n >= 0]
        sure = np.array([score for _, score in those], np.float64)
        boxes[k] = np.average([box for box, _ in those], axis=0, weights=sure)
        surety[k] = 1 - np.prod(1 - sure)
    order = np.argsort(-surety, kind="stable")
    return Opinion(
        boxes[order].astype(np.float32), places.labels[order], surety[order].astype(np.float32)
    )


def annotate(folder: Path, teachers: Sequence[Detector], words: NameLists) -> dict[str, Any]:
    """The folder's COCO table with what the teachers see added, `score` its surety. Raises
    ModelFileError."""
    names = [*words.trained, *words.held_out]
    for teacher in teachers:
        teacher.set_vocabulary([[name] for name in names], ())
    known = {n for n in names if any(n not in t.capabilities["unseen"] for t in teachers)}
    truth = read_truth(folder)
    info = _info(folder / "annotations.json")
    labelled = set(info["labelled"])
    categories = list(dict.fromkeys([*truth.categories, *names]))
    index = {name: k for k, name in enumerate(categories, 1)}
    old = {c["id"]: index[c["name"]] for c in truth.table["categories"]}
    notes = [{**n, "category_id": old[n["category_id"]]} for n in truth.table["annotations"]]
    for image, picture in zip(truth.table["images"], truth.pictures("pictures"), strict=True):
        seen = agreed([teacher.detect(picture) for teacher in teachers])
        for box, label, surety in zip(*seen, strict=True):
            if surety >= UNSURE and names[label] not in labelled:
                note = {"id": len(notes) + 1, "image_id": image["id"], **_mark(box, surety)}
                notes.append(note | {"category_id": index[names[label]]})
        image["file_name"] = str(_place(folder, image["file_name"]))
    return {
        "info": {**info, "taught": sorted(known - labelled)},
        "images": truth.table["images"],
        "annotations": notes,
        "categories": [{"id": k, "name": name} for name, k in index.items()],
    }


def _mark(box: NDArray[np.float32], surety: float) -> dict[str, Any]:
    """What a COCO table says of a box beside whose and what it is."""
    x0, y0, x1, y1 = (round(float(v), 1) for v in box)
    sides = {"bbox": [x0, y0, x1 - x0, y1 - y0], "area": (x1 - x0) * (y1 - y0)}
    return {**sides, "iscrowd": int(surety < SURE), "score": round(float(surety), 3)}


def _info(path: Path) -> dict[str, Any]:
    info = json.loads(path.read_text(encoding="utf-8")).get("info")
    if not isinstance(info, dict) or not isinstance(info.get("labelled"), list):
        raise ModelFileError(
            f"{path}: info.labelled is missing, everything counts as boxed; list there what "
            "is boxed throughout, or nothing: []"
        )
    return info


def _place(folder: Path, name: str) -> Path:
    for where in (folder / "images", folder):
        if (where / name).is_file():
            return (where / name).resolve()
    raise ModelFileError(f"{folder}: image {name} is gone")


@click.command(
    epilog="Example:  python -m models.train.teachers --data rooms --out rooms-boxed "
    "--teacher models/weights/nanodet-g.onnx --teacher yolox"
)
@click.option("--data", type=click.Path(path_type=Path, exists=True), required=True)
@click.option(
    "--teacher",
    "teachers",
    type=click.Path(path_type=Path, exists=True),
    multiple=True,
    required=True,
    help="An ONNX detector of any contract, or a folder: model.onnx with its classes.txt.",
)
@click.option("--out", type=click.Path(path_type=Path), required=True)
def main(data: Path, teachers: tuple[Path, ...], out: Path) -> None:
    """Write OUT/annotations.json: DATA's table with boxes that the teachers agree on."""
    encoder = TextEncoder(manifest.fetch("minilm"))
    opened = [open_detector(path, "auto", encoder) for path in teachers]
    table = annotate(data, opened, read_words())
    out.mkdir(parents=True, exist_ok=True)
    (out / "annotations.json").write_text(json.dumps(table), encoding="utf-8")
    sure = sum(not note.get("iscrowd") for note in table["annotations"])
    click.echo(
        f"{out}: {len(table['images'])} pictures, {sure} boxes and "
        f"{len(table['annotations']) - sure} ignore regions"
    )


if __name__ == "__main__":
    cv2.setNumThreads(1)
    told(main)
