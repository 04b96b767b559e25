"""How well a detector does on labelled frames, asked as the runtime asks it.

Average precision at IoU 0.5 by pycocotools, in groups; names that training never saw; what was held
out of training, with a second look; rooms; what scores are worth, and the threshold for "target
seen"; what a frame costs. Calibration and threshold are fitted on other frames than are reported.
"""

from pathlib import Path
from typing import Any

from models.detection.detector import OpenDetector, open_detector
from models.detection.second_look import SecondLook
from models.evaluation.asked import LookedFor, by_other_names, looked_at_twice
from models.evaluation.cost import measure_cost
from models.evaluation.measures import measure, tried
from models.evaluation.sheet import draw_sheet
from models.evaluation.truth import read_truth, read_words
from models.words.text_encoder import TextEncoder
from runtime.config import DetectorConfig
from runtime.perception.word_verdicts import by_default


def evaluate(
    detector: Path, second_look: Path, data: Path, dev: Path | None, encoder: TextEncoder,
    *, limit: int | None = None, threads: int = 2, cost: bool = True, synonyms: bool = True,
) -> dict[str, Any]:  # fmt: skip
    """The figures on the frames of `data`, on the first `limit`, with those of `dev` to fit on.
    Raises ModelFileError for files and frames that cannot be used."""
    words, truth = read_words(), read_truth(data, limit)
    fitting = read_truth(dev, limit) if dev else None
    opened = open_detector(detector, "auto", encoder, threads)
    second = SecondLook(second_look, encoder, threads)
    understood = by_default(encoder)

    def looked_for(text: str) -> LookedFor:
        goal = understood(text)
        return LookedFor(goal.names, goal.strange)

    trial = tried(opened, truth, fitting, words, encoder)
    report = measure(trial, words)
    if trial.looked is not None and synonyms:
        report |= by_other_names(trial, trial.looked, words, encoder, looked_for)
    if isinstance(opened, OpenDetector):
        looks = DetectorConfig().second_looks
        report["second_look"] = looked_at_twice(trial, opened, second, looks, words, looked_for)
    if cost:
        report["cost"] = measure_cost(detector, second_look)
    return report


def contact_sheet(
    detector: Path, data: Path, out: Path, encoder: TextEncoder,
    *, limit: int | None = None, threads: int = 2,
) -> None:  # fmt: skip
    """Draw what it detects on some of the frames."""
    opened = open_detector(detector, "auto", encoder, threads)
    draw_sheet(opened, read_truth(data, limit), read_words(), out)
