"""SLE by a network that was taught what lies beyond a view: its own word for it, or that of the
language model, which is shown the view as vectors in place of words.

A view is looked at when a vote first needs it, and what the network makes of it is kept. Where the
frontier is in it is rounded first, so that what is kept depends on the view alone.
"""

import hashlib
import math
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Final, NamedTuple, Protocol

import numpy as np

from runtime.clock import Deadline
from runtime.core.types import F32, Absence, Brief, Missing, Sight, Vote
from runtime.core.voting import sight_experts
from runtime.core.voting.likelihood_experts import ExpertConfig
from runtime.core.voting.sight_experts import HEAD, LANGUAGE
from runtime.experts.likelihood import ENOUGH
from runtime.experts.panel import Expert
from runtime.experts.scorer import Scorer

VIEWS_KEPT: Final = 400  # 20 kB each
ACROSS: Final = 32  # steps of where a frontier is across a view
STEP_M: Final = 0.25  # and of how far away
HALFWAY_M: Final = 5.0  # the distance that is 1 to the network


class LayoutOutputs(Protocol):
    """What the network makes of N views: `beyond` (N, B), `tokens` (N, n, width)."""

    @property
    def beyond(self) -> F32: ...

    @property
    def tokens(self) -> F32: ...


class LayoutNetwork(Protocol):
    """The network; models/language/scene_layout.py has it. `blank` (n, width) are tokens of no
    view, `template` is said after them, `text` puts a goal for the text encoder; `detector`:
    SHA-256 of the file whose features it was taught."""

    detector: str

    @property
    def blank(self) -> F32: ...

    @property
    def template(self) -> str: ...

    @property
    def text(self) -> str: ...

    def look(self, features: F32, depth: F32, way: F32, /) -> LayoutOutputs:
        """(N, C, h, w), (N, 2, h, w), (N, 2) across and away."""
        ...

    def evidence(self, beyond: F32, goal_row: F32, /) -> F32:
        """(N, B) and (D,) the goal's text -> (N,) nats."""
        ...


class SeenView(NamedTuple):
    """One view, looked at. `digest` is of its tokens."""

    beyond: F32
    tokens: F32
    digest: str


@dataclass
class SceneLayoutExperts:
    """The network at work. `row`: text -> its (D,) embedding. `scorer`: of the language model that
    it was taught with; without one, `mute` says why."""

    layout: LayoutNetwork
    row: Callable[[str], F32]
    scorer: Scorer | None = None
    mute: str = ""
    _views: dict[bytes, SeenView] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def head(self, cfg: ExpertConfig) -> Expert:
        """By the network's own word."""
        return partial(self._by_head, cfg)

    def language(self, cfg: ExpertConfig) -> Expert:
        """By the language model, shown the views."""
        return partial(self._by_language, cfg)

    def ready(self, by: Deadline) -> bool:
        """Whether the language model does not hang."""
        return self.scorer is None or math.isinf(by.at_s) or not self.scorer.stuck

    def forget(self) -> None:
        """Look at every view anew from here on."""
        with self._lock:
            self._views.clear()

    def _by_head(self, cfg: ExpertConfig, brief: Brief, by: Deadline) -> Vote | Missing:
        views = self._looked_at(brief)
        if isinstance(views, Missing):
            return views
        row = self.row(self.layout.text.format(brief.goal))
        beyond = np.stack([view.beyond for view in views.values()])
        nats = dict(zip(views, self.layout.evidence(beyond, row).tolist(), strict=True))
        return sight_experts.vote_sights(brief, _finite(nats), cfg, HEAD)

    def _by_language(self, cfg: ExpertConfig, brief: Brief, by: Deadline) -> Vote | Missing:
        if self.scorer is None:
            return Missing("sle", Absence.NO_MODEL, self.mute)
        views = self._looked_at(brief)
        if isinstance(views, Missing):
            return views
        blank, context = _digest(self.layout.blank), self.layout.template
        shown = {view.digest: view.tokens for view in views.values()}
        digests = list(shown)
        shown[blank] = self.layout.blank
        asked = sight_experts.sight_questions(context, brief.goal, (blank, *digests))
        answers = self.scorer.answer(asked, by, shown)
        known = sight_experts.sight_evidence(context, brief.goal, digests, blank, answers)
        if by.passed() and len(known) < ENOUGH * len(digests):
            return Missing("sle", Absence.LATE, f"{len(known)} of {len(digests)} views answered")
        nats = {i: known[view.digest] for i, view in views.items() if view.digest in known}
        return sight_experts.vote_sights(brief, _finite(nats), cfg, LANGUAGE)

    def _looked_at(self, brief: Brief) -> dict[int, SeenView] | Missing:
        """By frontier that was seen, of those that are a choice."""
        if len(brief.frontiers) < 2:
            return Missing("sle", Absence.NO_EVIDENCE)
        seen = {f.id: f.sight for f in brief.frontiers if f.sight is not None}
        views = {id: self._view(sight) for id, sight in seen.items() if _shows(sight)}
        told = f"of {len(seen)} views none shows anything" if seen else "no view of a frontier yet"
        return views or Missing("sle", Absence.NO_IMAGES, told)

    def _view(self, sight: Sight) -> SeenView:
        across = round(sight.column * ACROSS) / ACROSS
        away = round(sight.range_m / STEP_M) * STEP_M / HALFWAY_M
        way = np.array([[across, away]], np.float32)
        raw = hashlib.blake2b(sight.features.tobytes(), digest_size=16)
        for part in (sight.depth, way):
            raw.update(part.tobytes())
        key = raw.digest()
        with self._lock:
            view = self._views.pop(key, None)
            if view is None:  # one at a time: sums of larger batches may end otherwise
                features = sight.features[None].astype(np.float32)
                depth = sight.depth[None].astype(np.float32)
                looked = self.layout.look(features, depth, way)
                tokens = np.asarray(looked.tokens[0], np.float32)
                view = SeenView(np.asarray(looked.beyond[0], np.float32), tokens, _digest(tokens))
            self._views[key] = view  # the newest last
            while len(self._views) > VIEWS_KEPT:
                del self._views[next(iter(self._views))]
        return view


def _shows(sight: Sight) -> bool:
    """Whether there is anything in it to tell from something else."""
    features = sight.features.astype(np.float32)
    return bool(np.isfinite(features).all() and np.ptp(features, axis=(1, 2)).any())


def _finite(nats: Mapping[int, float]) -> dict[int, float]:
    """ValueError for what is no evidence."""
    if not np.isfinite(list(nats.values())).all():
        raise ValueError("scene layout: evidence that is not finite")
    return dict(nats)


def _digest(tokens: F32) -> str:
    return hashlib.blake2b(np.ascontiguousarray(tokens).tobytes(), digest_size=16).hexdigest()
