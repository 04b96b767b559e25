"""Average precision at IoU 0.5 by pycocotools."""

import contextlib
import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from models.detection.detections import RawDetections
from models.evaluation.truth import FrameTruth

MATCH_IOU = 0.5


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
        wanted = set(labels)
        results = [row for row in self._results(found) if row[0] in wanted]
        counted = self._counted() & wanted
        if not results:
            return dict.fromkeys(sorted(counted), 0.0)
        order = sorted(wanted)
        with contextlib.redirect_stdout(io.StringIO()):
            judge = COCOeval(self._coco, self._coco.loadRes([row for _, row in results]), "bbox")
            judge.params.iouThrs = np.array([MATCH_IOU])
            judge.params.catIds = [self._ids[k] for k in order]
            judge.params.areaRng, judge.params.areaRngLbl = [[0, 1e10]], ["all"]
            judge.evaluate()
            judge.accumulate()
        precision = judge.eval["precision"][0, :, :, 0, -1]  # recall levels x categories
        return {k: float(precision[:, i].mean()) for i, k in enumerate(order) if k in counted}

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
