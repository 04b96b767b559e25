"""What was measured, beside what it may be."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from runtime.bench.measure import Measured
from runtime.tracing.budgets import Budgets
from runtime.tracing.stages import Stage

GROWN_S = 240.0  # in less, growth is that of what comes and goes
FEW = 20  # with fewer the 99th percentile says nothing
STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23)
"""97.5 % of Student's t, of 1 degree of freedom, 2, ...; of more it is less than MANY."""
MANY = 2.21


@dataclass(frozen=True)
class BudgetLine:
    """A figure, and its limit, in the same unit. `least`: it must be that much, not at most."""

    name: str
    value: float | None
    limit: float
    unit: str
    least: bool = False

    @property
    def broken(self) -> bool:
        """Whether the limit does not hold; what was not measured breaks it."""
        if self.value is None:
            return True
        return self.value < self.limit if self.least else self.value > self.limit


def rows(run: Measured, budgets: Budgets) -> list[BudgetLine]:
    """Every budget, and what came of it. Stages that never ran have none."""
    found = []
    for stage, budget in budgets.stages.items():
        told = run.stages.get(stage)
        if told is not None:
            found.append(BudgetLine(f"{stage} median", told["p50_ms"], budget.median_ms, "ms"))
            if told["n"] >= FEW:
                found.append(BudgetLine(f"{stage} p99", told["p99_ms"], budget.p99_ms, "ms"))
    late, loop = run.stages.get(Stage.LATE, {}), budgets.loop
    for share, limit_ms in (
        ("p99_ms", loop.late_p99_ms),
        ("p999_ms", loop.late_p999_ms),
        ("max_ms", loop.late_max_ms),
    ):
        above = late[share] - run.sleeper[share] if late else None
        found.append(BudgetLine(f"late above a sleeper {share[:-3]}", above, limit_ms, "ms"))
    looks = run.stages.get(Stage.DETECT, {}).get("n", 0.0)
    found.append(BudgetLine("detector", looks / run.seconds, loop.detector_hz, "Hz", least=True))
    if run.goals > 1:
        scored_s = run.stages.get(Stage.SCORE, {}).get("total_s", 0.0)
        at_work = scored_s / run.seconds
        found.append(BudgetLine("experts at work", at_work, loop.experts_share, "", least=True))
    found.append(BudgetLine("start to ready", run.ready_s, loop.ready_s, "s"))
    found.append(
        BudgetLine("goal to first command", run.first_command_s, loop.first_command_s, "s")
    )
    found.append(BudgetLine("memory", run.memory_mb, loop.memory_mb, "MB"))
    half_s = run.seconds / 2
    if half_s >= GROWN_S:
        grown = run.grown_mb / half_s * 3600
        found.append(BudgetLine("growth in an hour", grown, loop.growth_mb_h, "MB"))
    return found


def table(found: Iterable[BudgetLine]) -> str:
    """One line a row, for people."""
    lines = [f"{'':32}{'measured':>12}{'budget':>12}"]
    for row in found:
        value = "none" if row.value is None else f"{row.value:.2f}"
        bound = f"{'>=' if row.least else '<='} {row.limit:g}"
        mark = "  BROKEN" if row.broken else ""
        lines.append(f"{row.name:32}{value:>12}{bound:>12} {row.unit}{mark}")
    return "\n".join(lines)


@dataclass(frozen=True)
class Ratio:
    """This code's median of a stage in terms of another's, from pairs of runs; the interval holds
    the ratio in 95 of 100 cases."""

    stage: str
    ratio: float
    low: float
    high: float


def ratios(ours: Sequence[Measured], theirs: Sequence[Measured]) -> list[Ratio]:
    """By stage that both trace, of runs in pairs: the geometric mean, with Student's interval over
    the pairs: a bootstrap's would be too narrow, of so few."""
    found = []
    for stage in Stage:
        pairs = [
            (a.stages[stage]["p50_ms"], b.stages[stage]["p50_ms"])
            for a, b in zip(ours, theirs, strict=True)
            if stage in a.stages and stage in b.stages
        ]
        logs = np.array([math.log(a / b) for a, b in pairs if a > 0 and b > 0])
        if logs.size > 1:
            t = STUDENT[logs.size - 2] if logs.size - 2 < len(STUDENT) else MANY
            mean, error = float(logs.mean()), float(logs.std(ddof=1)) / math.sqrt(logs.size)
            ends = math.exp(mean - t * error), math.exp(mean + t * error)
            found.append(Ratio(stage, math.exp(mean), *ends))
    return found
