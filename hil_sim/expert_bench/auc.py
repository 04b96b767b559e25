"""Areas under ROC curves with intervals: of one question each name, and of all names' together."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hil_sim.evaluation.summary import RESAMPLES, Figure
from hil_sim.expert_bench.statistics import Values
from hil_sim.expert_bench.view_questions import Floats, Indices
from runtime.core.types import Mask

LEAST = 10
"""Positives and negatives that a name needs, to have an area of its own."""


@dataclass(frozen=True)
class Area:
    """A figure, and what it is in each resample of the homes, (B,); `n` names or questions."""

    mean: float
    drawn: Values
    n: int

    @property
    def figure(self) -> Figure:
        """With its 95 % percentile interval."""
        known = self.drawn[np.isfinite(self.drawn)]
        if not self.n or not known.size:
            return Figure(math.nan, math.nan, math.nan, 0)
        low, high = np.percentile(known, (2.5, 97.5))
        return Figure(self.mean, float(low), float(high), self.n)

    def minus(self, other: "Area") -> "Area":
        """Paired: both have been resampled alike."""
        n = min(self.n, other.n)
        return Area(self.mean - other.mean, self.drawn - other.drawn, n)


class HomeAreas:
    """Areas over rows of homes; whole homes are drawn, the same for all areas, so that any two can
    be compared."""

    def __init__(self, homes: Sequence[str], seed: int) -> None:
        self._home = np.unique(np.array(homes), return_inverse=True)[1]
        self._count = int(self._home.max()) + 1
        share = np.full(self._count, 1 / self._count)
        drawn = np.random.default_rng(seed).multinomial(self._count, share, RESAMPLES)
        self._drawn = drawn.astype(np.float64)

    def macro(self, scores: Floats, asked: Mask, true: Mask, names: Indices) -> Area:
        """Mean area over those of the `names`, columns of (N, K), that have LEAST answers of each
        kind. In a resample without one of both kinds a name is left out."""
        found = []
        for k in names:
            positive, negative = asked[:, k] & true[:, k], asked[:, k] & ~true[:, k]
            if min(positive.sum(), negative.sum()) >= LEAST:
                found.append(self._area(self._home, scores[:, k], positive, negative))
        if not found:
            return Area(math.nan, np.full(RESAMPLES, np.nan), 0)
        drawn = np.array([a.drawn for a in found])
        known = np.isfinite(drawn)
        mean = np.where(known, drawn, 0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        drawn = np.where(known.any(axis=0), mean, np.nan)
        return Area(float(np.mean([a.mean for a in found])), drawn, len(found))

    def micro(self, scores: Floats, asked: Mask, true: Mask, names: Indices) -> Area:
        """The area over the questions about all the `names` at once."""
        rows, cols = np.nonzero(asked[:, names])
        values, answers = scores[:, names][rows, cols], true[:, names][rows, cols]
        return self._area(self._home[rows], values, answers, ~answers)

    def share(self, right: Mask) -> Area:
        """How many of the rows (N,) are right."""
        hits = np.bincount(self._home, right, self._count)
        totals = np.bincount(self._home, minlength=self._count)
        with np.errstate(invalid="ignore"):
            drawn = (self._drawn @ hits) / (self._drawn @ totals)
        return Area(float(right.mean()), drawn, len(right))

    def _area(self, home: Indices, scores: Floats, positive: Mask, negative: Mask) -> Area:
        """Share of pairs (positive, negative) in which the positive's score is higher; ties count
        half."""
        wins = np.zeros((self._count, self._count))
        homes, values = home[positive], scores[positive]
        for other in range(self._count):
            below = np.sort(scores[negative & (home == other)])
            ranks = np.searchsorted(below, values, "left") + np.searchsorted(below, values, "right")
            wins[:, other] = np.bincount(homes, ranks / 2, self._count)
        yes = np.bincount(homes, minlength=self._count)
        no = np.bincount(home[negative], minlength=self._count)
        pairs = (self._drawn @ yes) * (self._drawn @ no)
        with np.errstate(invalid="ignore"):
            drawn = ((self._drawn @ wins) * self._drawn).sum(axis=1) / pairs
        whole = yes.sum() * no.sum()
        mean = float(wins.sum() / whole) if whole else math.nan
        return Area(mean, drawn, int(yes.sum() + no.sum()))
