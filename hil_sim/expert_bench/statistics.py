"""Means with intervals over a bank, resampled by layout: questions of one home are alike."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hil_sim.evaluation.summary import RESAMPLES, Figure

Values = NDArray[np.float64]


class Resampling:
    """95 % percentile intervals of means over questions, each with the name of its layout; whole
    layouts are drawn. The same for every row, so that rows can be compared."""

    # Not scipy.stats.bootstrap: a row that few layouts answer has no mean in some resamples. They
    # are left out here; there one of them makes the whole interval NaN.
    def __init__(self, layouts: Sequence[str], seed: int) -> None:
        self._group = np.unique(np.array(layouts), return_inverse=True)[1]
        self._count = int(self._group.max()) + 1
        share = np.full(self._count, 1 / self._count)
        self._drawn = np.random.default_rng(seed).multinomial(self._count, share, RESAMPLES)

    def mean(self, values: Values) -> Figure:
        """(N,) one a question; NaN ones are left out."""
        known = np.isfinite(values)
        if not known.any():
            return Figure(math.nan, math.nan, math.nan, 0)
        group = self._group[known]
        sums = np.bincount(group, values[known], self._count)
        counts = np.bincount(group, minlength=self._count)
        weights = self._drawn @ counts
        means = (self._drawn @ sums)[weights > 0] / weights[weights > 0]
        low, high = np.percentile(means, (2.5, 97.5))
        return Figure(float(values[known].mean()), float(low), float(high), int(known.sum()))


def rank_correlation(a: Sequence[float], b: Sequence[float]) -> float:
    """Spearman's, ties by their middle rank; NaN where one is constant, or of fewer than three."""
    # Not scipy.stats.spearmanr: it takes a millisecond for the handful of frontiers that there are.
    if len(a) < 3:
        return math.nan
    x, y = (_ranks(np.asarray(values, np.float64)) for values in (a, b))
    spread = math.sqrt(float(x @ x) * float(y @ y))
    return float(x @ y) / spread if spread else math.nan


def _ranks(values: Values) -> Values:
    """(N,) how many others are less than each, ties by half, less the mean of that."""
    ranks: Values = np.sign(values[:, None] - values).sum(axis=1) / 2
    return ranks
