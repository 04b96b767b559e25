"""Object-goal metrics: SR, SPL (Anderson et al. 2018), SoftSPL and DTS (habitat-lab).

S success, l the shortest path from the start to success, p the path driven, d what is left of the
way at the end:  SPL = mean S * l / max(l, p);  SoftSPL = mean max(0, 1 - d / l) * l / max(l, p).
"""

from dataclasses import dataclass

TRIVIAL_M = 0.25
"""Episodes with a shorter way than one step say nothing about paths: left out of SPL, counted."""


@dataclass(frozen=True)
class Outcome:
    """What the metrics need of one episode. Lengths in metres; `distance_m` may be inf."""

    success: bool
    shortest_m: float
    path_m: float
    distance_m: float
    steps: int


def spl(outcome: Outcome) -> float | None:
    """Success weighted by path length, in [0, 1]; None for a trivial episode."""
    if outcome.shortest_m < TRIVIAL_M:
        return None
    return float(outcome.success) * _efficiency(outcome)


def soft_spl(outcome: Outcome) -> float | None:
    """Progress weighted by path length, in [0, 1]; None for a trivial episode."""
    if outcome.shortest_m < TRIVIAL_M:
        return None
    return max(0.0, 1.0 - outcome.distance_m / outcome.shortest_m) * _efficiency(outcome)


def _efficiency(outcome: Outcome) -> float:
    return outcome.shortest_m / max(outcome.shortest_m, outcome.path_m)
