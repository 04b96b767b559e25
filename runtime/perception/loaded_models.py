"""The models put to work behind the loops: detector, text encoder and language model."""

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Self

from models.language.reasoning import ReasoningModel
from models.language.scoring import LanguageModel
from models.language.vision import VisionModel
from models.store import manifest
from models.words.text_encoder import TextEncoder
from models.words.vocabulary import load_vocabulary
from runtime.clock import Clock, Deadline
from runtime.config import Config, ModelsConfig
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.objects.surfaces import Window
from runtime.core.types import F32, F64, U8, Ballot, Brief, Detections, Vote
from runtime.core.voting import consensus, likelihood_experts
from runtime.errors import ConfigError
from runtime.experts.cloud import Bill, Cloud
from runtime.experts.counts import CountExperts
from runtime.experts.likelihood import LikelihoodExperts
from runtime.experts.panel import Expert, Panel
from runtime.experts.reasoner import Reasoner
from runtime.experts.scene_layout import SceneLayoutExperts
from runtime.experts.score_cache import ScoreFile, default_path
from runtime.experts.scorer import Scorer, Similarity
from runtime.experts.seating import EMBEDDING, Seating, Unseated
from runtime.log import say
from runtime.perception.counted import seat_counts
from runtime.perception.detection import SeekingDetector
from runtime.perception.goal_words import Goal
from runtime.perception.heard_goal import hear, hear_each, sized, with_labels, words_of
from runtime.perception.model_errors import models_told
from runtime.perception.scene_layout import Speaker, layout_for, seat_layout

TEXT_MODEL = "minilm"  # it embeds words and pictures' prompts; all classes are measured with it
REPLY_TOKENS = 200  # of a model that reasons: a set of frontiers and a sentence are 60
GGUF = ".gguf"  # how a model's file ends; a name from the manifest may have dots, too


class LoadedModels:
    """All models of one robot, loaded. Raises ModelError, one line, when one cannot be."""

    @models_told()
    def __init__(
        self, config: Config, clock: Clock, book: Callable[[float], None] = lambda took_s: None
    ) -> None:
        self._configured, self._clock, self._cloud_config = config.models, clock, config.cloud
        self._book = book
        config = replace(config, models=_fitting(config.models))
        self._models = models = config.models
        words = [Path(models.vocabulary)] if models.vocabulary else []  # else the project's
        vocabulary = load_vocabulary(*words)
        self.rooms = vocabulary.rooms
        self._spoken = tuple(likelihood_experts.spoken_room(name) for name in vocabulary.rooms)
        self._seating: Seating | None = None
        self._speaker: Speaker | None = None
        self._cloud = Cloud(config.cloud, clock) if config.cloud.enabled else None
        self._panel: Panel | None = None
        self._noted = ""  # how views are not judged, as it was said last
        kept = manifest.cache_dir().parent / "embeddings.npz"
        self._encoder = TextEncoder(_directory(TEXT_MODEL), models.threads, kept)
        self._words = words_of(vocabulary)
        self._detector = SeekingDetector(config, self._encoder, vocabulary)
        if error := self._encoder.keep():  # nothing depends on it but how soon the next start is
            say(error)
        if config.panel.experts:
            seating = self._open_seating()
            if _wants_layout(config):  # while the files are those that were loaded
                seating.layout = self._open_layout()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the worker threads."""
        for part in (self._panel, self._seating, self._cloud):
            if part is not None:
                part.close()

    @models_told()
    def accept(self, goal: str, config: Config) -> tuple[Goal, Panel]:
        """Understand a goal, set the detector's vocabulary, make and warm the experts. When it
        raises, the goal accepted before is still looked for."""
        if config.models != self._configured:
            raise ConfigError("models: cannot change while the runtime runs; start another")
        if config.cloud != self._cloud_config:  # or a request could have the key sent elsewhere
            raise ConfigError("cloud: cannot change while the runtime runs; start another")
        words = with_labels(self._words, config.detector.labels)
        understood = sized(hear(goal, words, self._encoder.embed).goal)
        seating = self._open_seating() if config.panel.experts else None
        told = self._detector.seek(understood, config)
        understood = replace(understood, how=understood.how + told)
        if self._cloud is not None:
            self._cloud.begin(understood.name)
        if self._panel is not None:
            self._panel.close()
        if seating is not None:
            if not config.models.keep_scores:
                seating.forget()
            seating.begin(understood.name)
        rule = config.navigate.consensus

        def settled(votes: Sequence[Vote], pending: Collection[str], brief: Brief) -> bool:
            return consensus.settled(votes, pending, brief.frontiers, rule, brief.order)

        def agreed(ballot: Ballot) -> bool:
            return consensus.agreed(ballot, rule)

        appeals = seating.appeals(config.panel.seated) if seating else {}
        self._panel = Panel(self.seated(config), self._clock, appeals, agreed, settled)
        self._detector.tell_features_of(seating.features_from if seating else "")
        return understood, self._panel

    @models_told()
    def hear(self, text: str, config: Config, several: bool) -> tuple[Goal, ...]:
        """What a text names, without looking for it: one thing, or `several`."""
        words = with_labels(self._words, config.detector.labels)
        each = hear_each if several else lambda *told: (hear(*told).goal,)
        return each(text, words, self._encoder.embed)

    def afford(self, usd: float | None) -> None:
        """What the goal accepted last may cost at most, if that is less than the robot's own cap;
        None: the cap."""
        if self._cloud is not None:
            self._cloud.afford(usd)

    def finish(self) -> None:
        """The search is over: what its goal may cost is counted anew for the next."""
        if self._cloud is not None:
            self._cloud.finish()

    def _open_seating(self) -> Seating:
        """The experts' models; they are loaded when the first expert is asked for."""
        if self._seating is None:
            self._seating = self._load_seating()
        return self._seating

    def _load_seating(self) -> Seating:
        models = self._models
        below = Scorer([(EMBEDDING, Similarity(self._encoder))], self._clock)
        seating = Seating(models.language, self._likeness, LikelihoodExperts(below, self._spoken))
        seating.by_count = self.counted()
        seating.cloud = self._cloud
        if models.vision:
            seating.vision = self._reason(_open_vision(models), sees=True)
            seating.looks_in_words = _style(models.vision, models.vision_style) == "reason"
        if _style(models.language, models.language_style) == "score":
            seating.by_likelihood = LikelihoodExperts(self._open_scorer(), self._spoken)
        elif models.language == models.vision:  # one model for all experts
            seating.reasoner = seating.vision
        else:
            path, sizes = (
                manifest.first_file(models.language),
                (models.context_tokens, models.gpu_layers),
            )
            seating.reasoner = self._reason(
                ReasoningModel(path, models.threads, *sizes), sees=False
            )
        return seating

    def _open_scorer(self) -> Scorer:
        local = LanguageModel(manifest.first_file(self._models.language), self._models.threads)
        path = Path(self._models.score_file) if self._models.score_file else default_path()
        file = ScoreFile(path, local.identity)
        scorer = Scorer([(self._models.language, local)], self._clock, file, self._book)
        self._speaker = Speaker(local.sha256, scorer)
        if file.error:  # nothing depends on it but how soon the experts answer
            say(file.error)
        return scorer

    def _reason(self, model: ReasoningModel, sees: bool) -> Reasoner:
        return Reasoner(model, self._clock, REPLY_TOKENS, sees)

    @models_told()
    def detect(self, rgb: U8, window: Callable[[], Window | None] = lambda: None) -> Detections:
        """(H, W, 3) -> what is seen surely enough; `window`: where a closer look is worth it."""
        return self._detector.detect(rgb, window)

    @models_told()
    def likeness(self, embeddings: F32) -> F64:
        """(N, D) unit rows of things seen before -> (N, C): with what probability each is each of
        the goal's classes."""
        return self._detector.likeness(embeddings)

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        """Score objects that are on the map by now, in the background."""
        if self._seating is not None:
            self._seating.notice(goal, names)

    def hold(self, frames: Sequence[Keyframe]) -> None:
        """The keyframes that are kept now: a model that sees looks at them in the background."""
        if self._seating is not None:
            self._seating.hold(frames)

    def settle(self, by: Deadline) -> bool:
        """Wait until nothing is left to be scored in the background; False when `by` came first."""
        return self._seating is None or self._seating.settle(by)

    def capabilities(self) -> Mapping[str, object]:
        """The detector's; see models.detection.detections.Detector."""
        return self._detector.capabilities()

    def features_of(self) -> tuple[str, ...]:
        """SHA-256 of each file that may tell `Detections.features`."""
        return self._detector.features_of()

    def rung(self) -> str:
        """Which model answers the experts."""
        return self._seating.rung() if self._seating is not None else "none"

    def health(self) -> dict[str, object]:
        """For people: what the images are taken for, rungs by expert, models' errors, what the
        cloud costs."""
        seated = self._seating.health() if self._seating is not None else {}
        return {"domain": self._detector.domain(), **seated}

    def bills(self) -> tuple[Bill, ...]:
        """Calls of the cloud since this was asked last, for the journal."""
        return self._seating.bills() if self._seating is not None else ()

    @models_told()
    def seated(self, config: Config) -> dict[str, Expert]:
        """Those that the configuration names; they may be asked without a panel too."""
        names = config.panel.seated
        if not names:
            return {}
        seating = self._open_seating()
        if seating.layout is None and _wants_layout(config):
            seating.layout = self._open_layout()
        seats = seating.experts(names, config.experts)
        if seating.layout_note not in ("", self._noted):  # SLE goes on by the rung below
            self._noted = seating.layout_note
            say(self._noted)
        return seats

    @models_told()
    def counted(self) -> CountExperts:
        """The experts by what was counted in homes, whoever else is seated."""
        return seat_counts(self._encoder.embed)

    def _open_layout(self) -> SceneLayoutExperts | Unseated:
        return seat_layout(
            lambda: manifest.first_file(layout_for(self._models)),
            self._detector.features_of(),
            self._speaker,
            lambda text: self._encoder.embed([text])[0],
            self._models.threads,
        )

    def _likeness(self, brief: Brief) -> dict[int, float]:
        """Cosine of each frontier's view with the goal's room prompt: the rung below a
        vision-language model."""
        views = {f.id: f.view for f in brief.frontiers if f.view.size}
        if len(views) < 2:
            return {}
        goal = self._encoder.embed([likelihood_experts.SCENE.format(thing=brief.goal)])[0]
        return {id: float(view @ goal) for id, view in views.items()}


def _fitting(models: ModelsConfig) -> ModelsConfig:
    """With no more threads than this machine has processors: more only wait for each other."""
    here = len(os.sched_getaffinity(0))
    if models.threads <= here:
        return models
    say(f"models.threads: is {models.threads}, this machine has {here} processors: {here} are used")
    return replace(models, threads=here)


def _wants_layout(config: Config) -> bool:
    return "sle" in config.panel.experts and config.experts.scene_layout != EMBEDDING


def _directory(name: str) -> Path:
    path = Path(name)
    return path if path.is_dir() else manifest.fetch(name)


def _style(name: str, configured: str) -> str:
    """ "score" or "reason": as configured, else as the manifest has it; a file scores."""
    if configured or name.endswith(GGUF):
        return configured or "score"
    return manifest.entry(name).style


def _open_vision(models: ModelsConfig) -> VisionModel:
    """A name from the manifest, which has both files and the handler, or two files."""
    name, projector, handler = models.vision, models.vision_projector, models.vision_handler
    if name.endswith(GGUF):
        if not projector:
            raise ConfigError("models.vision_projector: must name the mmproj GGUF of models.vision")
        text, mmproj = Path(name), Path(projector)
    else:
        entry, folder = manifest.entry(name), manifest.fetch(name)
        if entry.task != "vision" or len(entry.files) != 2:
            raise ConfigError(
                f"models.vision: {name} is a model for {entry.task}, and sees nothing"
            )
        text, mmproj = (folder / file.name for file in entry.files)
        handler = handler or entry.handler
    sizes = models.threads, models.context_tokens, models.gpu_layers
    return VisionModel(text, mmproj, handler or "mtmd", *sizes)
