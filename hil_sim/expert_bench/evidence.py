"""Which evidence is worth asking for: each kind of it, and pairs of kinds, on a bank's questions.

A kind is what an expert goes by: O2F and R2F by a language model's likelihoods, by what was counted
in homes, or by both; SLE by the likeness of a view to the goal's place, or by the network that was
taught what lies beyond. What counts is what a vote costs where it decides, against what is fallen
back on for the very same questions.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hil_sim.driving.methods import CLOSEST, GEOMETRY, ONE_STEP, STRICT
from hil_sim.expert_bench.bank import CLEAN, Bank, BenchQuestion
from hil_sim.expert_bench.scene_bank import way_correlation, without_prior
from hil_sim.expert_bench.statistics import Values
from hil_sim.expert_bench.voting import Votes
from runtime.config import Config, load
from runtime.core.types import Ballot, Missing, Vote
from runtime.core.voting import consensus
from runtime.core.voting.likelihood_experts import LEAST_M2, UNKNOWN_WEIGHT
from runtime.core.voting.sight_experts import unknown_weight

LANGUAGE, COUNTS, BOTH, GUESSED = "language", "counts", "both", "guessed"
"""What words go by; guessed: by counts, as if the goal had never been counted."""
COSINE, HEAD = "embedding", "head"
"""What views go by."""
RULES = {"paper": (STRICT, CLOSEST), "sets": GEOMETRY, "prior": ONE_STEP}
"""The paper's rule, with what is fallen back on: the closest, and information gain; and evidence
weighed with unknown area and way."""
ALONE = 'research.consensus_mode="lenient"'

Voter = tuple[str, str]
"""An expert, and what it goes by."""


@dataclass(frozen=True)
class EvidenceKind:
    """One row: its voters; of one alone the word is law, of several two must agree."""

    name: str
    voters: tuple[Voter, ...]


def _words(by: str) -> tuple[Voter, ...]:
    return ("o2f", by), ("r2f", by)


ROWS: tuple[EvidenceKind, ...] = (
    *(EvidenceKind(f"{expert}, {by}", ((expert, by),))
      for expert in ("o2f", "r2f") for by in (LANGUAGE, COUNTS, GUESSED, BOTH)),
    *(EvidenceKind(f"sle, {by}", (("sle", by),)) for by in (COSINE, HEAD)),
    *(EvidenceKind(f"o2f and r2f, {by}", _words(by)) for by in (LANGUAGE, COUNTS, BOTH)),
    EvidenceKind(f"sle, {COSINE} and {HEAD}", (("sle", COSINE), ("sle", HEAD))),
    *(EvidenceKind(f"all three, {words} and {views}", (*_words(words), ("sle", views)))
      for words in (LANGUAGE, COUNTS, BOTH) for views in (COSINE, HEAD)),
)  # fmt: skip


@dataclass(frozen=True)
class Decided:
    """Of a kind under a rule, one value a question, (N,): whether it decided; metres lost where it
    did, and there by what would have been fallen back on (NaN elsewhere); and metres lost in all,
    less those of what is fallen back on."""

    decided: Values
    regret_m: Values
    fallback_m: Values
    gained_m: Values


@dataclass(frozen=True)
class KindRow:
    """`voted`: whether any of its voters has a set, (N,); `way`, `own`: rank correlation of all its
    evidence, with and without the prior of unknown area, with a short way on; `rules`: by rule."""

    voted: Values
    way: Values
    own: Values
    rules: Mapping[str, Decided]


class Witnesses(Protocol):
    """Whoever has the experts; see `Voters`."""

    def asked(self, config: Config, questions: Sequence[BenchQuestion]) -> Votes: ...

    def guessing(self, config: Config, questions: Sequence[BenchQuestion]) -> Votes: ...

    def check(self) -> None: ...


def weigh(bank: Bank, settings: Sequence[str], voters: Witnesses) -> dict[str, KindRow]:
    """All rows. ConfigError for a setting that is unknown."""
    scales = _Scales(bank.questions, tuple(settings), voters)
    rows = {kind.name: scales.row(kind) for kind in ROWS}
    voters.check()
    return rows


class _Scales:
    """A bank, and what each voter said of it."""

    def __init__(
        self, questions: Sequence[BenchQuestion], settings: tuple[str, ...], voters: Witnesses
    ) -> None:
        self._questions, self._settings, self._witnesses = questions, settings, voters
        self._frontiers = [q.frontiers() for q in questions]
        self._votes: dict[tuple[Voter, bool], Votes] = {}

    def row(self, kind: EvidenceKind) -> KindRow:
        ballots = [
            [self._said(voter).of(voter[0], n) for voter in kind.voters]
            for n in range(len(self._questions))
        ]
        voted = [float(any(isinstance(vote, Vote) for vote in cast)) for cast in ballots]
        way, own = self._insight(kind)
        alone = (ALONE,) if len(kind.voters) == 1 else ()
        rules = {
            name: self._decided(load(None, (*self._settings, *rule, *added)), ballots)
            for name, rule in RULES.items()
            for added in [alone if rule is not ONE_STEP else ()]
        }
        return KindRow(np.array(voted), way, own, rules)

    def _said(self, voter: Voter, every: bool = False) -> Votes:
        """`every`: sets of all frontiers with evidence, for their probabilities."""
        if (voter, every) not in self._votes:
            expert, by = voter
            words = COUNTS if by == GUESSED else by
            own = (
                f"research.scene_layout={by}"
                if expert == "sle"
                else f"research.word_evidence={words}"
            )
            bar = ("research.experts_bar=0.0",) if every else ()
            config = load(None, (*self._settings, own, *bar))
            ask = self._witnesses.guessing if by == GUESSED else self._witnesses.asked
            self._votes[voter, every] = ask(config, self._questions)
        return self._votes[voter, every]

    def _insight(self, kind: EvidenceKind) -> tuple[Values, Values]:
        way, own = [], []
        for n, question in enumerate(self._questions):
            nats: dict[int, float] = {}
            for voter in kind.voters:
                vote = self._said(voter, every=True).of(voter[0], n)
                for id, value in _evidence(question, vote).items():
                    nats[id] = round(nats.get(id, 0.0) + value, 6)
            areas = {f.id: f.unknown_m2 + LEAST_M2 for f in question.brief().frontiers}
            prior = {id: x + UNKNOWN_WEIGHT * math.log(areas[id]) for id, x in nats.items()}
            way.append(way_correlation(question, prior))
            own.append(way_correlation(question, nats))
        return np.array(way), np.array(own)

    def _decided(self, config: Config, ballots: Iterable[list[Vote | Missing]]) -> Decided:
        cfg, rows = config.navigate.consensus, []
        for n, cast in enumerate(ballots):
            question, frontiers = self._questions[n], self._frontiers[n]
            order = question.moment.order if cfg.fallback == "geometry" else ()
            stamp_ns = question.moment.briefs[CLEAN].stamp_ns
            by = question.ahead() if cfg.mode == "prior" else None
            made, fallen = (
                consensus.elect(ballot, frontiers, cfg, stamp_ns, "", order, by)
                for ballot in (_ballot(cast), Ballot())
            )
            assert made.frontier is not None  # a question has two that can be reached
            assert fallen.frontier is not None
            lost, else_lost = (question.regrets_m[id] for id in (made.frontier, fallen.frontier))
            known = bool(made.chosen)
            rows.append((known, lost if known else np.nan, else_lost if known else np.nan,
                         lost - else_lost if known else 0.0))  # fmt: skip
        return Decided(*np.array(rows, float).T)


def _evidence(question: BenchQuestion, vote: Vote | Missing) -> dict[int, float]:
    if isinstance(vote, Missing):
        return {}
    return without_prior(question, dict(vote.probabilities), unknown_weight(vote.rung))


def _ballot(cast: Sequence[Vote | Missing]) -> Ballot:
    """Two votes of one expert are two, by what each went by."""
    votes = sorted((v for v in cast if isinstance(v, Vote)), key=lambda v: (v.expert, v.rung))
    return Ballot(tuple(votes), tuple(m for m in cast if isinstance(m, Missing)))
