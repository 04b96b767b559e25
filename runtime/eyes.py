"""What is in an image: the detector, and a second look at what it has no word for."""

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from models import store
from models.detections import RawDetections
from models.detector import OpenDetector, open_detector
from models.second_look import SecondLook, Sought, look_twice
from models.text import TextEncoder
from models.vocabulary import Vocabulary
from models.words import ClassText
from runtime.config import Config
from runtime.core.types import F32, F64, U8, Detections
from runtime.goal import Goal

Classes = tuple[tuple[str, ...], ...]


class Eyes:
    """The models that see, loaded, and what they look for. One thread at a time may use them.
    Raises models.errors.ModelError when one cannot be loaded."""

    def __init__(self, config: Config, encoder: TextEncoder, words: Vocabulary) -> None:
        models = self._models = config.models
        self._encoder, self._rooms = encoder, words.rooms
        self._detector = open_detector(
            found(models.detector),
            models.detector_kind,
            encoder,
            models.threads,
            Path(models.detector_classes) if models.detector_classes else None,
        )
        # Embedding hundreds of names takes a second: not while somebody waits for a vote.
        self._detector.set_vocabulary(words.objects, words.rooms)
        self._look: Callable[[U8], RawDetections] = self._detector.detect
        self._second: SecondLook | None = None  # loaded for the first goal that needs it
        self._config, self._classes = config.detector, words.objects
        self._seen: dict[tuple[bytes, Classes, int], RawDetections] = {}

    def seek(self, goal: Goal, config: Config) -> str:
        """Look for a goal from now on; what to say about how well it can be seen, or ""."""
        self._detector.set_vocabulary(goal.classes, self._rooms)
        self._config, self._classes = config.detector, goal.classes
        self._look = self._detector.detect
        told = _told(self._detector.capabilities, goal.name)
        return told + (self._seek_twice(goal) if goal.strange else "")

    def _seek_twice(self, goal: Goal) -> str:
        """Have what the detector has no word for looked at by a classifier that may have one."""
        detector, name, places = self._detector, self._models.second_look, self._config.second_looks
        if not (name and places > 0 and isinstance(detector, OpenDetector)):
            return ""
        if self._second is None:
            self._second = SecondLook(found(name), self._encoder, self._models.threads)
        second, names = self._second, [names[0] for names in goal.classes]
        label = names.index(goal.name)
        likeness = second.likeness(goal.classes[label])
        if not likeness.any():
            return "; no picture is known of anything like it: it will hardly be recognised"
        sought = Sought(label, likeness, places)
        self._look = lambda rgb: look_twice(detector, second, sought, rgb)
        return f"; what is strange is looked at twice, for: {second.names[int(likeness.argmax())]}"

    def detect(self, rgb: U8) -> Detections:
        """(H, W, 3) -> what is seen surely enough."""
        raw = self._remembered(rgb)
        keep = raw.scores >= self._config.min_score
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
        key = digest, self._classes, self._config.second_looks
        raw = self._seen.pop(key, None) or self._look(rgb)
        self._seen[key] = raw  # the newest last
        while len(self._seen) > bound:
            del self._seen[next(iter(self._seen))]
        return raw

    def likeness(self, embeddings: F32) -> F64:
        """(N, D) unit rows of things seen before -> (N, C): with what probability each is each of
        the goal's classes, by the detector's own calibration, were it seen as surely as can be."""
        if not isinstance(self._detector, OpenDetector):
            return np.zeros((len(embeddings), len(self._classes)))
        cosines = ClassText(self._classes, self._encoder).similarity(embeddings)
        return self._detector.score(np.ones_like(cosines), cosines)

    def capabilities(self) -> Mapping[str, object]:
        """The detector's; see models.detections.Detector."""
        return self._detector.capabilities


def found(name: str) -> Path:
    """A path as it is, else a model's name; several files are a directory."""
    path = Path(name)
    return path if path.suffix and (path.exists() or "/" in name) else store.fetch(name)


def _told(capabilities: Mapping[str, Any], goal: str) -> str:
    """What to say about a detector that cannot take the goal's own words."""
    if goal in capabilities["unseen"]:
        return "; the detector knows nothing like it and cannot see it"
    by = capabilities["matched"].get(goal)
    if capabilities["classes"] is None or not by:
        return ""
    alike = ", ".join(f"{name} ({cosine:.2f})" for name, cosine in by.items())
    return f"; seen as what is like it in the detector's fixed list: {alike}"
