"""How good the evidence of a scene-layout expert is, on homes that nothing was trained on."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from models.train.beyond_data import Homes, Moments

Floats = NDArray[np.float64]
LEAST_POSITIVES = 10
"""Of a name, to be counted."""
UNKNOWN_WEIGHT, LEAST_M2, TEMPERATURE = 0.5, 0.2, 0.6
"""Of the vote's prior, and of its softmax over frontiers: runtime.core.voting.likelihood_experts.
Both networks are taught beside this prior; a vote by the head alone weighs it less,
runtime.core.voting.sight_experts.HEAD_UNKNOWN_WEIGHT."""
REFERENCES = ("bed", "table", "toilet", "refrigerator", "lamp", "desk", "plant")
"""What the evidence of a name is measured against: runtime.core.voting.sight_experts."""


@dataclass(frozen=True)
class Scores:
    """Macro AUC of "is there an X beyond" for names that were taught and that never were; mean
    rank correlation of the evidence, and of it with the vote's prior, with a short way on; macro
    AUC of "is there an X in view"; room type of a view."""

    beyond: float
    beyond_never: float
    onward: float
    onward_prior: float
    view: float = float("nan")
    view_never: float = float("nan")
    room: float = float("nan")

    def told(self) -> str:
        """One line."""
        return ", ".join(f"{name} {value:.3f}" for name, value in asdict(self).items())


def judge(evidence: Floats, homes: Homes, rows: NDArray[np.int64], taught: NDArray[np.bool_],
          moments: Moments) -> Scores:  # fmt: skip
    """`evidence` (N, K) nats of all rows; AUC is of `rows`."""
    known, there = homes.known()[rows], homes.there()[rows]
    by_name = [
        auc(evidence[rows, k], there[:, k], known[:, k]) for k in range(len(homes.categories))
    ]
    return Scores(*split(by_name, taught), *onward(evidence, homes, moments))


def split(by_name: list[float], taught: NDArray[np.bool_]) -> tuple[float, float]:
    """Means of names that were taught and of those that were not."""
    value = np.array(by_name)
    return tuple(float(np.nanmean(v)) if np.isfinite(v := value[side]).any() else float("nan")
                 for side in (taught, ~taught))  # type: ignore[return-value] # fmt: skip


def auc(score: Floats, positive: NDArray[np.bool_], counted: NDArray[np.bool_]) -> float:
    """Area under the curve; nan for a name with too few of either."""
    score, positive = score[counted], positive[counted]
    ones = int(positive.sum())
    zeros = len(positive) - ones
    if min(ones, zeros) < LEAST_POSITIVES:
        return float("nan")
    _, inverse, count = np.unique(score, return_inverse=True, return_counts=True)
    rank = (np.cumsum(count) - (count - 1) / 2)[inverse]
    return float((rank[positive].sum() - ones * (ones + 1) / 2) / (ones * zeros))


def onward(evidence: Floats, homes: Homes, moments: Moments) -> tuple[float, float]:
    """Spearman's correlation with a short way on, mean over moments and what is asked there; of
    the evidence, and of it with the prior."""
    rows = moments.best()
    there = rows >= 0
    prior = UNKNOWN_WEIGHT * np.log(homes.unknown_m2 + LEAST_M2)[:, None]
    found = []
    for values in (evidence, evidence + prior):
        each = []
        for k in range(len(homes.categories)):
            way = homes.onward_m[rows, k].astype(np.float64)
            counted = there & homes.asked[rows, k] & np.isfinite(way)
            asked = counted.sum(axis=1) >= 2
            each.append(correlation(values[rows[asked], k], -way[asked], counted[asked]))
        every = np.concatenate(each)
        found.append(float(np.nanmean(every)) if np.isfinite(every).any() else float("nan"))
    return found[0], found[1]


def correlation(a: Floats, b: Floats, counted: NDArray[np.bool_]) -> Floats:
    """(M, G) twice, which of them count -> (M,) rank correlations; nan where one is constant."""
    mine, theirs = (_centred(_ranks(x, counted), counted) for x in (a, b))
    norm = np.sqrt((mine**2).sum(axis=1) * (theirs**2).sum(axis=1))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(norm > 0, (mine * theirs).sum(axis=1) / norm, np.nan)


def _ranks(x: Floats, counted: NDArray[np.bool_]) -> Floats:
    x = np.where(counted, x, np.nan)
    below = (x[:, None, :] < x[:, :, None]).sum(axis=2)
    same = (x[:, None, :] == x[:, :, None]).sum(axis=2)
    return np.asarray(below + same / 2, np.float64)


def _centred(x: Floats, counted: NDArray[np.bool_]) -> Floats:
    mean = (x * counted).sum(axis=1) / np.maximum(counted.sum(axis=1), 1)
    return (x - mean[:, None]) * counted


def by_table(train: Homes, homes: Homes) -> Floats:
    """(N, K) what the room that the detector sees, times how often things lie beyond a frontier
    that is seen from such a room, says; log of the probability, Laplace's rule."""
    weight = train.rooms[train.frame].astype(np.float64)
    known = train.known()
    there = known & train.there()
    share = (weight.T @ there + 1) / (weight.T @ known + 2)
    return np.log(homes.rooms[homes.frame].astype(np.float64) @ share + 1e-6)
