"""The page of what the core costs, and the plot of how that grows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hil_sim.benchmarks.drive import BOXES, FRAMES, HOME

DPI = 110
NOT_A_TIME = "megabytes"
TICKS_MS = tuple(step * 10**power for power in range(-3, 4) for step in (1, 2, 5))
LEAST_ROOM = 0.9  # of the axis, below what is drawn, and above


@dataclass(frozen=True)
class StageRow:
    """A stage: median and p99, ms; the median over that of the reference; the goal, ms."""

    stage: str
    median_ms: float
    p99_ms: float
    ratio: float
    goal: tuple[float, float] | None

    def line(self) -> str:
        """Of the table."""
        goal = f"{self.goal[0]:g} / {self.goal[1]:g}" if self.goal else ""
        met = "" if self.goal is None else "yes" if self.met else "no"
        return (
            f"| {self.stage} | {self.median_ms:.2f} | {self.p99_ms:.2f} | {self.ratio:.2f} | "
            f"{goal} | {met} |"
        )

    @property
    def met(self) -> bool:
        """Whether the goal is met; so it is where there is none."""
        if self.goal is None:
            return True
        return self.median_ms <= self.goal[0] and self.p99_ms <= self.goal[1]


def page(
    machine: str,
    reference_ms: float,
    rows: Sequence[StageRow],
    field: Mapping[str, Sequence[float]],
    sides: Sequence[int],
    larger: Mapping[str, Sequence[float]],
) -> str:
    """Markdown."""
    lines = [
        "# What the core costs",
        "",
        "Written by `python -m hil_sim.benchmarks.core --out docs/performance.md`. Every figure is"
        " of one run on a machine that other work was done on, too.",
        "",
        f"{machine}.",
        "",
        f"A drive of {FRAMES} frames of 640 x 480 through `{HOME}`, up to {BOXES} detections a"
        " frame with embeddings; cells of 5 cm. Times are the thread's own, ms. The ratio is the"
        " median over that of a fixed piece of work that is done once a frame:"
        f" {reference_ms:.2f} ms.",
        "",
        "| stage | median | p99 | ratio | goal | met |",
        "|---|---|---|---|---|---|",
        *(row.line() for row in rows),
    ]
    if field:
        lines += ["", "Others' code, on the same frames in the same process:", "",
                  "| hot path | median | p99 | ratio |", "|---|---|---|---|"]  # fmt: skip
        for name, seconds in field.items():
            middle, high = (1000 * float(np.percentile(seconds, at)) for at in (50, 99))
            lines.append(f"| {name} | {middle:.1f} | {high:.1f} | {middle / reference_ms:.1f} |")
    if larger:
        lines += ["", *_growth(sides, larger)]
    return "\n".join(lines) + "\n"


def _growth(sides: Sequence[int], larger: Mapping[str, Sequence[float]]) -> list[str]:
    heads = " | ".join(f"{side}²" for side in sides)
    lines = [
        "## Growth with the map",
        "",
        "The drive's first frames, in a map of so many known cells: around the home stands the same"
        " home again and again, with its objects, each closed, along streets. The robot can reach"
        " its own. Medians, ms; the last line is what the map's arrays hold, MB.",
        "",
        "![Median times over the side of the known map](figures/core-growth.png)",
        "",
        f"| stage | {heads} |",
        "|---|" + "---|" * len(sides),
    ]
    for stage, values in larger.items():
        digits = 0 if stage == NOT_A_TIME else 2
        lines.append(f"| {stage} | " + " | ".join(f"{v:.{digits}f}" for v in values) + " |")
    return lines


def draw_growth(
    sides: Sequence[int],
    larger: Mapping[str, Sequence[float]],
    goals: Mapping[str, tuple[float, float] | None],
    out: Path,
) -> None:
    """Medians by stage over the side of the known map, both axes logarithmic; dashed, in a stage's
    colour, the goal of its median, of (median, p99) ms."""
    figure = Figure(figsize=(7.5, 4.6), dpi=DPI, layout="constrained")
    axes = figure.add_subplot()
    stages = {stage: values for stage, values in larger.items() if stage != NOT_A_TIME}
    bounds = [goal[0] for stage in stages if (goal := goals.get(stage))]
    for number, (stage, values) in enumerate(stages.items()):
        axes.loglog(sides, values, "o-", color=f"C{number}", label=stage)
        if goal := goals.get(stage):
            axes.axhline(goal[0], color=f"C{number}", ls="--", lw=1.0)
    if bounds:
        axes.plot([], [], "--", color="0.4", lw=1.0, label="goal of that colour")
    axes.set_xticks(sides, [str(side) for side in sides])
    drawn = [*bounds, *(value for values in stages.values() for value in values)]
    low, high = LEAST_ROOM * min(drawn), max(drawn) / LEAST_ROOM
    ticks = [tick for tick in TICKS_MS if low <= tick <= high]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_ylim(low, high)
    axes.minorticks_off()
    axes.grid(axis="y", color="0.9")
    axes.set_xlabel("side of the known map, cells")
    axes.set_ylabel("median, ms")
    axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out)
