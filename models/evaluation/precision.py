"""Average precision at IoU 0.5 by pycocotools."""

import contextlib
import io
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from models.detection.detections import RawDetections
from models.evaluation.truth import FrameTruth

MATCH_IOU = 0.5
RESAMPLED = 500
LEVELS = np.linspace(0, 1, 101)
"""Of recall, over which precision is averaged."""


class _Column(NamedTuple):
    """Of one category, the surest first: `right` (N,), `image` (N,) of each detection that counts;
    `objects` (F,) of each image."""

    right: NDArray[np.bool_]
    image: NDArray[np.int64]
    objects: NDArray[np.int64]


class Precision:
    """One truth's index, made once."""

    def __init__(self, truth: FrameTruth) -> None:
        self._table = truth.table
        self._ids = [c["id"] for c in truth.table["categories"]]
        with contextlib.redirect_stdout(io.StringIO()):
            self._coco = COCO()
            self._coco.dataset = truth.table
            self._coco.createIndex()

    def average(self, found: Sequence[RawDetections], labels: Sequence[int]) -> dict[int, float]:
        """AP50 of those of these categories (indices) that occur in the truth."""
        order = sorted(set(labels))
        counted = self._counted() & set(order)
        judge = self._judge(found, order)
        if judge is None:
            return dict.fromkeys(sorted(counted), 0.0)
        with contextlib.redirect_stdout(io.StringIO()):
            judge.accumulate()
        precision = judge.eval["precision"][0, :, :, 0, -1]  # recall levels x categories
        return {k: float(precision[:, i].mean()) for i, k in enumerate(order) if k in counted}

    def intervals(
        self, found: Sequence[RawDetections], groups: Mapping[str, Sequence[int]]
    ) -> dict[str, tuple[float, float]]:
        """Of each group of categories (indices) the middle 95 % of their mean AP50 over RESAMPLED
        draws of as many frames, with replacement (bootstrap); NaN where none of them occurs."""
        order = sorted(self._counted() & {k for labels in groups.values() for k in labels})
        judge = self._judge(found, order) if order else None
        if judge is None:
            nothing = {name: 0.0 if set(g) & set(order) else np.nan for name, g in groups.items()}
            return {name: (value, value) for name, value in nothing.items()}
        images = {image["id"]: i for i, image in enumerate(self._table["images"])}
        judged: dict[int, list[dict[str, Any]]] = {k: [] for k in order}
        for one in filter(None, judge.evalImgs):
            judged[self._ids.index(one["category_id"])].append(one)
        columns = [_column(judged[k], images) for k in order]
        rng, size = np.random.default_rng(0), len(images)
        draws = (rng.integers(0, size, size) for _ in range(RESAMPLED))
        counts = [np.bincount(draw, minlength=size) for draw in draws]
        values = np.array([[_average(column, drawn) for column in columns] for drawn in counts])
        return {
            name: _middle(values[:, [i for i, k in enumerate(order) if k in labels]])
            for name, labels in groups.items()
        }

    def _judge(self, found: Sequence[RawDetections], order: list[int]) -> COCOeval | None:
        """Detections matched with the truth; None without any."""
        results = [row for label, row in self._results(found) if label in set(order)]
        if not results:
            return None
        with contextlib.redirect_stdout(io.StringIO()):
            judge = COCOeval(self._coco, self._coco.loadRes(results), "bbox")
            judge.params.iouThrs = np.array([MATCH_IOU])
            judge.params.catIds = [self._ids[k] for k in order]
            judge.params.areaRng, judge.params.areaRngLbl = [[0, 1e10]], ["all"]
            judge.evaluate()
        return judge

    def _counted(self) -> set[int]:
        index = {i: k for k, i in enumerate(self._ids)}
        notes = self._table["annotations"]
        return {index[n["category_id"]] for n in notes if not n.get("iscrowd")}

    def _results(self, found: Sequence[RawDetections]) -> list[tuple[int, dict[str, Any]]]:
        rows = []
        for image, seen in zip(self._table["images"], found, strict=True):
            for b, score, label in zip(seen.boxes_px, seen.scores, seen.labels, strict=True):
                box = [float(b[0]), float(b[1]), float(b[2] - b[0]), float(b[3] - b[1])]
                row = {"image_id": image["id"], "category_id": self._ids[int(label)]}
                rows.append((int(label), row | {"bbox": box, "score": float(score)}))
        return rows


def _middle(values: NDArray[np.float64]) -> tuple[float, float]:
    """(draws, categories), NaN of what a draw has not -> where the middle 95 % of means lie."""
    kept = values[np.isfinite(values).any(axis=1)]
    if not kept.size:
        return float("nan"), float("nan")
    low, high = np.percentile(np.nanmean(kept, axis=1), (2.5, 97.5))
    return float(low), float(high)


def _column(judged: list[dict[str, Any]], images: dict[int, int]) -> _Column:
    objects = np.zeros(len(images), np.int64)
    scores, right, where = [np.zeros(0)], [np.zeros(0, bool)], [np.zeros(0, np.int64)]
    for one in judged:
        at = images[one["image_id"]]
        objects[at] += int((~np.asarray(one["gtIgnore"], bool)).sum())
        counts = ~np.asarray(one["dtIgnore"][0], bool)
        scores.append(np.asarray(one["dtScores"], np.float64)[counts])
        right.append(np.asarray(one["dtMatches"][0])[counts] > 0)
        where.append(np.full(int(counts.sum()), at))
    order = np.argsort(-np.concatenate(scores), kind="mergesort")
    return _Column(np.concatenate(right)[order], np.concatenate(where)[order], objects)


def _average(column: _Column, drawn: NDArray[np.int64]) -> float:
    """AP50 where each frame counts as often as it was drawn; NaN without an object."""
    objects = int((column.objects * drawn).sum())
    if not objects:
        return float("nan")
    weight = drawn[column.image]
    hits = np.cumsum(weight * column.right)
    precision = hits / np.maximum(np.cumsum(weight), 1)
    best = np.maximum.accumulate(precision[::-1])[::-1]
    at = np.searchsorted(hits / objects, LEVELS, side="left")
    return float(np.append(best, 0.0)[at].mean())
