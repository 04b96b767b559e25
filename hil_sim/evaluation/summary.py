"""A method's figures over episodes: means with 95 % bootstrap intervals."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.stats

from hil_sim.ground_truth.metrics import TRIVIAL_M, Outcome, soft_spl, spl

RESAMPLES = 10_000


@dataclass(frozen=True)
class Figure:
    """A mean and its 95 % bootstrap interval over `n` episodes; NaN when there are none."""

    mean: float
    low: float
    high: float
    n: int


@dataclass(frozen=True)
class Summary:
    """One method's row in the table."""

    episodes: int
    trivial: int  # left out of SPL and SoftSPL
    cut_off: int  # ended where no way leads to success: left out of DTS
    success: Figure
    spl: Figure
    soft_spl: Figure
    distance_m: Figure
    steps: Figure


def summarise(outcomes: Sequence[Outcome], seed: int = 0) -> Summary:
    """All figures of one method; the same seed gives the same intervals."""
    weighted = [(spl(o), soft_spl(o)) for o in outcomes]
    ends = [o.distance_m for o in outcomes if math.isfinite(o.distance_m)]
    return Summary(
        episodes=len(outcomes),
        trivial=sum(value is None for value, _ in weighted),
        cut_off=len(outcomes) - len(ends),
        success=bootstrap([float(o.success) for o in outcomes], seed),
        spl=bootstrap([value for value, _ in weighted if value is not None], seed),
        soft_spl=bootstrap([soft for _, soft in weighted if soft is not None], seed),
        distance_m=bootstrap(ends, seed),
        steps=bootstrap([float(o.steps) for o in outcomes], seed),
    )


def bootstrap(values: Sequence[float], seed: int = 0) -> Figure:
    """Mean and 95 % percentile interval over resamples of the episodes."""
    if not values:
        return Figure(math.nan, math.nan, math.nan, 0)
    sample = np.asarray(values, float)
    mean = float(sample.mean())
    if len(sample) == 1:  # nothing to resample: scipy wants two
        return Figure(mean, mean, mean, 1)
    low, high = scipy.stats.bootstrap(
        (sample,), np.mean, n_resamples=RESAMPLES, method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval  # fmt: skip
    return Figure(mean, float(low), float(high), len(sample))


def difference(ours: Sequence[float], theirs: Sequence[float], seed: int = 0) -> Figure:
    """Mean of ours minus theirs, episode by episode, with its 95 % interval: paired, so that what
    makes an episode hard for both does not widen it."""
    return bootstrap([a - b for a, b in zip(ours, theirs, strict=True)], seed)


def table(rows: Sequence[tuple[str, Summary]]) -> str:
    """Markdown: one line a method, means with their 95 % intervals."""
    lines = [
        "| method | episodes | SR % | SPL % | SoftSPL % | DTS m | steps |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, s in rows:
        cells = (
            cell(s.success, 100, 1),
            cell(s.spl, 100, 1),
            cell(s.soft_spl, 100, 1),
            cell(s.distance_m, 1, 2),
            cell(s.steps, 1, 0),
        )
        lines.append(f"| {name} | {s.episodes} | {' | '.join(cells)} |")
    for name, s in rows:
        if s.trivial:
            lines.append(f"\n{name}: {s.trivial} episodes with less than {TRIVIAL_M} m to go are "
                         "left out of SPL and SoftSPL.")  # fmt: skip
        if s.cut_off:
            lines.append(f"\n{name}: {s.cut_off} episodes ended cut off, left out of DTS.")
    return "\n".join(lines)


def cell(figure: Figure, scale: float = 1.0, digits: int = 2) -> str:
    """A table's cell: mean [low, high]."""
    if figure.n == 0:
        return "–"
    mean, low, high = (scale * x for x in (figure.mean, figure.low, figure.high))
    return f"{mean:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"
