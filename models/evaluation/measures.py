"""Figures of merit of a detector that is asked by its own categories' names."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from models.detection.detections import Detector, RawDetections
from models.detection.detector import OpenDetector
from models.detection.fixed_list import FixedListDetector
from models.detection.prompted import PromptedDetector
from models.evaluation.judged import (
    Judged,
    at_threshold,
    best_scores,
    calibration_error,
    choose_threshold,
    false_seen,
    fit_calibration,
    judge,
    without,
)
from models.evaluation.naming import Looked, detect_all, look
from models.evaluation.precision import Precision
from models.evaluation.recall import recall_by_size
from models.evaluation.truth import GOALS, HM3D, HOUSEHOLD, ROBOTHOR, FrameTruth, NameLists
from models.words.text_encoder import TextEncoder

REPORTED = (0.2, 0.25, 0.3, 0.35, 0.4)
"""Calibrated scores from which on a sighting may be called reported."""
CURVE = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)


@dataclass(frozen=True)
class Trial:
    """A detector tried on labelled frames, each of which it has seen once: `found` in each, and the
    index of its likeliest room. `looked`: of an open detector, what it saw before that was named.
    `ap` (AP50) by index of the category, of those that occur."""

    detector: Detector
    truth: FrameTruth
    looked: Looked | None
    found: Sequence[RawDetections]
    rooms: Sequence[int]
    precision: Precision
    ap: dict[int, float]
    judged: Judged
    calibration: tuple[float, float]  # gain and shift
    threshold: float  # for "target seen", of a calibrated score
    fitted_on_other_frames: bool

    @property
    def settled(self) -> Judged:
        """Calibrated."""
        return self.judged.recalibrated(*self.calibration)


def tried(
    detector: Detector, truth: FrameTruth, dev: FrameTruth | None, words: NameLists,
    encoder: TextEncoder,
) -> Trial:  # fmt: skip
    """Try a detector on `truth`; calibration and threshold come from `dev`, else from `truth`."""
    rooms = list(words.rooms)
    looked: Looked | None = None
    if isinstance(detector, OpenDetector):
        looked = look(detector, truth, encoder, rooms)
        found, likeliest = looked.found, looked.rooms
    else:
        found, likeliest = detect_all(detector, truth, rooms)
    fitted_on, seen = (truth, found) if dev is None else (dev, detect_all(detector, dev, rooms)[0])
    precision = Precision(truth)
    fit = fit_calibration(judge(fitted_on, seen))
    return Trial(
        detector,
        truth,
        looked,
        found,
        likeliest,
        precision,
        precision.average(found, range(len(truth.categories))),
        judge(truth, found),
        fit,
        choose_threshold(_goal_scores(fitted_on, seen, *fit)),
        fitted_on_other_frames=dev is not None,
    )


def measure(trial: Trial, words: NameLists) -> dict[str, Any]:
    """The report on a trial, without what other names, second looks or time cost."""
    truth, ap, names = trial.truth, trial.ap, trial.truth.categories
    judged, settled = trial.judged, trial.settled
    return {
        "frames": len(truth.marks),
        "fitted_on_other_frames": trial.fitted_on_other_frames,
        "groups": groups(trial, words),
        "reported": [reported(trial, score) for score in REPORTED],
        "held_out": {names[k]: v for k, v in ap.items() if names[k] in words.held_out},
        "room_top1": room_accuracy(truth, trial.rooms, words.rooms),
        "room_top1_of_things": room_accuracy(truth, trial.rooms, words.rooms, things=True),
        "calibration_error": {
            "as the file has it": calibration_error(judged),
            "refitted": calibration_error(settled),
        },
        "calibration": whole_calibration(trial.detector, *trial.calibration),
        "threshold": trial.threshold,
        "goals": seen_at(trial, words),
        "curve": curve(trial),
        "by_size": recall_by_size(truth, trial.found),
        "classes": {names[k]: class_row(judged, k, v) for k, v in ap.items()},
        "synonyms": {},
        "asked": {},
        "second_look": {},
    }


def class_row(judged: Judged, label: int, ap: float) -> dict[str, Any]:
    """A category's AP50 and how many objects it has."""
    return {"ap50": ap, "objects": int(judged.objects[label])}


def whole_calibration(detector: Detector, gain: float, shift: float) -> dict[str, float]:
    """Gain and shift for the file: its own, then those fitted on its scores."""
    if not isinstance(detector, OpenDetector | FixedListDetector | PromptedDetector):
        return {"gain": gain, "shift": shift}
    return {"gain": gain * detector.gain, "shift": gain * detector.shift + shift}


def groups(trial: Trial, words: NameLists) -> dict[str, dict[str, Any]]:
    """Mean AP50 of each group over those of its categories that occur, with its interval."""
    names = trial.truth.categories
    sets = {"HM3D goals": HM3D, "RoboTHOR goals": ROBOTHOR, "household": HOUSEHOLD}
    sets |= {"trained": tuple(words.trained), "held out": words.held_out}
    shown = {name: [k for k in trial.ap if names[k] in of] for name, of in sets.items()}
    intervals = trial.precision.intervals(trial.found, shown)
    return {
        name: {
            "ap50": mean([trial.ap[k] for k in labels]),
            "interval": intervals[name],
            "categories": len(labels),
            "of": len(sets[name]),
        }
        for name, labels in shown.items()
    }


def reported(trial: Trial, score: float) -> dict[str, float]:
    """What a robot hears of HM3D's goals from a score on, as it is: the share of the frames with a
    goal in view (each goal for itself) in which it is reported, and false sightings."""
    truth, shown, false = trial.truth, [np.zeros(0, bool)], []
    for k, category in enumerate(truth.categories):
        if category in HM3D:
            said, absent = best_scores(trial.found, k) >= score, without(truth, [k])
            asked = np.array([(m.kinds[~m.crowd] == k).any() for m in truth.marks])
            shown.append(said[asked])
            false.append(false_seen(said.astype(np.float64), absent, 1.0))
    return {
        "share": mean(np.concatenate(shown).tolist()),
        "views": int(sum(map(len, shown))),
        "false_seen": mean(false),
        "score": score,
    }


def room_accuracy(
    truth: FrameTruth, likeliest: Sequence[int], rooms: Sequence[str], things: bool = False
) -> float:
    """Share of the views of a known room type that are named rightly, of all or of those in which
    an object counts (a blank wall is of any room); NaN without any."""
    right = [
        k >= 0 and rooms[k] == image["room"]
        for image, marks, k in zip(truth.table["images"], truth.marks, likeliest, strict=True)
        if image.get("room") in rooms and not (things and marks.crowd.all())
    ]
    return float(np.mean(right)) if right else float("nan")


def _goal_scores(
    truth: FrameTruth, found: Sequence[RawDetections], gain: float, shift: float
) -> list[tuple[Any, Any]]:
    """Recalibrated best scores and absence of every goal class, over the frames."""
    pairs = []
    for k, category in enumerate(truth.categories):
        if category in GOALS:
            scores = Judged(best_scores(found, k), *_EMPTY).recalibrated(gain, shift).score
            pairs.append((scores, without(truth, [k])))
    return pairs


_EMPTY = (np.zeros(0, bool), np.zeros(0, np.int64), np.zeros(0, np.int64))


def seen_at(trial: Trial, words: NameLists) -> dict[str, dict[str, float]]:
    """Each goal class at the threshold; `apart`: frames with a category near to it left out."""
    truth, settled, threshold = trial.truth, trial.settled, trial.threshold
    labels = [k for k, c in enumerate(truth.categories) if c in GOALS]
    out = {}
    goals = _goal_scores(truth, trial.found, *trial.calibration)
    for k, (scores, absent) in zip(labels, goals, strict=True):
        name = truth.categories[k]
        close = [j for j, c in enumerate(truth.categories) if c in words.near.get(name, ())]
        p, r = at_threshold(settled, k, threshold)
        out[name] = {
            "objects": int(settled.objects[k]),
            "ap50": trial.ap.get(k, float("nan")),
            "precision": p,
            "recall": r,
            "false_seen": false_seen(scores, absent, threshold),
            "false_seen_apart": false_seen(scores, absent & without(truth, close), threshold),
            "frames_without": int(absent.sum()),
        }
    return out


def curve(trial: Trial) -> list[dict[str, float]]:
    """False sightings and recall, averaged over the goal classes that occur, by threshold."""
    truth, settled = trial.truth, trial.settled
    labels = [k for k, c in enumerate(truth.categories) if c in GOALS]
    goals = _goal_scores(truth, trial.found, *trial.calibration)
    rows = []
    for t in CURVE:
        false = [false_seen(s, a, t) for s, a in goals]
        recall = [at_threshold(settled, k, t)[1] for k in labels if settled.objects[k]]
        rows.append({"threshold": t, "false_seen": mean(false), "recall": mean(recall)})
    return rows


def mean(values: Sequence[float]) -> float:
    """NaN of none."""
    return float(np.mean(values)) if values else float("nan")
