"""What a detector is worth when it is asked for things as people call them: by names that training
never saw, and for what was held out of training, with a second look. What a name is looked for as
is the caller's to say: how the runtime understands a goal is not known here."""

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from models.detection.detector import OpenDetector
from models.detection.second_look import SecondLook
from models.evaluation.judged import (
    at_threshold,
    best_scores,
    calibration_error,
    false_seen,
    judge,
    without,
)
from models.evaluation.measures import Trial, class_row, mean
from models.evaluation.naming import Looked
from models.evaluation.sightings import look_at_all, sightings
from models.evaluation.truth import GOALS, NameLists
from models.words.text_encoder import TextEncoder

LEAST_OBJECTS, LEAST_AP = 5, 0.1
"""A synonym is compared where its category has as many objects and as much AP by its own name."""


class LookedFor(NamedTuple):
    """What a goal is looked for as: the `names` of its class, canonical first; `strange`: a class
    of its own, unlike any that is known."""

    names: tuple[str, ...]
    strange: bool


Understand = Callable[[str], LookedFor]


def looked_at_twice(
    trial: Trial, detector: OpenDetector, second: SecondLook, looks: int, words: NameLists,
    understand: Understand,
) -> dict[str, Any]:  # fmt: skip
    """The categories held out of training, each as a goal that is understood so, with `looks`
    places of a frame looked at again: what is taken for a class that the detector knows is not
    looked at twice, and counts as not found."""
    truth = trial.truth
    goals = {name: understand(name) for name in words.held_out}
    looked = look_at_all(detector, second, truth, words)
    strange = {name: goal.names for name, goal in goals.items() if goal.strange}
    told = sightings(looked, second, truth, words, strange, looks)
    found = tuple(part.scored(second)[0] for part in told)
    held = [k for k, name in enumerate(truth.categories) if name in words.held_out]
    ap, judged = trial.precision.average(found, held), judge(truth, found)
    absent = {k: without(truth, [k]) for k in held}
    rows = {
        truth.categories[k]: class_row(judged, k, ap[k])
        | {
            "as": goals[truth.categories[k]].names[0],
            "recall": at_threshold(judged, k, trial.threshold)[1],
            "false_seen": false_seen(best_scores(found, k), absent[k], trial.threshold),
        }
        for k in ap
    }
    return {
        "ap50": mean([row["ap50"] for row in rows.values()]),
        "of": len(words.held_out),
        "calibration_error": calibration_error(judged),
        "false_seen": mean([row["false_seen"] for row in rows.values()]),
        "categories": rows,
    }


def by_other_names(
    trial: Trial, looked: Looked, words: NameLists, encoder: TextEncoder, understand: Understand
) -> dict[str, Any]:
    """AP of a category asked for by a name that training never saw, over AP by its own name: of the
    `synonyms` alone and as they are understood, of the names `asked` only so."""
    ap, judged = trial.ap, trial.judged

    @functools.cache  # many names are understood as the same class
    def average(label: int, texts: tuple[str, ...]) -> float:
        found = looked.with_names(label, encoder.embed(texts))
        return trial.precision.average(found, [label])[label]

    labels = {
        looked.categories[k]: k
        for k, own in ap.items()
        if judged.objects[k] >= LEAST_OBJECTS and own >= LEAST_AP
    }

    def rows(others: Mapping[str, Sequence[str]], alone: bool) -> Iterator[dict[str, Any]]:
        for name, label in labels.items():
            for other in others.get(name, ()):
                texts = understand(other).names
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
    return {f"{prefix}mean": mean([r[key] for r in rows]), f"{prefix}mean_of_goals": mean(goals)}
