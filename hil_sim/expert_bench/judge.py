"""How far each method's choices are from the best ones: regret(f) = cost(f) - least cost.

with Voters() as voters:
    table = judge(load_bank(folder, "fit"), ("research.experts_bar=1.3",), voters=voters)
    print(table.rows["consensus"][CLEAN].regret_m.mean())
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from hil_sim.driving.methods import CLOSEST, LANGUAGE, SINGLE
from hil_sim.expert_bench.bank import CLEAN, Bank, BenchQuestion
from hil_sim.expert_bench.statistics import Values, rank_correlation
from hil_sim.expert_bench.voting import Voters, Votes, at_random
from runtime.config import Config, load
from runtime.core.types import Absence, Ballot, Missing, Vote
from runtime.core.voting import consensus
from runtime.experts.panel import SEATED

CONSENSUS, NEAR, RANDOM = "consensus", "consensus, 1 m", "random"
METHODS: dict[str, tuple[str, ...]] = {
    **{name: SINGLE[name].settings for name in (
        "closest", "geometry", "single-llm", "majority-k3", "majority-k5", "o2f", "r2f", "sle",
        "o2f+r2f", "o2f+sle", "r2f+sle")},
    "lenient": ('research.consensus_mode="lenient"', CLOSEST, LANGUAGE),
    "consensus+geometry": SINGLE["sets"].settings,
    NEAR: (*SINGLE["paper"].settings, "research.consensus_detour_m=1.0"),
    CONSENSUS: SINGLE["paper"].settings,
}  # fmt: skip
"""The runtime's settings for each row; `consensus` is the paper's rule, `NEAR` that where no vote
wins what is more than a metre farther than the closest, `consensus+geometry` that where
information gain is fallen back on."""
WEIGHTED = ('research.consensus_mode="weighted"', "research.experts_bar=0.0", CLOSEST)
RIGHT_M = 0.25
"""A choice that costs no more than this over the best is right."""
BRIEFS = (CLEAN, "wrong labels", "missing objects")
SPOILT = ("one at random", "one absent")
CONDITIONS = (*BRIEFS, *SPOILT)
"""A spoilt condition is the mean over the method's experts, each spoilt in its turn."""


@dataclass(frozen=True)
class Row:
    """What one method's choices came to under one condition, one value a question, (N,): metres
    lost; whether the choice was right, and whether it was the worst there is (0..1); whether
    the experts chose, and not what is fallen back on (NaN where nobody votes)."""

    regret_m: Values
    right: Values
    worst: Values
    voted: Values


@dataclass(frozen=True)
class ExpertLikeness:
    """How far two experts say the same. Of the questions: share on which both vote; of those,
    share with a frontier in common, and what it would be by chance; and the rank correlation of
    their evidence, set or no set. Values (N,), NaN where there is nothing to compare."""

    both_vote: Values
    overlap: Values
    by_chance: Values
    correlation: Values


@dataclass(frozen=True)
class Table:
    """Rows by method and condition; `spoilt` has, for each expert, the consensus' row when that
    one answers at random or is absent; `votes` each expert's shares of outcomes."""

    layouts: tuple[str, ...]  # of the questions
    rows: Mapping[str, Mapping[str, Row]]
    spoilt: Mapping[str, Mapping[str, Row]]
    votes: Mapping[str, Mapping[str, float]]
    insight: Mapping[str, Values]  # rank correlation of evidence with a short way on
    likeness: Mapping[tuple[str, str], ExpertLikeness]


class Electorate(Protocol):
    """Whoever has the experts; see `Voters`."""

    def asked(self, config: Config, questions: Sequence[BenchQuestion]) -> Votes: ...

    def check(self) -> None: ...


def judge(
    bank: Bank,
    settings: Sequence[str] = (),
    voters: Electorate | None = None,
    conditions: Sequence[str] = (CLEAN,),
    seed: int = 0,
) -> Table:
    """Judge all methods on a bank; `settings` are the runtime's, KEY=VALUE. Without `voters` the
    models are loaded for this call alone. Raises ConfigError for a setting that is unknown."""
    if voters is None:
        with Voters(settings) as own:
            own.warm(bank, [name for name in conditions if name in BRIEFS])
            return judge(bank, settings, own, conditions, seed)
    bench = Bench(bank, voters, seed)
    rows = {RANDOM: dict.fromkeys(conditions, _anything(bank))}
    for name, own_settings in _methods(settings).items():
        config = load(None, (*settings, *own_settings))
        rows[name] = {condition: bench.row(config, condition) for condition in conditions}
    config = load(None, (*settings, *METHODS[CONSENSUS]))
    table = Table(
        tuple(q.layout for q in bank.questions),
        rows,
        {kind: {e: bench.spoilt(config, kind, e) for e in config.panel.experts}
         for kind in SPOILT if kind in conditions},
        {e: bench.outcomes(config, e) for e in SEATED},
        {e: bench.insight(config, e) for e in SEATED},
        {(a, b): bench.likeness(config, a, b)
         for a, b in (("o2f", "r2f"), ("o2f", "sle"), ("r2f", "sle"))},
    )  # fmt: skip
    voters.check()
    return table


def _methods(settings: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """All of them; evidence is only weighed where there are weights."""
    weighted = load(None, settings).navigate.consensus.weights
    return METHODS | ({"weighted": WEIGHTED} if weighted else {})


class Bench:
    """A bank, and the votes on it that were worked out so far."""

    def __init__(self, bank: Bank, voters: Electorate, seed: int) -> None:
        self._questions, self._voters, self._seed = bank.questions, voters, seed
        self._frontiers = [q.frontiers() for q in bank.questions]
        self._votes: dict[object, Votes] = {}

    def row(self, config: Config, condition: str) -> Row:
        """One method under one condition."""
        seats = config.panel.experts
        if not seats:
            condition = CLEAN  # nobody to be misled
        if condition in SPOILT:
            return _mean([self.spoilt(config, condition, expert) for expert in seats])
        votes = self._votes_under(config)
        return self._chosen(
            config, ([votes.of(e, n, condition) for e in seats] for n in self._numbers())
        )

    def spoilt(self, config: Config, kind: str, expert: str) -> Row:
        """One method with one of its experts spoilt."""

        def vote(number: int) -> Vote | Missing:
            if kind == "one absent":
                return Missing(expert, Absence.LATE)
            return at_random(expert, self._questions[number], self._seed)

        return self.voting_so(config, expert, vote)

    def voting_so(self, config: Config, expert: str, cast: Callable[[int], Vote | Missing]) -> Row:
        """One method with one of its experts' votes given, by the question's number."""
        votes, seats = self._votes_under(config), config.panel.experts

        def vote(name: str, number: int) -> Vote | Missing:
            return cast(number) if name == expert else votes.of(name, number)

        return self._chosen(config, ([vote(e, n) for e in seats] for n in self._numbers()))

    def outcomes(self, config: Config, expert: str) -> dict[str, float]:
        """Shares of an expert's votes and of its reasons for abstaining."""
        votes, found = self._votes_under(config), dict[str, float]()
        for number in self._numbers():
            vote = votes.of(expert, number)
            outcome = vote.why.value if isinstance(vote, Missing) else "voted"
            found[outcome] = found.get(outcome, 0.0) + 1.0 / len(self._questions)
        return dict(sorted(found.items()))

    def insight(self, config: Config, expert: str) -> Values:
        """(N,) rank correlation of its evidence with how short the way on from a frontier is."""
        votes, found = self._evidence(config), []
        for number, question in enumerate(self._questions):
            p = _shares(votes.of(expert, number))
            onward = {f.id: question.costs_m[f.id] - f.distance_m for f in self._frontiers[number]}
            found.append(rank_correlation(list(p.values()), [-onward[id] for id in p]))
        return np.array(found)

    def likeness(self, config: Config, one: str, other: str) -> ExpertLikeness:
        """Two experts compared."""
        votes, evidence = self._votes_under(config), self._evidence(config)
        rows = []
        for number, question in enumerate(self._questions):
            a, b = (_set(votes.of(e, number)) for e in (one, other))
            p, q = (_shares(evidence.of(e, number)) for e in (one, other))
            common = [id for id in p if id in q]
            alike = rank_correlation([p[id] for id in common], [q[id] for id in common])
            both = bool(a and b)
            chance = _chance(len(a), len(b), len(question.costs_m)) if both else np.nan
            rows.append((both, bool(a & b) if both else np.nan, chance, alike))
        return ExpertLikeness(*np.array(rows, float).T)

    def _votes_under(self, config: Config) -> Votes:
        if config.experts not in self._votes:
            self._votes[config.experts] = self._voters.asked(config, self._questions)
        return self._votes[config.experts]

    def _evidence(self, config: Config) -> Votes:
        """Votes that name every frontier with evidence."""
        return self._votes_under(replace(config, experts=replace(config.experts, bar=0.0)))

    def _numbers(self) -> range:
        return range(len(self._questions))

    def _chosen(self, config: Config, ballots: Iterable[list[Vote | Missing]]) -> Row:
        cfg, rows = config.navigate.consensus, []
        for number, cast in enumerate(ballots):
            question = self._questions[number]
            order = question.moment.order if cfg.fallback == "geometry" else ()
            stamp_ns = question.moment.briefs[CLEAN].stamp_ns
            made = consensus.elect(
                _ballot(cast), self._frontiers[number], cfg, stamp_ns, order=order
            )
            assert made.frontier is not None  # a question has two that can be reached
            regrets = question.regrets_m
            lost, most = regrets[made.frontier], max(regrets.values())
            voted = float(bool(made.chosen)) if cast else np.nan
            rows.append((lost, lost < RIGHT_M, lost >= most, voted))
        return Row(*np.array(rows, float).T)


def _anything(bank: Bank) -> Row:
    """What any frontier, drawn at random, may be expected to come to."""
    rows = []
    for question in bank.questions:
        lost = np.array(list(question.regrets_m.values()))
        rows.append((lost.mean(), (lost < RIGHT_M).mean(), (lost >= lost.max()).mean(), np.nan))
    return Row(*np.array(rows, float).T)


def _mean(rows: Sequence[Row]) -> Row:
    columns = np.array([[r.regret_m, r.right, r.worst, r.voted] for r in rows])
    return Row(*columns.mean(axis=0))


def _ballot(cast: Sequence[Vote | Missing]) -> Ballot:
    votes = tuple(sorted((v for v in cast if isinstance(v, Vote)), key=lambda v: v.expert))
    return Ballot(votes, tuple(m for m in cast if isinstance(m, Missing)))


def _set(vote: Vote | Missing) -> frozenset[int]:
    return frozenset(vote.frontiers) if isinstance(vote, Vote) else frozenset()


def _shares(vote: Vote | Missing) -> dict[int, float]:
    return dict(vote.probabilities) if isinstance(vote, Vote) else {}


def _chance(a: int, b: int, n: int) -> float:
    """That two random sets of these sizes, out of n, have something in common."""
    apart = 1.0
    for taken in range(b):
        apart *= max(0, n - a - taken) / (n - taken)
    return 1.0 - apart
