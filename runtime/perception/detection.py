"""What is in an image: the detectors, and a second look at what it has no word for."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from models.detection.ensemble import DetectorEnsemble, open_detectors
from models.detection.second_look import SecondLook, Sought
from models.detection.trial import Limits, tried
from models.store import manifest
from models.words.class_names import ClassText
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import Vocabulary
from runtime.config import Config, DetectorConfig
from runtime.core.objects.surfaces import Window
from runtime.core.types import F32, F64, U8, Detections
from runtime.perception.goal_words import Goal

MIN_SCORE = 0.2  # weaker detections are not looked at
Classes = tuple[tuple[str, ...], ...]


class SeekingDetector:
    """The models that see, loaded, and what they look for. One thread at a time may use them.
    Raises models.errors.ModelFileError when one cannot be loaded."""

    def __init__(self, config: Config, encoder: TextEncoder, words: Vocabulary) -> None:
        models = config.models
        self._encoder, self._rooms = encoder, words.rooms
        for name in filter(manifest.by_path, models.detectors):  # nobody has tried it yet
            tried(Path(name), Limits())
        found = open_detectors(models.detectors, encoder, models.threads)
        self._all = DetectorEnsemble(found, models.domain, models.others_every)
        self._all.remember(config.detector.memo_frames)
        self._all.find_by(config.detector.clip_way)
        # Embedding hundreds of names takes a second: not while somebody waits for a vote.
        self._all.set_vocabulary(words.objects, words.rooms)
        self._second: SecondLook | None = None
        if models.second_look and self._all.open_detector is not None:
            self._second = SecondLook(manifest.located(models.second_look), encoder, models.threads)
        self._classes: Classes = words.objects
        self._small = words.small

    def seek(self, goal: Goal, config: Config) -> str:
        """Look for a goal from now on; what to say about how well it can be seen, or "". When it
        raises, what was looked for before still is."""
        again, how = self._twice(goal, config.detector)
        self._all.find_by(config.detector.clip_way)
        self._all.set_vocabulary(goal.classes, self._rooms)
        self._all.look_for(goal.label)
        self._all.remember(config.detector.memo_frames)
        self._all.begin()
        self._all.again, self._classes = again, goal.classes
        self._all.closer = goal.name in self._small
        return _told(self._all.capabilities, goal.name) + how

    def _twice(
        self, goal: Goal, cfg: DetectorConfig
    ) -> tuple[tuple[SecondLook, Sought] | None, str]:
        """What the detector has no word for is looked at by a classifier that may have one; what to
        say about that."""
        second = self._second
        if not goal.strange or second is None or cfg.second_looks <= 0 or cfg.source != "model":
            return None, ""
        likeness = second.likeness(goal.names)
        if not likeness.any():
            return None, "; no picture is known of anything like it: it will hardly be recognised"
        like = second.names[int(likeness.argmax())]
        told = f"; what is strange is looked at twice, for: {like}"
        return (second, Sought(goal.label, likeness, cfg.second_looks)), told

    def detect(self, rgb: U8, window: Callable[[], Window | None] = lambda: None) -> Detections:
        """(H, W, 3) -> what is seen surely enough; `window`: where a closer look is worth it, asked
        for only when there is time for one."""
        raw = self._all.detect(rgb, window)
        keep = raw.scores >= MIN_SCORE
        return Detections(
            raw.boxes_px[keep],
            raw.scores[keep],
            raw.labels[keep],
            raw.embeddings[keep],
            raw.rooms,
            raw.scene,
            features=raw.features,
        )

    def likeness(self, embeddings: F32) -> F64:
        """(N, D) unit rows of things seen before -> (N, C): with what probability each is each of
        the goal's classes, by the detector's own calibration, were it seen as surely as can be."""
        ours = self._all.open_detector
        if ours is None:
            return np.zeros((len(embeddings), len(self._classes)))
        cosines = ClassText(self._classes, self._encoder).similarity(embeddings)
        return ours.score(np.ones_like(cosines), cosines)

    def capabilities(self) -> Mapping[str, object]:
        """Of all detectors together; see models.detection.detections.Detector."""
        return self._all.capabilities

    def features_of(self) -> tuple[str, ...]:
        """SHA-256 of each file that may tell `Detections.features`."""
        return self._all.features_of

    def tell_features_of(self, sha256: str) -> None:
        """From now on `Detections.features` are of this file alone; "": of what speaks for ours."""
        self._all.features_from = sha256

    def domain(self) -> dict[str, object]:
        """What the images are taken for, as JSON."""
        return self._all.domain.told()


def _told(capabilities: Mapping[str, Any], goal: str) -> str:
    """What to say about a detector that cannot take the goal's own words."""
    if goal in capabilities["unseen"]:
        return "; the detector knows nothing like it and cannot see it"
    by = capabilities["matched"].get(goal)
    if capabilities["classes"] is None or not by:
        return ""
    alike = ", ".join(f"{name} ({cosine:.2f})" for name, cosine in by.items())
    return f"; seen as what is like it in the detector's fixed list: {alike}"
