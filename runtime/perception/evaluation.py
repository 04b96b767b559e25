"""How well a detector does on labelled frames, asked as the runtime asks it.

Average precision at IoU 0.5 by pycocotools, in groups; names that training never saw; what was held
out of training, with a second look; rooms; what scores are worth, and the threshold for "target
seen"; what a frame costs. Calibration and threshold are fitted on other frames than are reported.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from models.detection.detector import Detector, OpenDetector
from models.detection.domain import DomainSetting
from models.detection.ensemble import DetectorEnsemble, open_detectors
from models.detection.second_look import SecondLook
from models.evaluation.asked import LookedFor, by_other_names, looked_at_twice
from models.evaluation.cost import measure_cost
from models.evaluation.measures import measure, tried
from models.evaluation.sheet import draw_sheet
from models.evaluation.truth import read_truth, read_words
from models.words.text_encoder import TextEncoder
from runtime.config import DetectorConfig, ModelsConfig
from runtime.perception.word_verdicts import by_default


def opened(
    detectors: Sequence[str], encoder: TextEncoder, threads: int, domain: DomainSetting = "auto"
) -> Detector:
    """A detector by its name or file; several as one, all of which look at every frame: frames to
    judge on are not of one run."""
    found = open_detectors(detectors, encoder, threads)
    if len(found) == 1:
        return next(iter(found.values()))
    return DetectorEnsemble(found, domain)


def evaluate(
    detectors: Sequence[str], second_look: Path, data: Path, dev: Path | None,
    encoder: TextEncoder, *, limit: int | None = None, threads: int = 2, cost: bool = True,
    synonyms: bool = True, domain: DomainSetting = "auto",
) -> dict[str, Any]:  # fmt: skip
    """The figures on the frames of `data`, on the first `limit`, with those of `dev` to fit on.
    Names and second looks are judged of one detector alone. Raises ModelFileError for files and
    frames that cannot be used."""
    words, truth = read_words(), read_truth(data, limit)
    fitting = read_truth(dev, limit) if dev else None
    detector = opened(detectors, encoder, threads, domain)
    second = SecondLook(second_look, encoder, threads)
    understood = by_default(encoder)

    def looked_for(text: str) -> LookedFor:
        goal = understood(text)
        return LookedFor(goal.names, goal.strange)

    trial = tried(detector, truth, fitting, words, encoder)
    report = measure(trial, words)
    report["detectors"] = list(detectors)
    if isinstance(detector, DetectorEnsemble):
        report["domain"] = detector.domain.told()
    if trial.looked is not None and synonyms:
        report |= by_other_names(trial, trial.looked, words, encoder, looked_for)
    if isinstance(detector, OpenDetector) and truth.categories:
        looks = DetectorConfig().second_looks
        report["second_look"] = looked_at_twice(trial, detector, second, looks, words, looked_for)
    if cost:
        report["cost"] = measure_cost(detectors, second_look, ModelsConfig().others_every)
    return report


def contact_sheet(
    detectors: Sequence[str], data: Path, out: Path, encoder: TextEncoder,
    *, limit: int | None = None, threads: int = 2,
) -> None:  # fmt: skip
    """Draw what is detected on some of the frames."""
    draw_sheet(opened(detectors, encoder, threads), read_truth(data, limit), read_words(), out)
