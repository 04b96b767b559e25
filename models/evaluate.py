"""`python -m models.evaluate --data DIR`: how well a detector does on labelled frames.

Average precision at IoU 0.5 by pycocotools, room accuracy, and what its scores are worth: the
calibration that makes a score the share of such detections that are right, and the operating
threshold for "target seen". Thresholds come from generated homes only.
"""

import contextlib
import io
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from models import store
from models.boxes import pairwise_iou
from models.detector import Detector, RawDetections, open_detector
from models.errors import ModelError
from models.text import TextEncoder
from models.vocabulary import load_vocabulary

GOALS = ("bed", "sofa", "chair", "toilet", "plant", "television", "refrigerator", "sink", "bathtub")
PRECISION = 0.8
"""The operating threshold is the lowest at which the classes' mean precision reaches this."""
MATCH_IOU = 0.5


@dataclass(frozen=True)
class Judged:
    """Detections that count: `score`, `right` or not, `label`; `objects` of each class."""

    score: NDArray[np.float64]
    right: NDArray[np.bool_]
    label: NDArray[np.int64]
    objects: NDArray[np.int64]


def read_coco(directory: Path) -> dict[str, Any]:
    """The annotations of a directory of frames. Raises ModelError."""
    path = directory / "annotations.json"
    try:
        table: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ModelError(
            f"{path}: not readable ({error}); make it with `hil-sim frames`"
        ) from error
    return table


def run(
    detector: Detector, table: dict[str, Any], directory: Path, rooms: tuple[str, ...]
) -> tuple[list[RawDetections], float]:
    """Detections of every image, in the table's order, and the share of rooms named rightly."""
    found, right, known = [], 0, 0
    for image in tqdm(table["images"], desc="frames", disable=None):
        bgr = cv2.imread(str(directory / "images" / image["file_name"]))
        if bgr is None:
            bgr = cv2.imread(str(directory / image["file_name"]))
        if bgr is None:
            raise ModelError(f"{directory}: image {image['file_name']} cannot be read")
        seen = detector.detect(np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8))
        found.append(seen)
        if len(seen.rooms) and image.get("room") in rooms:
            known += 1
            right += rooms[int(seen.rooms.argmax())] == image["room"]
    return found, right / max(known, 1)


def average_precision(table: dict[str, Any], found: list[RawDetections]) -> dict[str, float]:
    """AP at IoU 0.5 of every category that occurs, by pycocotools."""
    from pycocotools.coco import COCO
    from pycocotools.cocoeval import COCOeval

    results = [
        {
            "image_id": image["id"],
            "category_id": table["categories"][int(label)]["id"],
            "bbox": [float(b[0]), float(b[1]), float(b[2] - b[0]), float(b[3] - b[1])],
            "score": float(score),
        }
        for image, seen in zip(table["images"], found, strict=True)
        for b, score, label in zip(seen.boxes_px, seen.scores, seen.labels, strict=True)
    ]
    if not results:
        return {c["name"]: 0.0 for c in table["categories"]}
    with contextlib.redirect_stdout(io.StringIO()):
        truth = COCO()
        truth.dataset = table
        truth.createIndex()
        judge = COCOeval(truth, truth.loadRes(results), "bbox")
        judge.params.iouThrs = np.array([MATCH_IOU])
        judge.params.catIds = [c["id"] for c in table["categories"]]
        judge.evaluate()
        judge.accumulate()
    precision = judge.eval["precision"][0, :, :, 0, -1]  # recall levels x categories
    return {
        category["name"]: float(precision[:, k].mean())
        for k, category in enumerate(table["categories"])
        if (precision[:, k] > -1).all()
    }


def judge_all(table: dict[str, Any], found: list[RawDetections]) -> Judged:
    """Match detections with objects, best first; what covers an ignored object is left out."""
    index = {c["id"]: k for k, c in enumerate(table["categories"])}
    by_image: dict[int, list[dict[str, Any]]] = {}
    for mark in table["annotations"]:
        by_image.setdefault(mark["image_id"], []).append(mark)
    scores, rights, labels = [], [], []
    objects = np.zeros(len(index), np.int64)
    for image, seen in zip(table["images"], found, strict=True):
        marks = by_image.get(image["id"], [])
        boxes = np.array([m["bbox"] for m in marks], np.float32).reshape(-1, 4)
        boxes[:, 2:] += boxes[:, :2]
        kinds = np.array([index[m["category_id"]] for m in marks], np.int64)
        crowd = np.array([bool(m.get("iscrowd")) for m in marks], np.bool_)
        np.add.at(objects, kinds[~crowd], 1)
        verdicts = _judge(seen, boxes, kinds, crowd)
        for k, verdict in enumerate(verdicts):
            if verdict is not None:
                scores.append(float(seen.scores[k]))
                rights.append(verdict)
                labels.append(int(seen.labels[k]))
    return Judged(np.array(scores), np.array(rights, np.bool_), np.array(labels, np.int64), objects)


def _judge(
    seen: RawDetections,
    boxes: NDArray[np.float32],
    kinds: NDArray[np.int64],
    crowd: NDArray[np.bool_],
) -> list[bool | None]:
    iou = pairwise_iou(seen.boxes_px, boxes)
    taken = np.zeros(len(boxes), np.bool_)
    verdicts: list[bool | None] = []
    for k in range(len(seen.scores)):
        same = kinds == seen.labels[k]
        free = np.where(same & ~crowd & ~taken, iou[k], 0.0)
        if len(free) and free.max() >= MATCH_IOU:
            taken[int(free.argmax())] = True
            verdicts.append(True)
        elif len(free) and np.where(same & crowd, iou[k], 0.0).max() >= 0.3:
            verdicts.append(None)
        else:
            verdicts.append(False)
    return verdicts


def fit_calibration(judged: Judged) -> tuple[float, float]:
    """Gain and shift of a logistic fit of `right` on the score's log odds (Platt)."""
    x = _log_odds(judged.score)
    design = np.stack((x, np.ones_like(x)), 1)
    w = np.array([1.0, 0.0])
    for _ in range(50):
        p = 1 / (1 + np.exp(-design @ w))
        gradient = design.T @ (judged.right - p) - 1e-3 * (w - [1, 0])
        hessian = (design * (p * (1 - p))[:, None]).T @ design + 1e-3 * np.eye(2)
        w = w + np.linalg.solve(hessian, gradient)
    return float(w[0]), float(w[1])


def calibration_error(judged: Judged, bins: int = 10) -> float:
    """Mean gap of score and share right over score bins, weighted by their size."""
    which = np.minimum((judged.score * bins).astype(int), bins - 1)
    gaps = [
        abs(judged.score[which == b].mean() - judged.right[which == b].mean()) * (which == b).sum()
        for b in range(bins)
        if (which == b).any()
    ]
    return float(sum(gaps) / max(len(which), 1))


def at_threshold(judged: Judged, label: int, threshold: float) -> tuple[float, float]:
    """Precision and recall of one class at a threshold."""
    mine = (judged.label == label) & (judged.score >= threshold)
    right = int((judged.right & mine).sum())
    return right / max(int(mine.sum()), 1), right / max(int(judged.objects[label]), 1)


def choose_threshold(judged: Judged, labels: list[int]) -> float:
    """Lowest score, in steps of 0.01, at which mean precision over the classes is PRECISION."""
    for threshold in np.arange(0.1, 0.9, 0.01):
        if np.mean([at_threshold(judged, k, float(threshold))[0] for k in labels]) >= PRECISION:
            return round(float(threshold), 2)
    return 0.9


def measure(detector: Detector, directory: Path) -> dict[str, Any]:
    """Everything this program prints."""
    table = read_coco(directory)
    words = load_vocabulary()
    known = {names[0]: names for names in words.objects}
    categories = [c["name"] for c in table["categories"]]
    detector.set_vocabulary([known.get(c, (c,)) for c in categories], words.rooms)
    found, rooms = run(detector, table, directory, words.rooms)
    judged = judge_all(table, found)
    goals = [k for k, c in enumerate(categories) if c in GOALS and judged.objects[k]]
    threshold = choose_threshold(judged, goals)
    gain, shift = fit_calibration(judged)
    precision = average_precision(table, found)
    rows = {}
    for k, c in enumerate(categories):
        if c in precision:
            p, r = at_threshold(judged, k, threshold)
            figures = {"ap50": precision[c], "precision": p, "recall": r}
            rows[c] = {**figures, "objects": int(judged.objects[k])}
    return {
        "frames": len(table["images"]),
        "map50": float(np.mean(list(precision.values()))),
        "room_top1": rooms,
        "threshold": threshold,
        "calibration_error": calibration_error(judged),
        "refit": {"gain": gain, "shift": shift},
        "classes": rows,
    }


def table_of(report: dict[str, Any]) -> str:
    """The report as text, also what the model card holds."""
    lines = [
        f"frames {report['frames']}  mAP50 {report['map50']:.3f}  "
        f"room top-1 {report['room_top1']:.3f}  "
        f"calibration error {report['calibration_error']:.3f}",
        f"threshold {report['threshold']:.2f} (mean precision of goal classes >= {PRECISION})",
        f"{'class':16} {'objects':>7} {'AP50':>6} {'precision':>9} {'recall':>6}",
    ]
    for name, row in sorted(report["classes"].items(), key=lambda item: -item[1]["ap50"]):
        lines.append(
            f"{name:16} {row['objects']:7d} {row['ap50']:6.3f} "
            f"{row['precision']:9.3f} {row['recall']:6.3f}"
        )
    return "\n".join(lines)


def _log_odds(p: NDArray[np.float64]) -> NDArray[np.float64]:
    clipped = np.clip(p, 1e-6, 1 - 1e-6)
    odds: NDArray[np.float64] = np.log(clipped / (1 - clipped))
    return odds


@click.command(epilog="Example:  python -m models.evaluate --data frames/val")
@click.option("--data", type=click.Path(path_type=Path), required=True, help="Frames to judge on.")
@click.option(
    "--detector", type=click.Path(path_type=Path), help="ONNX file; default: the project's."
)
@click.option("--threads", default=2, show_default=True)
@click.option(
    "--json", "json_file", type=click.Path(path_type=Path), help="Write the figures here."
)
def main(data: Path, detector: Path | None, threads: int, json_file: Path | None) -> None:
    """Measure a detector on labelled frames."""
    encoder = TextEncoder(store.fetch("minilm"))
    report = measure(
        open_detector(detector or store.fetch("rfnav-det"), "rfnav", encoder, threads), data
    )
    click.echo(table_of(report))
    refit = report["refit"]
    click.echo(f"calibration of these scores: gain {refit['gain']:.3f} shift {refit['shift']:.3f}")
    if json_file:
        json_file.write_text(json.dumps(report, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    try:
        main()
    except ModelError as error:
        print(f"models.evaluate: {error}", file=sys.stderr)
        raise SystemExit(2) from None
