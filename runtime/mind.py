"""The models put to work: detector, text encoder and language model behind the loop's `Mind`.

With `__main__` the only importer of models/.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Self

from models import store
from models.detector import open_detector
from models.errors import ModelError as ModelFileError
from models.language import LanguageModel
from models.text import TextEncoder
from models.vocabulary import load_vocabulary
from runtime.config import Config
from runtime.core import experts
from runtime.core.experts import OBJECTS, ROOMS
from runtime.core.types import U8, Brief, Detections, Missing, Vote
from runtime.edge.clock import Clock, Deadline
from runtime.edge.panel import Expert, Panel
from runtime.edge.scorer import Scorer, Similarity
from runtime.errors import ModelError
from runtime.goal import Goal, understand


class LocalMind:
    """All models of one robot, loaded. Raises ModelError, one line, when one cannot be."""

    def __init__(self, config: Config, clock: Clock) -> None:
        self._config = config
        models, threads = config.models, config.models.threads
        vocabulary = (
            load_vocabulary(Path(models.vocabulary)) if models.vocabulary else load_vocabulary()
        )
        self.rooms = vocabulary.rooms
        self._objects = vocabulary.objects
        try:
            self._encoder = TextEncoder(_directory(models.text), threads)
            self._detector = open_detector(
                _file(models.detector),
                models.detector_kind,
                self._encoder,
                threads,
                Path(models.detector_classes) if models.detector_classes else None,
            )
            self._scorer = Scorer(self._rungs(threads), clock) if config.panel.experts else None
        except ModelFileError as error:
            raise ModelError(str(error)) from error
        self.panel = Panel(self._experts(), clock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the worker threads."""
        self.panel.close()
        if self._scorer is not None:
            self._scorer.close()

    def accept(self, goal: str) -> Goal:
        """Understand a goal, set the detector's vocabulary and warm the experts."""
        understood = understand(
            goal, self._objects, self._encoder.embed, self._config.goal.same_as_similarity
        )
        try:
            self._detector.set_vocabulary(understood.classes, self.rooms)
        except ModelFileError as error:
            raise ModelError(str(error)) from error
        if self._scorer is not None:
            rooms = [experts.spoken_room(name) for name in self.rooms]
            self._scorer.warm(experts.questions(ROOMS, understood.name, rooms))
            self._scorer.warm(experts.questions(OBJECTS, understood.name, ()))
        return understood

    def detect(self, rgb: U8) -> Detections:
        """(H, W, 3) -> what the detector is sure enough of."""
        raw = self._detector.detect(rgb)
        keep = raw.scores >= self._config.detector.min_score
        return Detections(
            raw.boxes_px[keep], raw.scores[keep], raw.labels[keep], raw.embeddings[keep], raw.rooms
        )

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        """Score objects that are on the map by now, in the background."""
        if self._scorer is not None:
            self._scorer.warm(experts.questions(OBJECTS, goal, names))

    def rung(self) -> str:
        """Which model answers the experts."""
        return self._scorer.rung if self._scorer is not None else "none"

    def _rungs(self, threads: int) -> Sequence[tuple[str, LanguageModel | Similarity]]:
        language = self._config.models.language
        local = LanguageModel(_file(language), threads)
        return (language, local), ("embedding", Similarity(self._encoder))

    def _experts(self) -> dict[str, Expert]:
        table: dict[str, Expert] = {"o2f": self._objects_vote, "r2f": self._rooms_vote, "sle": _sle}
        return {name: table[name] for name in self._config.panel.experts}

    def _objects_vote(self, brief: Brief, by: Deadline) -> Vote | Missing:
        things = experts.things_near(brief)
        affinity = self._affinities(experts.OBJECTS, brief, things, by)
        return experts.vote_objects(brief, affinity, self._config.experts)

    def _rooms_vote(self, brief: Brief, by: Deadline) -> Vote | Missing:
        types = experts.room_types(brief.frontiers)
        affinity = self._affinities(experts.ROOMS, brief, types, by)
        return experts.vote_rooms(brief, affinity, self._config.experts)

    def _affinities(
        self, topic: experts.Topic, brief: Brief, things: Sequence[str], by: Deadline
    ) -> dict[str, float]:
        if self._scorer is None or not things or len(brief.frontiers) < 2:
            return {}  # one frontier is no choice: nothing to ask
        answers = self._scorer.answer(experts.questions(topic, brief.goal, things), by)
        return experts.affinities(topic, brief.goal, things, answers)


def _sle(brief: Brief, by: Deadline) -> Vote | Missing:
    """The scene-layout expert: its place on the panel, until a vision-language model fills it."""
    return Missing("sle", "no model")


def _directory(name: str) -> Path:
    path = Path(name)
    return path if path.is_dir() else store.fetch(name)


def _file(name: str) -> Path:
    """A path to a file as it is, else a name from the manifest, fetched when it is not here."""
    path = Path(name)
    if path.suffix and (path.exists() or "/" in name):
        return path
    found = store.fetch(name)
    return found if found.is_file() else next(p for p in sorted(found.iterdir()) if p.is_file())
