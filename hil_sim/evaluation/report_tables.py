"""A report's tables in Markdown: one line a method, means with 95 % bootstrap intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.evaluation.failures import Cause, false_finds, split
from hil_sim.evaluation.results import FRAMES, falls, mean_wall
from hil_sim.evaluation.summary import Figure, bootstrap, cell, difference, summarise
from runtime.core.purpose import Purpose

Runs = Mapping[str, Sequence[EpisodeResult]]  # a method's episodes, all methods the same ones


@dataclass(frozen=True)
class Gain:
    """What a method is ahead of another by, on the episodes that both have driven."""

    method: str
    other: str
    episodes: int
    success: Figure
    spl: Figure


def outcomes(runs: Runs, seed: int) -> str:
    """The main table."""
    lines = _head("method", "SR %", "SPL %", "SoftSPL %", "DTS m", "FrontierDist m", "steps")
    for name, results in runs.items():
        s = summarise([r.outcome for r in results], seed)
        cells = (cell(s.success, 100, 1), cell(s.spl, 100, 1), cell(s.soft_spl, 100, 1),
                 cell(s.distance_m), cell(frontier_distance(results, seed)),
                 cell(s.steps, 1, 0))  # fmt: skip
        lines.append(_row(name, *cells))
    return "\n".join(lines)


def frontier_distance(results: Sequence[EpisodeResult], seed: int = 0) -> Figure:
    """Mean over episodes of the mean true way, m, from an elected frontier to success."""
    means = [sum(r.frontier_m) / len(r.frontier_m) for r in results if r.frontier_m]
    return bootstrap(means, seed)


def gains(runs: Runs, base: str, seed: int) -> list[Gain]:
    """`base` against each other method, paired by episode."""
    found = []
    for name, results in runs.items():
        if name == base:
            continue
        theirs = {r.episode: r for r in results}
        pairs = [(r, theirs[r.episode]) for r in runs[base] if r.episode in theirs]
        success = difference(
            [float(a.success) for a, _ in pairs], [float(b.success) for _, b in pairs], seed
        )
        both = [(a.spl, b.spl) for a, b in pairs if a.spl is not None and b.spl is not None]
        spl = difference([a for a, _ in both], [b for _, b in both], seed)
        found.append(Gain(base, name, len(pairs), success, spl))
    return found


def differences(runs: Runs, base: str, seed: int) -> str:
    """Paired differences to one method; an interval without 0 is marked."""
    lines = _head(f"{base} minus", "episodes", "SR, points", "SPL, points")
    for gain in gains(runs, base, seed):
        lines.append(_row(gain.other, str(gain.episodes), *map(_marked, (gain.success, gain.spl))))
    return "\n".join(lines)


def progress(runs: Runs, before: Runs, seed: int) -> str:
    """The same methods on the same episodes in an earlier run and in this one."""
    lines = _head("method", "episodes", "SR %", "SPL %", "SR, points", "SPL, points",
                  "detection errors")  # fmt: skip
    for name in (n for n in runs if n in before):
        both = {r.episode for r in runs[name]} & {r.episode for r in before[name]}
        old, new = ([r for r in rows if r.episode in both] for rows in (before[name], runs[name]))
        if not both:
            continue
        (gain,) = gains({"after": new, "before": old}, "after", seed)
        was, now = (summarise([r.outcome for r in rows], seed) for rows in (old, new))
        missed = (split(rows)[Cause.DETECTION] for rows in (old, new))
        lines.append(_row(name, str(len(both)), *(
            f"{100 * getattr(was, key).mean:.1f} → {100 * getattr(now, key).mean:.1f}"
            for key in ("success", "spl")
        ), _marked(gain.success), _marked(gain.spl), " → ".join(map(str, missed))))  # fmt: skip
    return "\n".join(lines)


def failures(runs: Runs) -> str:
    """How many episodes failed for which cause, collisions, falls, and how the robot ended."""
    lines = _head("method", "failed", *Cause, "collisions an episode", "falls",
                  "ended stopped %", "false finds in 1,000 frames")  # fmt: skip
    for name, results in runs.items():
        causes = split(results)
        hits = sum(r.collisions for r in results) / len(results)
        still = 100 * sum(r.stopped for r in results) / len(results)
        failed = sum(causes.values())
        counts = (str(causes[cause]) for cause in Cause)
        false = false_finds(results, sum(r.outcome.steps for r in results))
        lines.append(_row(name, f"{failed} of {len(results)}", *counts, f"{hits:.2f}",
                          str(falls(results)), f"{still:.0f}", f"{false:.2f}"))  # fmt: skip
    return "\n".join(lines)


def purposes(runs: Runs) -> str:
    """Share of the steps by what they were spent on, of the results that tell it; "" where none
    does. (A stop is "other".)"""
    lines = _head("method", "steps an episode", *(f"{purpose} %" for purpose in Purpose))
    for name, results in runs.items():
        told = [r for r in results if r.purposes]
        total = sum(sum(r.purposes.values()) for r in told)
        if total:
            shares = (100 * sum(r.purposes.get(p, 0) for r in told) / total for p in Purpose)
            cells = (f"{share:.1f}" for share in shares)
            lines.append(_row(name, f"{total / len(told):.0f}", *cells))
    return "\n".join(lines) if len(lines) > 2 else ""


def categories(runs: Runs) -> str:
    """Successes by goal: found / episodes."""
    goals = sorted({r.goal for results in runs.values() for r in results})
    lines = _head("goal", *runs)
    for goal in goals:
        cells = []
        for results in runs.values():
            of_goal = [r for r in results if r.goal == goal]
            cells.append(f"{sum(r.success for r in of_goal)} / {len(of_goal)}")
        lines.append(_row(goal, *cells))
    return "\n".join(lines)


def times(runs: Runs) -> str:
    """Mean wall seconds an episode by stage, and frames rendered or shared with other methods."""
    means = {name: mean_wall(results) for name, results in runs.items()}
    names = {stage for mean in means.values() for stage in mean} - {"total", *FRAMES}
    stages = sorted(names, key=lambda n: -sum(mean.get(n, 0.0) for mean in means.values()))
    heads = [stage.removeprefix("runtime.") for stage in stages]
    lines = _head("method", "s an episode", *heads, "frames rendered", "frames shared")
    for name, mean in means.items():
        cells = [f"{mean.get(stage, 0.0):.1f}" for stage in ("total", *stages)]
        lines.append(_row(name, *cells, *(f"{mean.get(count, 0.0):.0f}" for count in FRAMES)))
    return "\n".join(lines)


def _marked(figure: Figure) -> str:
    clear = figure.n > 0 and (figure.low > 0 or figure.high < 0)
    return f"**{cell(figure, 100, 1)}**" if clear else cell(figure, 100, 1)


def _head(*names: str) -> list[str]:
    return [_row(*names), "|---" * len(names) + "|"]


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"
