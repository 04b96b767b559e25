"""Everything `python -m runtime.perception.evaluation` prints, as figures."""

import functools
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from models.detection.detections import Detector, RawDetections
from models.detection.detector import OpenDetector
from models.detection.second_look import SecondLook
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
from models.evaluation.sightings import look_at_all, sightings
from models.evaluation.truth import GOALS, HM3D, ROBOTHOR, FrameTruth, NameLists
from runtime.perception.word_verdicts import as_runtime, looked_for
from models.words.text_encoder import TextEncoder

LEAST_OBJECTS, LEAST_AP = 5, 0.1
"""A synonym is compared where its category has as many objects and as much AP by its own name."""
CURVE = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)


def measure(
    detector: Detector, truth: FrameTruth, dev: FrameTruth | None, words: NameLists,
    encoder: TextEncoder, synonyms: bool = True, second: SecondLook | None = None,
) -> dict[str, Any]:  # fmt: skip
    """The report on `truth`; calibration and threshold come from `dev`, else from `truth`."""
    rooms = list(words.rooms)
    looked: Looked | None = None
    if isinstance(detector, OpenDetector):
        looked = look(detector, truth, encoder, rooms)
        found, likeliest = looked.found, looked.rooms
    else:
        found, likeliest = detect_all(detector, truth, rooms)
    fitted_on, tried = (truth, found) if dev is None else (dev, detect_all(detector, dev, rooms)[0])
    precision = Precision(truth)
    ap = precision.average(found, range(len(truth.categories)))
    gain, shift = fit_calibration(judge(fitted_on, tried))
    judged = judge(truth, found)
    settled = judged.recalibrated(gain, shift)
    threshold = choose_threshold(_goal_scores(fitted_on, tried, gain, shift))
    return {
        "frames": len(truth.marks),
        "fitted_on_other_frames": dev is not None,
        "groups": groups(truth, ap, words),
        "held_out": {
            truth.categories[k]: v for k, v in ap.items() if _is(truth, k, words.held_out)
        },
        "room_top1": room_accuracy(truth, likeliest, words.rooms),
        "room_top1_of_things": room_accuracy(truth, likeliest, words.rooms, things=True),
        "calibration_error": {
            "as the file has it": calibration_error(judged),
            "refitted": calibration_error(settled),
        },
        "calibration": _whole_calibration(detector, gain, shift),
        "threshold": threshold,
        "goals": seen_at(truth, found, settled, (gain, shift), threshold, words, ap),
        "curve": curve(truth, found, settled, (gain, shift)),
        "classes": {truth.categories[k]: _row(judged, k, v) for k, v in ap.items()},
        **(
            by_other_names(looked, precision, judged, ap, words, encoder)
            if looked is not None and synonyms
            else {"synonyms": {}, "asked": {}}
        ),
        "second_look": (
            looked_at_twice(detector, second, truth, words, precision, threshold, encoder)
            if isinstance(detector, OpenDetector) and second is not None
            else {}
        ),
    }


def looked_at_twice(
    detector: OpenDetector, second: SecondLook, truth: FrameTruth, words: NameLists,
    precision: Precision, threshold: float, encoder: TextEncoder,
) -> dict[str, Any]:  # fmt: skip
    """The categories held out of training, each as a goal as the runtime understands it: what is
    taken for a class that the detector knows is not looked at twice, and counts as not found."""
    understood = as_runtime(encoder)
    goals = {name: understood(name) for name in words.held_out}
    looked = look_at_all(detector, second, truth, words)
    strange = {name: looked_for(understood, name) for name, goal in goals.items() if goal.strange}
    told = sightings(looked, second, truth, words, strange)
    found = tuple(part.scored(second)[0] for part in told)
    held = [k for k in range(len(truth.categories)) if _is(truth, k, words.held_out)]
    ap, judged = precision.average(found, held), judge(truth, found)
    absent = {k: without(truth, [k]) for k in held}
    rows = {
        truth.categories[k]: _row(judged, k, ap[k])
        | {
            "as": goals[truth.categories[k]].name,
            "recall": at_threshold(judged, k, threshold)[1],
            "false_seen": false_seen(best_scores(found, k), absent[k], threshold),
        }
        for k in ap
    }
    return {
        "ap50": _mean([row["ap50"] for row in rows.values()]),
        "of": len(words.held_out),
        "calibration_error": calibration_error(judged),
        "false_seen": _mean([row["false_seen"] for row in rows.values()]),
        "categories": rows,
    }


def _is(truth: FrameTruth, label: int, names: Collection[str]) -> bool:
    return truth.categories[label] in names


def _row(judged: Judged, label: int, ap: float) -> dict[str, Any]:
    return {"ap50": ap, "objects": int(judged.objects[label])}


def _whole_calibration(detector: Detector, gain: float, shift: float) -> dict[str, float]:
    """Gain and shift for the file: its own, then those fitted on its scores."""
    if not isinstance(detector, OpenDetector):
        return {"gain": gain, "shift": shift}
    return {"gain": gain * detector.gain, "shift": gain * detector.shift + shift}


def groups(
    truth: FrameTruth, ap: dict[int, float], words: NameLists
) -> dict[str, dict[str, float]]:
    """Mean AP50 of each group over those of its categories that occur."""
    sets = {"HM3D goals": HM3D, "RoboTHOR goals": ROBOTHOR, "trained": words.trained}
    sets["held out"] = words.held_out
    out: dict[str, dict[str, float]] = {}
    for name, members in sets.items():
        values = [v for k, v in ap.items() if _is(truth, k, members)]
        mean = float(np.mean(values)) if values else float("nan")
        out[name] = {"ap50": mean, "categories": len(values), "of": len(members)}
    return out


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


def seen_at(
    truth: FrameTruth, found: Sequence[RawDetections], settled: Judged, fit: tuple[float, float],
    threshold: float, words: NameLists, ap: dict[int, float],
) -> dict[str, dict[str, float]]:  # fmt: skip
    """Each goal class at the threshold; `apart`: frames with a category near to it left out."""
    labels = [k for k, c in enumerate(truth.categories) if c in GOALS]
    out = {}
    for k, (scores, absent) in zip(labels, _goal_scores(truth, found, *fit), strict=True):
        name = truth.categories[k]
        close = [j for j, c in enumerate(truth.categories) if c in words.near.get(name, ())]
        p, r = at_threshold(settled, k, threshold)
        out[name] = {
            "objects": int(settled.objects[k]),
            "ap50": ap.get(k, float("nan")),
            "precision": p,
            "recall": r,
            "false_seen": false_seen(scores, absent, threshold),
            "false_seen_apart": false_seen(scores, absent & without(truth, close), threshold),
            "frames_without": int(absent.sum()),
        }
    return out


def curve(
    truth: FrameTruth, found: Sequence[RawDetections], settled: Judged, fit: tuple[float, float]
) -> list[dict[str, float]]:
    """False sightings and recall, averaged over the goal classes that occur, by threshold."""
    labels = [k for k, c in enumerate(truth.categories) if c in GOALS]
    goals = _goal_scores(truth, found, *fit)
    rows = []
    for t in CURVE:
        false = [false_seen(s, a, t) for s, a in goals]
        recall = [at_threshold(settled, k, t)[1] for k in labels if settled.objects[k]]
        rows.append({"threshold": t, "false_seen": _mean(false), "recall": _mean(recall)})
    return rows


def by_other_names(
    looked: Looked, precision: Precision, judged: Judged, ap: dict[int, float], words: NameLists,
    encoder: TextEncoder,
) -> dict[str, Any]:  # fmt: skip
    """AP of a category asked for by a name that training never saw, over AP by its own name: of the
    `synonyms` alone and as the runtime understands them, of the names `asked` only so."""

    @functools.cache  # many names are understood as the same class
    def average(label: int, texts: tuple[str, ...]) -> float:
        return precision.average(looked.with_names(label, encoder.embed(texts)), [label])[label]

    labels = {
        looked.categories[k]: k
        for k, own in ap.items()
        if judged.objects[k] >= LEAST_OBJECTS and own >= LEAST_AP
    }
    understood = as_runtime(encoder)

    def rows(others: Mapping[str, Sequence[str]], alone: bool) -> Iterator[dict[str, Any]]:
        for name, label in labels.items():
            for other in others.get(name, ()):
                texts = looked_for(understood, other)
                row = {"category": name, "synonym": other, "own": ap[label], "as": texts[0]}
                row |= _shares("understood_", average(label, texts), ap[label])
                yield row | (_shares("", average(label, (other,)), ap[label]) if alone else {})

    synonyms, asked = list(rows(words.unseen, True)), list(rows(words.asked, False))
    return {
        "synonyms": {
            **_means(synonyms, "ratio", ""),
            **_means(synonyms, "understood_ratio", "understood_"),
            "left_out": sum(map(len, words.unseen.values())) - len(synonyms),
            "rows": sorted(synonyms, key=lambda r: r["ratio"]),
        },
        "asked": {
            **_means(asked, "understood_ratio", "understood_"),
            "left_out": sum(map(len, words.asked.values())) - len(asked),
            "rows": sorted(asked, key=lambda r: r["understood_ratio"]),
        },
    }


def _shares(prefix: str, average: float, own: float) -> dict[str, float]:
    return {f"{prefix}ap50": average, f"{prefix}ratio": average / own}


def _means(rows: Sequence[dict[str, Any]], key: str, prefix: str) -> dict[str, float]:
    goals = [r[key] for r in rows if r["category"] in GOALS]
    return {f"{prefix}mean": _mean([r[key] for r in rows]), f"{prefix}mean_of_goals": _mean(goals)}


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")
