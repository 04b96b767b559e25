"""What a score is worth: right or wrong, calibration, the threshold for "target seen"."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.detection.boxes import pairwise_iou
from models.detection.calibration import log_odds, sigmoid
from models.detection.detections import RawDetections
from models.evaluation.precision import MATCH_IOU
from models.evaluation.truth import FrameTruth, Marks

COVERED_IOU = 0.3
"""From which overlap with an ignored object of its class a detection is neither right nor wrong."""
FALSE_SEEN = 4.0
"""The operating threshold is the lowest with at most as many false "target seen" per 1,000 frames
that show no target: less than the 4.5 wanted, since it has to hold in other homes."""
PRIOR = 1.0
"""How many detections' worth a calibration is drawn to what it is: a few tell little."""
STEPS = np.round(np.arange(0.1, 1.0, 0.01), 2)

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Judged:
    """Detections that count: `score`, `right` or not, `label`; `objects` of each class."""

    score: Doubles
    right: NDArray[np.bool_]
    label: NDArray[np.int64]
    objects: NDArray[np.int64]

    def recalibrated(self, gain: float, shift: float) -> "Judged":
        """The same with each score's log odds times gain plus shift."""
        odds = np.clip(gain * log_odds(self.score) + shift, -30, 30)
        return Judged(sigmoid(odds), self.right, self.label, self.objects)


def judge(truth: FrameTruth, found: Sequence[RawDetections]) -> Judged:
    """Match detections with objects, best first; what covers an ignored object is left out."""
    scores: list[float] = []
    rights: list[bool] = []
    labels: list[int] = []
    objects = np.zeros(len(truth.categories), np.int64)
    for marks, seen in zip(truth.marks, found, strict=True):
        np.add.at(objects, marks.kinds[~marks.crowd], 1)
        for k, verdict in enumerate(verdicts(seen, marks)):
            if verdict is not None:
                scores.append(float(seen.scores[k]))
                rights.append(verdict)
                labels.append(int(seen.labels[k]))
    return Judged(np.array(scores), np.array(rights, np.bool_), np.array(labels, np.int64), objects)


def verdicts(seen: RawDetections, marks: Marks) -> list[bool | None]:
    """Of one frame's detections, best first: right, wrong, or None for what covers an ignored
    object."""
    iou = pairwise_iou(seen.boxes_px, marks.boxes)
    taken = np.zeros(len(marks.boxes), np.bool_)
    found: list[bool | None] = []
    for k in range(len(seen.scores)):
        same = marks.kinds == seen.labels[k]
        free = np.where(same & ~marks.crowd & ~taken, iou[k], 0.0)
        if len(free) and free.max() >= MATCH_IOU:
            taken[int(free.argmax())] = True
            found.append(True)
        elif len(free) and np.where(same & marks.crowd, iou[k], 0.0).max() >= COVERED_IOU:
            found.append(None)
        else:
            found.append(False)
    return found


def fit_calibration(judged: Judged) -> tuple[float, float]:
    """Gain and shift of a logistic fit of `right` on the score's log odds (Platt 1999)."""
    x = log_odds(judged.score)
    gain, shift = fit_odds(x[:, None], judged.right, np.array([1.0, 0.0]))
    return float(gain), float(shift)


def fit_odds(evidence: Doubles, right: NDArray[np.bool_], start: Doubles) -> Doubles:
    """(N, E) evidence, (N,) -> (E + 1,) weights of a logistic fit, the constant last; with little
    to go by they stay near `start`."""
    design = np.concatenate((evidence, np.ones((len(evidence), 1))), axis=1)

    def cost(w: Doubles) -> float:
        odds = design @ w
        wrong = np.logaddexp(0.0, np.where(right, -odds, odds)).sum()
        return float(wrong + PRIOR / 2 * ((w - start) ** 2).sum())

    w = start
    for _ in range(50):
        p = sigmoid(np.clip(design @ w, -30, 30))
        gradient = design.T @ (p - right) + PRIOR * (w - start)
        hessian = (design * (p * (1 - p))[:, None]).T @ design + PRIOR * np.eye(len(w))
        step = np.linalg.solve(hessian, gradient)
        while cost(w - step) > cost(w) and np.abs(step).max() > 1e-9:  # Newton may overshoot
            step = step / 2
        w = w - step
    return w


def calibration_error(judged: Judged, bins: int = 10) -> float:
    """Mean gap of score and share right over score bins, weighted by their size (ECE)."""
    which = np.minimum((judged.score * bins).astype(int), bins - 1)
    gaps = [
        abs(judged.score[which == b].mean() - judged.right[which == b].mean()) * (which == b).sum()
        for b in range(bins)
        if (which == b).any()
    ]
    return float(sum(gaps) / max(len(which), 1))


def at_threshold(judged: Judged, label: int, threshold: float) -> tuple[float, float]:
    """Precision (NaN without a detection) and recall of one class at a threshold."""
    mine = (judged.label == label) & (judged.score >= threshold)
    right, count = int((judged.right & mine).sum()), int(mine.sum())
    return right / count if count else float("nan"), right / max(int(judged.objects[label]), 1)


def best_scores(found: Sequence[RawDetections], label: int) -> Doubles:
    """The best score of a class in each frame, 0 where there is none."""
    return np.array([float(f.scores[f.labels == label].max(initial=0.0)) for f in found])


def without(truth: FrameTruth, labels: Collection[int]) -> NDArray[np.bool_]:
    """Frames in which nothing of these classes is in view, ignored objects included."""
    wanted = sorted(labels)
    return np.array([not np.isin(marks.kinds, wanted).any() for marks in truth.marks])


def false_seen(scores: Doubles, absent: NDArray[np.bool_], threshold: float) -> float:
    """False "seen" per 1,000 frames without the class; `scores`, `absent` (F,)."""
    return 1000.0 * float((scores[absent] >= threshold).mean()) if absent.any() else 0.0


def choose_threshold(goals: Sequence[tuple[Doubles, NDArray[np.bool_]]]) -> float:
    """The lowest score at which false sightings, averaged over goals, are FALSE_SEEN at most; the
    highest of STEPS without goals."""
    for threshold in STEPS if goals else ():
        if np.mean([false_seen(s, a, float(threshold)) for s, a in goals]) <= FALSE_SEEN:
            return float(threshold)
    return float(STEPS[-1])
