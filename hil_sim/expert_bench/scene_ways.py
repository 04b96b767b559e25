"""Whether evidence about views knows the way: in moments of held-out homes, over the frontiers that
have a view."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hil_sim.evaluation.summary import Figure
from hil_sim.expert_bench.statistics import Resampling, Values, rank_correlation
from hil_sim.expert_bench.view_questions import Floats, Indices, ViewQuestions, WaysOn
from hil_sim.ground_truth.labels import LABELLED
from runtime.core.voting.likelihood_experts import LEAST_M2, UNKNOWN_WEIGHT, ExpertConfig
from runtime.core.voting.sight_experts import unknown_weight

PRIOR = "the prior alone"


@dataclass(frozen=True)
class WayFigures:
    """Mean rank correlations of evidence with a short way on, over moments and things asked for:
    `own`, and `voted` with the prior of unknown area, as a vote weighs both."""

    own: Figure
    voted: Figure


def judge_ways(
    questions: ViewQuestions, ways: WaysOn, scores: Mapping[str, Floats], names: Indices, seed: int
) -> dict[str, WayFigures]:
    """By judge, from scores (N, C) in nats; and of the prior alone."""
    cases = _cases(questions, ways, names)
    if not cases:
        return {}
    drawn = Resampling([questions.sights.home[rows[0]] for rows, _ in cases], seed)
    prior = prior_scores(ways.unknown_m2)

    def correlated(values: Floats) -> Figure:
        return drawn.mean(_correlations(values, ways, cases))

    found = {
        judge: WayFigures(correlated(nats), correlated(with_prior(judge, nats, prior)))
        for judge, nats in scores.items()
    }
    none = Figure(math.nan, math.nan, math.nan, 0)
    return {**found, PRIOR: WayFigures(none, correlated(prior))}


def prior_scores(unknown_m2: Floats) -> NDArray[np.float64]:
    """(N,) of the briefs -> (N, C) what a vote adds for it, whatever is looked for."""
    nats = UNKNOWN_WEIGHT * np.log(unknown_m2.astype(np.float64) + LEAST_M2)
    return np.repeat(nats[:, None], len(LABELLED), axis=1)


def with_prior(judge: str, nats: Floats, prior: Floats) -> Floats:
    """Evidence and prior as a judge's vote weighs them."""
    share = unknown_weight(judge) / UNKNOWN_WEIGHT
    return np.asarray(nats / ExpertConfig().temperature + share * prior, np.float64)


def _cases(questions: ViewQuestions, ways: WaysOn, names: Indices) -> list[tuple[Indices, int]]:
    """Rows of one moment that have a way on to a thing, three at least, and its category."""
    found = []
    for moment in np.unique(ways.moment):
        at = np.flatnonzero(ways.moment == moment)
        for name in names.tolist():
            rows = at[np.isfinite(ways.onward_m[at, name]) & questions.asked[at, name]]
            if len(rows) > 2:
                found.append((rows, name))
    return found


def _correlations(values: Floats, ways: WaysOn, cases: list[tuple[Indices, int]]) -> Values:
    """(cases,) NaN where all ways, or all values, are the same."""
    return np.array([
        rank_correlation(np.round(values[rows, name], 9).tolist(),
                         (-ways.onward_m[rows, name]).tolist())
        for rows, name in cases
    ])  # fmt: skip
