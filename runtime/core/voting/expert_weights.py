"""How far each expert's evidence can be relied on, learned with hindsight.

When a search ends at its target, the map tells what every earlier choice would have cost: the way
on from each frontier to where the target was found. Regressed on what the experts said of those
frontiers, that gives the metres of way that a nat of each one's evidence was worth: the weights of
consensus mode "weighted". They are drawn toward those in the configuration until there is much
to learn from, and never negative: an expert that misleads is not listened to, not turned around.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from runtime.core.types import F64, Vote
from runtime.core.voting.comparison_modes import evidence

PRIOR_DECISIONS = 30.0
"""How many decisions the configured weights count for, of experts that differ by a nat."""


@dataclass(frozen=True)
class NormalEquations:
    """Of the regression, as sums over the decisions that were learned from, in whatever order."""

    experts: tuple[str, ...]
    products: F64  # (E, E) of evidence, nats squared
    saved: F64  # (E,) of evidence and the way it saved, nats times metres
    decisions: int = 0

    @classmethod
    def of(cls, experts: Iterable[str]) -> "NormalEquations":
        """Nothing learned yet."""
        names = tuple(sorted(set(experts)))
        return cls(names, np.zeros((len(names), len(names))), np.zeros(len(names)))


def learned(
    before: NormalEquations, votes: Sequence[Vote], onward_m: Mapping[int, float]
) -> NormalEquations:
    """With one more decision: its votes, and the way on to the target from each frontier, as it
    turned out. Frontiers that no way leads from are left out; of one alone nothing is learned."""
    known = {id: way for id, way in onward_m.items() if np.isfinite(way)}
    if len(known) < 2 or not votes:
        return before
    ids = sorted(known)
    by_name = {v.expert: evidence(v, known) for v in votes}
    nats = np.array([[by_name.get(e, {}).get(i, 0.0) for e in before.experts] for i in ids])
    nats -= nats.mean(axis=0)
    way = np.array([known[i] for i in ids])
    saved = way.mean() - way
    return NormalEquations(
        before.experts,
        before.products + nats.T @ nats / len(ids),
        before.saved + nats.T @ saved / len(ids),
        before.decisions + 1,
    )


def weights(
    equations: NormalEquations, prior: Mapping[str, float], decisions: float = PRIOR_DECISIONS
) -> tuple[tuple[str, float], ...]:
    """Metres a nat by expert: least squares, ridged toward `prior` as if that had been learned from
    so many decisions, none below 0."""
    start = np.array([prior.get(name, 0.0) for name in equations.experts])
    matrix = equations.products + decisions * np.eye(len(start))
    target = equations.saved + decisions * start
    found = np.zeros(len(start))
    used = np.ones(len(start), bool)
    while used.any():  # whoever is below 0 goes, and the others are asked again without it
        found[:] = 0.0
        found[used] = np.linalg.solve(matrix[np.ix_(used, used)], target[used])
        if (found >= 0).all():
            break
        used &= found > 0
    return tuple(
        (e, round(max(0.0, float(w)), 4)) for e, w in zip(equations.experts, found, strict=True)
    )
