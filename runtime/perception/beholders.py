"""The three kinds of the scene-layout expert, asked about single views: by its language model, by
its plain head, by the embedding of the whole view."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from models.language.scene_layout import SceneLayout, SceneLooks
from models.language.scoring import LanguageModel
from models.store import manifest
from models.words.text_encoder import TextEncoder
from runtime.config import ModelsConfig
from runtime.core.types import F32
from runtime.core.voting.likelihood_experts import SCENE, VIEW_SCALE
from runtime.core.voting.sight_experts import SIGHT_REFERENCES, preferences
from runtime.errors import ModelError
from runtime.experts.scene_layout import HALFWAY_M
from runtime.perception.loaded_models import TEXT_MODEL
from runtime.perception.model_errors import models_told
from runtime.perception.scene_layout import layout_for

DEFAULT = ModelsConfig()
LANGUAGE = "smollm2-135m"  # which the soft tokens were made for
THREADS = 1
BATCH = 64
About = Literal["beyond", "view", "room"]
"""What is asked: is a thing beyond the frontier, is it in view, is this a room of that type."""
Floats = NDArray[np.floating[Any]]
Embed = Callable[[list[str]], F32]
Score = Callable[[F32, str, Sequence[str]], Sequence[float]]
"""Soft tokens (8, E), what is said after them, words -> the log likelihood of each word."""


class Views(Protocol):
    """Sights, one a row: `features` (N, C, h, w), `depth` (N, 2, h, w), `scene` (N, D), `column`
    (N,) 0..1 and `range_m` (N,) of the frontier; see `runtime.core.types.Sight`."""

    @property
    def features(self) -> Floats: ...

    @property
    def depth(self) -> Floats: ...

    @property
    def scene(self) -> Floats: ...

    @property
    def column(self) -> Floats: ...

    @property
    def range_m(self) -> Floats: ...


class SceneProjector(Protocol):
    """The part of `models.language.scene_layout.SceneLayout` that is asked here."""

    text: str
    templates: dict[str, str]
    blank: F32
    grid: tuple[int, ...]

    def look(self, features: F32, depth: F32, way: F32) -> SceneLooks: ...

    def evidence(self, answer: F32, row: F32) -> F32: ...


class ByEmbedding:
    """The cosine of the view's embedding and the name's, as the expert weighs it."""

    def __init__(self, embed: Embed) -> None:
        self._embed = embed

    def evidence(self, about: About, views: Views, names: Sequence[str]) -> Floats:
        """(N, K) nats."""
        if not names:
            return np.zeros((len(views.scene), 0))
        phrase = "{thing}" if about == "room" else SCENE
        rows = np.asarray(self._embed([phrase.format(thing=name) for name in names]), np.float64)
        return VIEW_SCALE * views.scene.astype(np.float64) @ rows.T


class ByHead:
    """The projector's plain head; rooms are asked of what it has of the view itself."""

    def __init__(self, projector: SceneProjector, embed: Embed) -> None:
        self._projector, self._embed = projector, embed

    def evidence(self, about: About, views: Views, names: Sequence[str]) -> Floats:
        """(N, K) nats."""
        if not names:
            return np.zeros((len(views.scene), 0))
        seen = looked(self._projector, views)
        part = seen.beyond if about == "beyond" else seen.view
        rows = self._embed([self._projector.text.format(name) for name in names])
        return np.column_stack([self._projector.evidence(part, row) for row in rows])


class ByLanguage:
    """The likelihood of a name after soft tokens and a few words, against other names' and against
    what it is after no picture."""

    def __init__(self, projector: SceneProjector, score: Score) -> None:
        self._projector, self._score = projector, score

    def evidence(self, about: About, views: Views, names: Sequence[str]) -> Floats:
        """(N, K) nats."""
        if not names:
            return np.zeros((len(views.scene), 0))
        text = self._projector.templates[about]
        tokens = looked(self._projector, views).tokens
        shown = tqdm(tokens, desc=f"language, {about}", unit="view", disable=None)
        found = np.array([self._preferences(each, text, names) for each in shown])
        return found - self._preferences(self._projector.blank, text, names)

    def _preferences(self, tokens: F32, text: str, names: Sequence[str]) -> Floats:
        words = [f" {word}" for word in (*SIGHT_REFERENCES, *names)]
        nats, count = self._score(tokens, text, words), len(SIGHT_REFERENCES)
        return np.array(preferences(nats[count:], nats[:count]))


def looked(projector: SceneProjector, views: Views) -> SceneLooks:
    """All of them through the projector, a few at a time. Raises ModelError for features of another
    detector's."""
    if views.features.shape[1:] != projector.grid:
        shapes = (" x ".join(map(str, s)) for s in (views.features.shape[1:], projector.grid))
        raise ModelError(
            "views have {} features, the projector takes {}: make them again with the detector "
            "that it was trained on: hil-sim beyond".format(*shapes)
        )
    way = np.column_stack((views.column, views.range_m / HALFWAY_M)).astype(np.float32)
    features, depth = views.features, views.depth
    parts = [
        projector.look(features[at : at + BATCH].astype(np.float32),
                       depth[at : at + BATCH].astype(np.float32), way[at : at + BATCH])
        for at in range(0, len(views.scene), BATCH)
    ]  # fmt: skip
    return SceneLooks(
        *(np.concatenate([getattr(p, name) for p in parts]) for name in SceneLooks._fields)
    )


class Opened(NamedTuple):
    """The kinds by name, the text encoder that all but one of them have, and SHA-256 of the
    detector whose features the projector was taught."""

    kinds: Mapping[str, ByEmbedding | ByHead | ByLanguage]
    embed: Embed
    detector: str


@models_told()
def open_beholders(kinds: Sequence[str], models: ModelsConfig = DEFAULT) -> Opened:
    """Those of these kinds, with the default models but for the scene layout. Raises ModelError
    when one cannot be had."""
    embed = TextEncoder(manifest.fetch(TEXT_MODEL), THREADS).embed
    projector = SceneLayout(manifest.first_file(layout_for(models)), THREADS)
    found: dict[str, ByEmbedding | ByHead | ByLanguage] = {}
    for kind in kinds:
        if kind == "embedding":
            found[kind] = ByEmbedding(embed)
        elif kind == "head":
            found[kind] = ByHead(projector, embed)
        elif not projector.speaks:
            what = f"{layout_for(models)}: has nothing to show to a language model"
            raise ModelError(f"{what}: leave out --kind language, or export it with a projector")
        else:
            model = LanguageModel(manifest.first_file(LANGUAGE), THREADS)
            found[kind] = ByLanguage(projector, _scored_by(model))
    return Opened(found, embed, projector.detector)


def _scored_by(model: LanguageModel) -> Score:
    return lambda tokens, text, words: model.score(text, words, tokens)
