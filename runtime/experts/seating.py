"""Who answers for each expert: its rungs in order, and the cloud it may appeal to."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from runtime.clock import Deadline
from runtime.core.mapping.keyframes import Keyframe
from runtime.core.types import Absence, Brief, Missing, Vote
from runtime.core.voting import likelihood_experts
from runtime.core.voting.likelihood_experts import ExpertConfig, SceneRung
from runtime.core.voting.sight_experts import HEAD, LANGUAGE
from runtime.experts.cloud import RUNG, Bill, Cloud
from runtime.experts.counts import CountExperts
from runtime.experts.fallback import Rung, with_fallback
from runtime.experts.likelihood import LikelihoodExperts
from runtime.experts.panel import Expert
from runtime.experts.reasoner import Reasoner
from runtime.experts.scene_layout import SceneLayoutExperts

LOCAL: Final = "local"
EMBEDDING: Final = "embedding"
COUNTS: Final = "counts"
COUNTS_ALONE: Final = "counts alone"
"""Which rung answers, where counts do in place of a model above them."""
TOGETHER: Final = "local+counts"
LOCAL_SHARE = 0.6
"""Of the time left, that a model on the robot has while another rung is below it."""
CLOUD_SHARE = 0.85


class Unseated(NamedTuple):
    """Why there is no network that was taught views, in a line. `fault`: its file is of no use;
    else it goes with other models than there are, and nothing is wrong."""

    why: str
    fault: bool = False


@dataclass
class Seating:
    """The models that answer for the experts. `language` names the one that answers on the robot,
    `likeness` is the cosine of each frontier's view with the goal; `looks_in_words`: whether a
    model that sees is asked about all pictures at once, for a reason and a set."""

    language: str
    likeness: Callable[[Brief], Mapping[int, float]]
    by_embedding: LikelihoodExperts  # the text encoder, the last rung
    by_count: CountExperts | None = None  # what was counted in homes
    by_likelihood: LikelihoodExperts | None = None  # a small language model
    reasoner: Reasoner | None = None  # a large one
    vision: Reasoner | None = None  # one that sees
    looks_in_words: bool = False
    layout: SceneLayoutExperts | Unseated | None = None  # taught views; None: not opened yet
    cloud: Cloud | None = None
    layout_rung: SceneRung = EMBEDDING  # how SLE was last seated
    answered: dict[str, tuple[Brief, str, str]] = field(default_factory=dict)
    """By expert: the brief it last voted on, by which rung, and which is its highest."""

    def begin(self, goal: str) -> None:
        """Score in the background what every search for this goal needs."""
        self.answered.clear()
        if self.by_count is not None:
            self.by_count.begin(goal)
        for experts in self._scoring():
            experts.begin(goal)

    def forget(self) -> None:
        """Score all that is asked from here on anew."""
        for experts in (self.by_likelihood, self.by_embedding, self.reasoner, self.vision):
            if experts is not None:
                experts.forget()
        if isinstance(self.layout, SceneLayoutExperts):
            self.layout.forget()

    def notice(self, goal: str, names: tuple[str, ...]) -> None:
        """Score objects that are on the map by now, in the background."""
        for experts in self._scoring():
            experts.notice(goal, names)

    def hold(self, frames: Sequence[Keyframe]) -> None:
        """The keyframes that are kept now: a model that sees looks at them in the background."""
        for part in (self.reasoner, self.vision):
            if part is not None:
                part.hold(frames)

    def settle(self, by: Deadline) -> bool:
        """Wait until nothing is left to be scored in the background; False when `by` came first."""
        return all(experts.scorer.settle(by) for experts in self._scoring())

    def close(self) -> None:
        """End the worker threads."""
        for part in (self.reasoner, self.vision):
            if part is not None:
                part.close()
        for experts in (self.by_likelihood, self.by_embedding):
            if experts is not None:
                experts.scorer.close()

    def rung(self) -> str:
        """Which model answers the experts of words: that of the lowest rung any came down to."""
        found = {
            COUNTS_ALONE if rung == COUNTS != highest else rung
            for name, (_, rung, highest) in self.answered.copy().items()
            if name != "sle"
        }
        order = EMBEDDING, COUNTS_ALONE, COUNTS, RUNG
        return next((rung for rung in order if rung in found), self.language)

    def health(self) -> dict[str, object]:
        """For people: the rung that answered each expert last, what models said that failed, how
        far pictures are encoded, and what the cloud costs."""
        errors = [
            *(self.by_likelihood.scorer.errors if self.by_likelihood is not None else ()),
            *(self.vision.errors if self.vision is not None else ()),
            *([self.layout_note] if self.layout_fails else ()),
        ]
        told: dict[str, object] = {
            "rungs": {name: rung for name, (_, rung, _) in sorted(self.answered.copy().items())},
            "errors": errors,
        }
        if self.vision is not None:
            told["pictures"] = self.vision.told()
        return told if self.cloud is None else told | {"cloud": self.cloud.status()}

    def bills(self) -> tuple[Bill, ...]:
        """Calls of the cloud since this was asked last."""
        return self.cloud.bills() if self.cloud is not None else ()

    @property
    def layout_note(self) -> str:
        """Why views are not judged as configured; "" when they are."""
        if self.layout_rung == EMBEDDING or self.layout is None:
            return ""
        if isinstance(self.layout, Unseated):
            return self.layout.why
        return self.layout.mute if self.layout_rung == LANGUAGE else ""

    @property
    def features_from(self) -> str:
        """SHA-256 of the detector's file whose features views are judged by; "" where by none."""
        if self.layout_rung == EMBEDDING or not isinstance(self.layout, SceneLayoutExperts):
            return ""
        return self.layout.layout.detector

    @property
    def layout_fails(self) -> bool:
        """Whether they are not because a file is of no use."""
        asked = self.layout_rung != EMBEDDING
        return asked and isinstance(self.layout, Unseated) and self.layout.fault

    def experts(self, names: Sequence[str], cfg: ExpertConfig) -> dict[str, Expert]:
        """Those of these names, as `cfg` has them vote."""
        local, below = self._local(cfg), self.by_embedding.experts(cfg)
        counted = self._counted(cfg)
        below["sle"] = lambda brief, by: likelihood_experts.vote_scene(
            brief, self.likeness(brief), cfg
        )
        rungs = {name: [local[name]] if name in local else [] for name in names}
        self.layout_rung = cfg.scene_layout if "sle" in rungs else EMBEDDING
        taught = {"sle": self._by_layout(cfg)} if "sle" in rungs else {}
        found = {
            name: [*self._rungs(name, first, taught.get(name, [])), Rung(EMBEDDING, below[name])]
            for name, first in rungs.items()
        }
        for name, rung in counted.items():
            if name in found:
                found[name].insert(0 if cfg.words == COUNTS else -1, rung)
        return {n: self._noting(n, with_fallback(n, r), r[0].name) for n, r in found.items()}

    def appeals(self, names: Sequence[str]) -> dict[str, Expert]:
        """By name: the cloud, for experts that it has not answered for on this brief already."""
        if self.cloud is None or not self.cloud.cfg.on_disagreement:
            return {}
        return {name: self._appeal(name, self.cloud) for name in names}

    def _scoring(self) -> list[LikelihoodExperts]:
        """Those that are asked in the background: the lower one only after it was needed."""
        below = self.by_embedding if self.by_embedding.used else None
        return [experts for experts in (self.by_likelihood, below) if experts is not None]

    def _rungs(self, name: str, local: list[Rung], taught: list[Rung]) -> list[Rung]:
        """The network that was taught views is above a cloud that would be shown none, and below
        one that is: to most views it has an answer, and none below would be asked."""
        if self.cloud is None:
            return [*local, *taught]
        cloud = Rung(RUNG, self.cloud.expert(name), CLOUD_SHARE, self.cloud.ready)
        return [*local, cloud, *taught] if self._shows_cloud() else [*local, *taught, cloud]

    def _shows_cloud(self) -> bool:
        return self.cloud is not None and self.cloud.cfg.sends_images

    def _by_layout(self, cfg: ExpertConfig) -> list[Rung]:
        """SLE's by a network that was taught views, where it is to be asked."""
        layout, share = self.layout, LOCAL_SHARE if self._shows_cloud() else self._share()
        if cfg.scene_layout == EMBEDDING or layout is None:
            return []
        if isinstance(layout, Unseated):
            why = Missing("sle", Absence.NO_MODEL, layout.why)
            return [Rung(cfg.scene_layout, lambda brief, by: why)]
        head = Rung(HEAD, layout.head(cfg), share)
        if cfg.scene_layout == HEAD:
            return [head]
        return [Rung(LANGUAGE, layout.language(cfg), share, layout.ready), head]

    def _counted(self, cfg: ExpertConfig) -> dict[str, Rung]:
        """By what was counted: above all others where it is to be, else above the text encoder."""
        experts = self.by_count.experts(cfg) if self.by_count is not None else {}
        return {name: Rung(COUNTS, ask) for name, ask in experts.items()}

    def _share(self) -> float:
        return LOCAL_SHARE if self.cloud is None else self.cloud.cfg.local_share

    def _local(self, cfg: ExpertConfig) -> dict[str, Rung]:
        """The rungs of the language models on the robot."""
        share = self._share()
        table: dict[str, Rung] = {}
        if self.by_likelihood is not None:
            scorer = self.by_likelihood.scorer

            def ready(by: Deadline) -> bool:
                return math.isinf(by.at_s) or not scorer.stuck

            beside = self.by_count if cfg.words == "both" else None
            asked = self.by_likelihood.experts(cfg, beside)
            for name, ask in asked.items():
                table[name] = Rung(TOGETHER if beside else LOCAL, ask, share, ready)
        if self.reasoner is not None:
            for name in ("o2f", "r2f", "both"):
                table[name] = Rung(LOCAL, self.reasoner.expert(name), share, self.reasoner.ready)
        if self.vision is not None:
            look = self.vision.look(cfg)
            look = self.vision.expert("sle") if self.looks_in_words else look
            table["sle"] = Rung(LOCAL, look, share, self.vision.ready)
        return table

    def _appeal(self, name: str, cloud: Cloud) -> Expert:
        asked = self._noting(name, cloud.expert(name), RUNG)

        def ask(brief: Brief, by: Deadline) -> Vote | Missing:
            last = self.answered.get(name)
            if last is not None and last[0] is brief and last[1] == RUNG:
                return Missing(name, Absence.HAS_VOTED)
            return asked(brief, by)

        return ask

    def _noting(self, name: str, expert: Expert, highest: str) -> Expert:
        """The expert, and which rung answered for it is remembered."""

        def ask(brief: Brief, by: Deadline) -> Vote | Missing:
            outcome = expert(brief, by)
            if isinstance(outcome, Vote):
                self.answered[name] = brief, outcome.rung, highest
            return outcome

        return ask
