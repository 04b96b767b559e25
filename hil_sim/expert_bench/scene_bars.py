"""How often the scene-layout expert votes, and what is lost by it, by how high its bar is."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hil_sim.expert_bench.bank import Bank
from hil_sim.expert_bench.judge import Bench, Electorate
from hil_sim.expert_bench.statistics import Values
from runtime.config import Config
from runtime.core.types import Absence, Missing, Vote

BARS = (1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.5)
"""A frontier of n is recommended from a probability of bar / n on."""
WANTED = 0.6
"""Share of the questions that it is to vote on: the bar for that is looked for."""


@dataclass(frozen=True)
class BarRow:
    """What one bar comes to: `votes` (N,), it voted, NaN where fewer than two frontiers have a
    view; `regret_m` (N,) by method."""

    votes: Values
    regret_m: Mapping[str, Values]


def judge_bars(
    bank: Bank,
    bench: Bench,
    voters: Electorate,
    methods: Mapping[str, Config],
    expert: str,
    viewed: Sequence[bool],
) -> dict[float, BarRow]:
    """By bar, in order; the others' bars stay as they are. `methods` by name; of the questions,
    `viewed` are those with two frontiers to choose between by sight."""
    first = next(iter(methods.values()))
    everything = replace(first, experts=replace(first.experts, bar=0.0))
    asked = voters.asked(everything, bank.questions)
    cast = [asked.of(expert, number) for number in range(len(bank.questions))]
    most = [_height(vote) for vote, seen in zip(cast, viewed, strict=True) if seen]
    wanted = [math.floor(100 * np.quantile(most, 1.0 - WANTED)) / 100] if most else []
    rows = {}
    for bar in sorted({*BARS, *wanted}):
        above = [_above(vote, bar) for vote in cast]
        voted = [isinstance(vote, Vote) for vote in above]
        rows[bar] = BarRow(
            np.where(viewed, voted, np.nan).astype(np.float64),
            {
                name: bench.voting_so(config, expert, above.__getitem__).regret_m
                for name, config in methods.items()
            },
        )
    return rows


def _height(vote: Vote | Missing) -> float:
    """The bar up to which it votes, 0 where it has no evidence."""
    if isinstance(vote, Missing):
        return 0.0
    return max(p for _, p in vote.probabilities) * len(vote.probabilities)


def _above(vote: Vote | Missing, bar: float) -> Vote | Missing:
    """Of a vote that names all, those above the bar."""
    if isinstance(vote, Missing):
        return vote
    least = bar / len(vote.probabilities)
    chosen = tuple(i for i, p in vote.probabilities if p >= least)
    if not chosen:
        return Missing(vote.expert, Absence.NO_PREFERENCE)
    return replace(vote, frontiers=chosen)
