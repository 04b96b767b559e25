"""The models put to work: detector, text encoder and language model behind the loop's `Mind`.

With `__main__` the only importer of models/.
"""

import hashlib
import sys
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Self

from models import store
from models.detector import RawDetections, open_detector
from models.errors import ModelError as ModelFileError
from models.language import LanguageModel
from models.text import TextEncoder
from models.vocabulary import load_vocabulary
from runtime.config import Config
from runtime.core import consensus, experts
from runtime.core.experts import OBJECTS, ROOMS
from runtime.core.types import U8, Brief, Detections, Missing, Vote
from runtime.edge.clock import Clock, Deadline
from runtime.edge.memo import ScoreFile, default_path
from runtime.edge.panel import Expert, Panel
from runtime.edge.scorer import Scorer, Similarity
from runtime.errors import ConfigError, ModelError
from runtime.goal import Goal, understand

GOALS_KEPT = 1000  # whose affinities are remembered


class LocalMind:
    """All models of one robot, loaded. Raises ModelError, one line, when one cannot be."""

    def __init__(self, config: Config, clock: Clock) -> None:
        self._models, self._clock = config.models, clock
        models, threads = config.models, config.models.threads
        vocabulary = (
            load_vocabulary(Path(models.vocabulary)) if models.vocabulary else load_vocabulary()
        )
        self.rooms = vocabulary.rooms
        self._spoken = tuple(experts.spoken_room(name) for name in vocabulary.rooms)
        self._objects = vocabulary.objects
        self._scorer: Scorer | None = None
        self._panel: Panel | None = None
        self._config = config
        self._classes: tuple[tuple[str, ...], ...] = ()
        self._behind: dict[str, experts.Doors] = {}
        self._affinity: dict[tuple[str, experts.Topic, str], dict[str, float]] = {}
        self._seen: dict[tuple[bytes, tuple[tuple[str, ...], ...]], RawDetections] = {}
        try:
            self._encoder = TextEncoder(_directory(models.text), threads)
            self._detector = open_detector(
                _file(models.detector),
                models.detector_kind,
                self._encoder,
                threads,
                Path(models.detector_classes) if models.detector_classes else None,
            )
        except ModelFileError as error:
            raise ModelError(str(error)) from error
        if config.panel.experts:
            self._ask_models()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the worker threads."""
        if self._panel is not None:
            self._panel.close()
        if self._scorer is not None:
            self._scorer.close()

    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]:
        """Understand a goal, set the detector's vocabulary, seat and warm the experts."""
        if config.models != self._models:
            raise ConfigError("models: cannot change while the runtime runs; start another")
        known = {name for names in self._objects for name in names}
        others = tuple((name,) for name in config.detector.labels if name not in known)
        classes, same_as = (*self._objects, *others), config.goal.same_as_similarity
        understood = understand(goal, classes, self._encoder.embed, same_as)
        try:
            self._detector.set_vocabulary(understood.classes, self.rooms)
        except ModelFileError as error:
            raise ModelError(str(error)) from error
        self._config, self._classes = config, understood.classes
        if len(self._affinity) > GOALS_KEPT:
            self._affinity = {}
        if config.panel.experts:
            scorer = self._ask_models()
            scorer.warm(experts.questions(ROOMS, understood.name, self._spoken))
            scorer.warm(experts.door_questions(self._spoken))
            scorer.warm(experts.questions(OBJECTS, understood.name, ()))
        if self._panel is not None:
            self._panel.close()
        rule = config.navigate.consensus

        def settled(votes: Sequence[Vote], pending: Collection[str], brief: Brief) -> bool:
            # What the geometry ranks first is not in the brief: then everyone is waited for.
            known = rule.fallback == "closest"
            return known and consensus.settled(votes, pending, brief.frontiers, rule)

        self._panel = Panel(self.seated(config), self._clock, settled=settled)
        return understood, self._panel

    def _ask_models(self) -> Scorer:
        """The scorer; its language model is loaded when the first expert is seated."""
        if self._scorer is None:
            name = self._models.language
            try:
                local = LanguageModel(_file(name), self._models.threads)
            except ModelFileError as error:
                raise ModelError(str(error)) from error
            path = Path(self._models.score_file) if self._models.score_file else default_path()
            rungs = ((name, local), ("embedding", Similarity(self._encoder)))
            file = ScoreFile(path, local.identity)
            self._scorer = Scorer(rungs, self._clock, file)
            if file.error:  # nothing depends on it but how soon the experts answer
                print(f"rfnav: {file.error}", file=sys.stderr)
        return self._scorer

    def detect(self, rgb: U8) -> Detections:
        """(H, W, 3) -> what the detector is sure enough of."""
        raw = self._raw(rgb)
        keep = raw.scores >= self._config.detector.min_score
        return Detections(
            raw.boxes_px[keep],
            raw.scores[keep],
            raw.labels[keep],
            raw.embeddings[keep],
            raw.rooms,
            raw.scene,
        )

    def _raw(self, rgb: U8) -> RawDetections:
        bound = self._config.detector.memo_frames
        if not bound:
            return self._detector.detect(rgb)
        key = hashlib.blake2b(rgb.tobytes(), digest_size=16).digest(), self._classes
        raw = self._seen.pop(key, None) or self._detector.detect(rgb)
        self._seen[key] = raw  # the newest last
        while len(self._seen) > bound:
            del self._seen[next(iter(self._seen))]
        return raw

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        """Score objects that are on the map by now, in the background."""
        if self._scorer is not None:
            self._scorer.warm(experts.questions(OBJECTS, goal, names))

    def settle(self, by: Deadline) -> bool:
        """Wait until nothing is left to be scored in the background; False when `by` came first."""
        return self._scorer is None or self._scorer.settle(by)

    def rung(self) -> str:
        """Which model answers the experts."""
        return self._scorer.rung if self._scorer is not None else "none"

    def seated(self, config: Config) -> dict[str, Expert]:
        """Those that the configuration seats, by name; they may be asked without a panel too."""
        cfg = config.experts

        def objects(brief: Brief, by: Deadline) -> Vote | Missing:
            return experts.vote_objects(brief, self._near(brief, by), cfg)

        def rooms(brief: Brief, by: Deadline) -> Vote | Missing:
            return experts.vote_rooms(brief, self._around(brief, by), cfg, self._doors(by))

        def scene(brief: Brief, by: Deadline) -> Vote | Missing:
            return experts.vote_scene(brief, self._likeness(brief), cfg)

        def both(brief: Brief, by: Deadline) -> Vote | Missing:
            near, around = self._near(brief, by), self._around(brief, by)
            return experts.vote_both(brief, near, around, cfg, self._doors(by))

        table: dict[str, Expert] = {"o2f": objects, "r2f": rooms, "sle": scene, "both": both}
        return {name: table[name] for name in config.panel.experts}

    def _near(self, brief: Brief, by: Deadline) -> dict[str, float]:
        return self._affinities(experts.OBJECTS, brief, experts.things_near(brief), by)

    def _around(self, brief: Brief, by: Deadline) -> dict[str, float]:
        rooms = self._spoken if any(f.rooms for f in brief.frontiers) else ()
        return self._affinities(experts.ROOMS, brief, rooms, by)

    def _doors(self, by: Deadline) -> experts.Doors:
        if self._scorer is None:
            return experts.NO_DOORS
        rung = self._scorer.rung
        if rung not in self._behind:
            answers = self._scorer.answer(experts.door_questions(self._spoken), by)
            found = experts.behind(self._spoken, answers)
            if not found or self._scorer.rung != rung:
                return found
            self._behind[rung] = found
        return self._behind[rung]

    def _affinities(
        self, topic: experts.Topic, brief: Brief, things: Sequence[str], by: Deadline
    ) -> dict[str, float]:
        if self._scorer is None or not things or len(brief.frontiers) < 2:
            return {}  # one frontier is no choice: nothing to ask
        rung = self._scorer.rung
        known = self._known(rung, topic, brief.goal)
        asked = [thing for thing in things if thing not in known]
        if asked:
            answers = self._scorer.answer(experts.questions(topic, brief.goal, asked), by)
            if self._scorer.rung != rung:  # scores of different models are never mixed
                return self._affinities(topic, brief, things, by)
            known.update(experts.affinities(topic, brief.goal, asked, answers))
        return {thing: known[thing] for thing in things if thing in known}

    def _known(self, rung: str, topic: experts.Topic, goal: str) -> dict[str, float]:
        """Affinities that were computed before, of one goal by one model."""
        return self._affinity.setdefault((rung, topic, goal), {})

    def _likeness(self, brief: Brief) -> dict[int, float]:
        """Cosine of each frontier's view with the goal's room prompt: the rung below a
        vision-language model."""
        views = {f.id: f.view for f in brief.frontiers if f.view.size}
        if len(views) < 2:
            return {}
        goal = self._encoder.embed([experts.SCENE.format(thing=brief.goal)])[0]
        return {id: float(view @ goal) for id, view in views.items()}


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
