"""What is in an image: the detector, and a second look at what it has no word for."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from models.detection.detections import RawDetections
from models.detection.detector import OpenDetector, open_detector
from models.detection.second_look import SecondLook, Sought, look_twice
from models.store import manifest
from models.words.class_names import ClassText
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import Vocabulary
from runtime.config import Config, DetectorConfig
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
        self._detector = open_detector(
            located(models.detector),
            models.detector_kind,
            encoder,
            models.threads,
            Path(models.detector_classes) if models.detector_classes else None,
        )
        # Embedding hundreds of names takes a second: not while somebody waits for a vote.
        self._detector.set_vocabulary(words.objects, words.rooms)
        self._second: SecondLook | None = None
        if models.second_look and isinstance(self._detector, OpenDetector):
            self._second = SecondLook(located(models.second_look), encoder, models.threads)
        self._config, self._classes = config.detector, words.objects
        self._sought: Sought | None = None
        self._seen: dict[tuple[bytes, Classes, int], RawDetections] = {}

    def seek(self, goal: Goal, config: Config) -> str:
        """Look for a goal from now on; what to say about how well it can be seen, or "". When it
        raises, what was looked for before still is."""
        sought, how = self._twice(goal, config.detector)
        self._detector.set_vocabulary(goal.classes, self._rooms)
        self._config, self._classes, self._sought = config.detector, goal.classes, sought
        return _told(self._detector.capabilities, goal.name) + how

    def _twice(self, goal: Goal, cfg: DetectorConfig) -> tuple[Sought | None, str]:
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
        return Sought(goal.label, likeness, cfg.second_looks), told

    def detect(self, rgb: U8) -> Detections:
        """(H, W, 3) -> what is seen surely enough."""
        raw = self._remembered(rgb)
        keep = raw.scores >= MIN_SCORE
        return Detections(
            raw.boxes_px[keep],
            raw.scores[keep],
            raw.labels[keep],
            raw.embeddings[keep],
            raw.rooms,
            raw.scene,
        )

    def _remembered(self, rgb: U8) -> RawDetections:
        bound = self._config.memo_frames
        if not bound:
            return self._look(rgb)
        digest = hashlib.blake2b(rgb.tobytes(), digest_size=16).digest()
        key = digest, self._classes, self._sought.places if self._sought else 0
        raw = self._seen.pop(key, None) or self._look(rgb)
        self._seen[key] = raw  # the newest last
        while len(self._seen) > bound:
            del self._seen[next(iter(self._seen))]
        return raw

    def _look(self, rgb: U8) -> RawDetections:
        if self._sought and self._second and isinstance(self._detector, OpenDetector):
            return look_twice(self._detector, self._second, self._sought, rgb)
        return self._detector.detect(rgb)

    def likeness(self, embeddings: F32) -> F64:
        """(N, D) unit rows of things seen before -> (N, C): with what probability each is each of
        the goal's classes, by the detector's own calibration, were it seen as surely as can be."""
        if not isinstance(self._detector, OpenDetector):
            return np.zeros((len(embeddings), len(self._classes)))
        cosines = ClassText(self._classes, self._encoder).similarity(embeddings)
        return self._detector.score(np.ones_like(cosines), cosines)

    def capabilities(self) -> Mapping[str, object]:
        """The detector's; see models.detection.detections.Detector."""
        return self._detector.capabilities


def located(name: str) -> Path:
    """A path as it is, else a model's name; several files are a directory."""
    path = Path(name)
    return path if path.suffix and (path.exists() or "/" in name) else manifest.fetch(name)


def _told(capabilities: Mapping[str, Any], goal: str) -> str:
    """What to say about a detector that cannot take the goal's own words."""
    if goal in capabilities["unseen"]:
        return "; the detector knows nothing like it and cannot see it"
    by = capabilities["matched"].get(goal)
    if capabilities["classes"] is None or not by:
        return ""
    alike = ", ".join(f"{name} ({cosine:.2f})" for name, cosine in by.items())
    return f"; seen as what is like it in the detector's fixed list: {alike}"
