"""The scene-layout expert in a bank: how often it votes, whether its evidence knows the way, if it
is the picture that decides, and what the vote loses with it."""

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hil_sim.expert_bench.bank import CLEAN, Bank, BenchQuestion, Moment
from hil_sim.expert_bench.judge import CONSENSUS, METHODS, Bench, Electorate
from hil_sim.expert_bench.scene_bars import BarRow, judge_bars
from hil_sim.expert_bench.statistics import Values, rank_correlation
from runtime.config import Config, load
from runtime.core.types import Brief, FrontierBrief, Missing, Vote
from runtime.core.voting.likelihood_experts import LEAST_M2
from runtime.core.voting.sight_experts import unknown_weight

EXPERT, RIVAL = "sle", "r2f"
LEAST_P = 1e-300
GATE = ("sle", CONSENSUS, f"{CONSENSUS}+geometry")
"""Methods whose regret decides which kind is the default: the expert alone, the paper's rule, the
runtime as it is."""


@dataclass(frozen=True)
class Insight:
    """Rank correlations of evidence with a short way on, (N,) one a question, NaN where there is
    nothing to compare: `own` without the prior that all experts have, the unknown area behind a
    frontier, and `voted` with it."""

    own: Values
    voted: Values


@dataclass(frozen=True)
class SceneRows:
    """What one kind of the expert came to on a bank's questions, (N,) each. `votes`: it voted, NaN
    where fewer than two frontiers have a view. `shuffled`: the same evidence after each frontier
    was given another's picture, NaN where not all could be; `kept`: on these questions as it was.
    `regret_m` by method of GATE, and `absent_m` by those where others vote too, without its vote.
    `rungs`: of its votes, how many came by which rung; `bars`: the same votes by other bars."""

    votes: Values
    insight: Insight
    rival: Insight
    shuffled: Insight
    kept: Insight
    regret_m: Mapping[str, Values]
    absent_m: Mapping[str, Values]
    rungs: Mapping[str, int]
    bars: Mapping[float, BarRow]


def judge_scene(
    bank: Bank, settings: Sequence[str], voters: Electorate, seed: int = 0
) -> SceneRows:
    """One kind, as the settings have it."""
    config = load(None, (*settings, *METHODS[CONSENSUS]))
    bench, questions = Bench(bank, voters, seed), bank.questions
    insight = _insight(config, bank, voters, EXPERT)
    mixed = Bank(tuple(shuffled(q, seed) for q in questions))
    moved = np.array([_all_moved(q, m) for q, m in zip(questions, mixed.questions, strict=True)])
    other, cast = _insight(config, mixed, voters, EXPERT), voters.asked(config, questions)
    votes, rungs = [], dict[str, int]()
    for number, question in enumerate(questions):
        vote = cast.of(EXPERT, number)
        votes.append(float(isinstance(vote, Vote)) if _viewed(question) > 1 else np.nan)
        if isinstance(vote, Vote):
            rungs[vote.rung] = rungs.get(vote.rung, 0) + 1
    methods = {name: load(None, (*settings, *METHODS[name])) for name in GATE}
    rows = {name: bench.row(method, CLEAN) for name, method in methods.items()}
    absent = {
        name: bench.spoilt(method, "one absent", EXPERT)
        for name, method in methods.items()
        if name != EXPERT
    }
    viewed = [_viewed(question) > 1 for question in questions]
    bars = judge_bars(bank, bench, voters, methods, EXPERT, viewed)
    voters.check()
    return SceneRows(
        np.array(votes),
        insight,
        _insight(config, bank, voters, RIVAL),
        Insight(np.where(moved, other.own, np.nan), np.where(moved, other.voted, np.nan)),
        Insight(np.where(moved, insight.own, np.nan), np.where(moved, insight.voted, np.nan)),
        {name: row.regret_m for name, row in rows.items()},
        {name: row.regret_m for name, row in absent.items()},
        dict(sorted(rungs.items())),
        bars,
    )


def prior_insight(bank: Bank) -> Values:
    """(N,) the same of the prior alone."""
    found = []
    for question in bank.questions:
        areas = {f.id: f.unknown_m2 for f in question.brief().frontiers}
        found.append(way_correlation(question, areas))
    return np.array(found)


def shuffled(question: BenchQuestion, seed: int) -> BenchQuestion:
    """The question with each frontier shown another one's picture, and still asked about its own
    place in it: goal and way stay, what is seen does not. The same for all goals of a moment."""
    moment = question.moment
    mixed = {CLEAN: mixed_up(moment.briefs[CLEAN], _place(moment, seed))}
    return replace(question, moment=replace(moment, briefs={**moment.briefs, **mixed}))


def mixed_up(brief: Brief, place: str) -> Brief:
    """Frontiers in groups of one picture each, the groups in an order that `place` draws: each gets
    the picture that comes as many frontiers later as the largest group has. Then all get another
    one, where no group is more than half."""
    groups: dict[bytes, list[FrontierBrief]] = {}
    for frontier in brief.frontiers:
        if frontier.view.size:
            groups.setdefault(frontier.view.tobytes(), []).append(frontier)
    order = [groups[key] for key in sorted(groups)]
    random.Random(place).shuffle(order)
    row = [frontier for group in order for frontier in group]
    step = max((len(group) for group in order), default=0)
    given = {f.id: row[(n + step) % len(row)] for n, f in enumerate(row)}
    changed = (_shown(f, given[f.id]) if f.id in given else f for f in brief.frontiers)
    return replace(brief, frontiers=tuple(changed))


def _shown(frontier: FrontierBrief, other: FrontierBrief) -> FrontierBrief:
    """A frontier with the other's picture."""
    sight = other.sight
    if sight is not None and frontier.sight is not None:
        at = frontier.sight
        sight = replace(sight, column=at.column, range_m=at.range_m)
    return replace(frontier, view=other.view, image=other.image, sight=sight)


def _place(moment: Moment, seed: int) -> str:
    return f"{seed}/{moment.home}/{moment.drive}/{moment.step}"


def _all_moved(question: BenchQuestion, mixed: BenchQuestion) -> bool:
    """Whether all frontiers with a view, two at least, have another one's picture."""
    pairs = zip(question.brief().frontiers, mixed.brief().frontiers, strict=True)
    same = [a.view.tobytes() == b.view.tobytes() for a, b in pairs if a.view.size]
    return len(same) > 1 and not any(same)


def _viewed(question: BenchQuestion) -> int:
    return sum(f.view.size > 0 for f in question.brief().frontiers)


def _insight(config: Config, bank: Bank, voters: Electorate, expert: str) -> Insight:
    """Of votes that name every frontier with evidence. The prior is divided out of their
    probabilities again: ranks are those of the evidence."""
    every = replace(config, experts=replace(config.experts, bar=0.0))
    cast, own, voted = voters.asked(every, bank.questions), [], []
    for number, question in enumerate(bank.questions):
        vote = cast.of(expert, number)
        p = {} if isinstance(vote, Missing) else dict(vote.probabilities)
        weight = unknown_weight(getattr(vote, "rung", ""))
        own.append(way_correlation(question, without_prior(question, p, weight)))
        voted.append(way_correlation(question, p))
    return Insight(np.array(own), np.array(voted))


def without_prior(
    question: BenchQuestion, p: Mapping[int, float], weight: float
) -> dict[int, float]:
    """Evidence over the temperature, up to a constant; equal where it was equal."""
    area = {f.id: f.unknown_m2 + LEAST_M2 for f in question.brief().frontiers}
    return {
        id: round(math.log(max(share, LEAST_P)) - weight * math.log(area[id]), 6)
        for id, share in p.items()
    }


def way_correlation(question: BenchQuestion, evidence: Mapping[int, float]) -> float:
    way = {f.id: f.distance_m for f in question.brief().frontiers}
    onward = [question.costs_m[id] - way[id] for id in evidence]
    return rank_correlation(list(evidence.values()), [-metres for metres in onward])
