"""A report's figures as PNG: paths over the plan, actions by goal, why episodes failed."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from hil_sim.driving.episode_result import EpisodeResult
from hil_sim.evaluation.failures import Cause, split
from hil_sim.ground_truth.episodes import Episode
from hil_sim.ground_truth.freespace import instances
from hil_sim.ground_truth.witness import TRACK_FILE
from hil_sim.scenes.format import Scene
from hil_sim.scenes.furniture.boxes import box_of
from hil_sim.scenes.plan_view import plan_bounds, plan_image
from runtime.core.world import Mode

Runs = Mapping[str, Sequence[EpisodeResult]]
DPI = 110
WIDTH_IN = 9.0
LANE_PT = 2.4  # from one method's line to the next, where they drive alike
SIDE = np.array([np.cos(1.2), np.sin(1.2)])  # askew to walls: which of two sides is the same
END_PT = 13  # of the first method's mark
ROW_IN, LANES = 0.13, 0.8  # high is a method's bar; the share of a row that all have
BOXED = 4  # of so many episodes a box is drawn, else each
CAUSE_COLOURS = ("tab:orange", "tab:purple", "tab:brown", "0.3")
MODES = tuple(Mode)


def draw_paths(
    scene: Scene, episode: Episode, folder: Path, results: Mapping[str, EpisodeResult], out: Path
) -> Path:
    """The ways that methods drove in one episode, over the plan of the home."""
    low, high = plan_bounds(scene)
    width, height = high - low
    size_in = WIDTH_IN, WIDTH_IN * height / width + 0.9
    figure = Figure(figsize=size_in, dpi=DPI, layout="constrained")
    axes = figure.add_subplot()
    axes.imshow(plan_image(scene), extent=(low[0], high[0], low[1], high[1]), alpha=0.55)
    for index in instances(scene, episode.goal):
        corners = box_of(scene.objects[index]).corners()
        axes.fill(*corners.T, color="gold", alpha=0.7, zorder=2)
    axes.plot(episode.start.x_m, episode.start.y_m, "o", color="black", ms=9, zorder=6)
    lane_m = LANE_PT * width / (WIDTH_IN * 72)
    for number, name in enumerate(results):
        track = read_track(folder / name / episode.id, episode)
        aside_m = (number - (len(results) - 1) / 2) * lane_m
        _draw_track(axes, beside(track, aside_m), _colour(number), END_PT - 3 * number)
    axes.set_title(f"{episode.id}: find a {episode.goal}", loc="left", fontsize=11)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    figure.legend(handles=_told(episode, results), loc="outside lower left", ncols=2, fontsize=8)
    figure.savefig(out)
    return out


def beside(track: NDArray[np.float64], aside_m: float) -> NDArray[np.float64]:
    """(N, 2) m -> (M, 2) m, so far to one side, the same side there and back: what several methods
    drive alike lies side by side."""
    steps = np.diff(track, axis=0)
    moved = np.hypot(*steps.T) > 0
    if not moved.any():
        return track
    along = steps[moved] / np.hypot(*steps[moved].T)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across[across @ SIDE < 0] *= -1
    ends = np.stack([track[:-1][moved], track[1:][moved]], axis=1) + aside_m * across[:, None]
    return ends.reshape(-1, 2)


def read_track(folder: Path, episode: Episode) -> NDArray[np.float64]:
    """(N, 2) positions, m, scene frame, from the start on; only the start where nothing is."""
    points = [(episode.start.x_m, episode.start.y_m)]
    path = folder / TRACK_FILE
    if path.is_file():
        rows = (json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
        points += [(row["x"], row["y"]) for row in rows]
    return np.array(points)


def draw_actions(runs: Runs, out: Path) -> Path:
    """Steps an episode took by goal, one box a method, single episodes as dots; and what the steps
    were, by mode."""
    goals = sorted({r.goal for results in runs.values() for r in results})
    means = {
        mode: [np.mean([r.actions.get(mode, 0) for r in rs] or [0]) for rs in runs.values()]
        for mode in MODES
    }
    modes = [mode for mode in MODES if any(means[mode])]
    high_in = 1.2 + ROW_IN * max(len(goals), len(modes)) * max(2, len(runs))
    figure = Figure(figsize=(WIDTH_IN, high_in), dpi=DPI, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    lane = LANES / len(runs)
    for number, (name, results) in enumerate(runs.items()):
        steps = [[r.steps for r in results if r.goal == goal] for goal in goals]
        _draw_steps(left, steps, _lanes(len(goals), number, len(runs)), lane, _colour(number))
        right.barh(_lanes(len(modes), number, len(runs)), [means[mode][number] for mode in modes],
                   lane, color=_colour(number), label=name)  # fmt: skip
    for axes, names in ((left, goals), (right, modes)):
        axes.set_yticks(range(len(names)), names)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xlim(left=0)
    left.set_xlabel("actions an episode")
    right.set_xlabel("mean actions, by what for")
    figure.legend(*right.get_legend_handles_labels(), loc="outside upper left", fontsize=8,
                  ncols=len(runs))  # fmt: skip
    figure.savefig(out)
    return out


def _draw_steps(
    axes: Axes, steps: Sequence[Sequence[int]], at: NDArray[np.float64], lane: float, colour: str
) -> None:
    many = [(row, y) for row, y in zip(steps, at, strict=True) if len(row) >= BOXED]
    if many:
        boxes = axes.boxplot(
            [row for row, _ in many], positions=[y for _, y in many], orientation="horizontal",
            widths=0.85 * lane, patch_artist=True, manage_ticks=False,
            medianprops={"color": "black"}, flierprops={"ms": 3},
        )  # fmt: skip
        for box in boxes["boxes"]:
            box.set_facecolor(colour)
    for row, y in zip(steps, at, strict=True):
        if len(row) < BOXED:
            axes.plot(row, [y] * len(row), "o", color=colour, ms=5)


def _lanes(count: int, number: int, of: int) -> NDArray[np.float64]:
    """Where a method's bars lie beside those of others, one a row."""
    return np.arange(count, dtype=np.float64) + (number - (of - 1) / 2) * LANES / of


def draw_failures(runs: Runs, out: Path) -> Path:
    """For each method, how many episodes failed, by cause, as a share of all."""
    counts = {name: split(results) for name, results in runs.items()}
    return draw_causes(counts, {name: len(results) for name, results in runs.items()}, out)


def draw_causes(
    counts: Mapping[str, Mapping[Cause, int]], episodes: Mapping[str, int], out: Path
) -> Path:
    """The same of counted failures, of so many episodes each."""
    figure = Figure(figsize=(8, 0.42 * len(counts) + 1.4), dpi=DPI, layout="constrained")
    axes = figure.add_subplot()
    names = list(counts)
    of = np.array([max(1, episodes[name]) for name in names])
    begun = np.zeros(len(names))
    for cause, colour in zip(Cause, CAUSE_COLOURS, strict=True):
        failed = np.array([counts[name][cause] for name in names])
        if failed.any():
            bars = axes.barh(names, 100 * failed / of, left=begun, color=colour, label=cause)
            axes.bar_label(bars, [str(n) if n else "" for n in failed], label_type="center",
                           color="white", fontsize=8)  # fmt: skip
        begun += 100 * failed / of
    for name, share in zip(names, begun, strict=True):
        axes.annotate(f"{sum(counts[name].values())} of {episodes[name]}", (share, name), (4, 0),
                      textcoords="offset points", va="center", fontsize=8)  # fmt: skip
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_xlim(0, max(1.0, begun.max()) * 1.15)
    axes.set_xlabel("failed episodes, %")
    if begun.any():
        axes.legend(fontsize=8, ncols=len(Cause), loc="lower left", bbox_to_anchor=(0.0, 1.0))
    figure.savefig(out)
    return out


def _told(episode: Episode, results: Mapping[str, EpisodeResult]) -> list[Artist]:
    """What the lines and marks in a picture of paths are."""
    methods = [
        Line2D([], [], color=_colour(n), lw=2, marker="X", label=_said(name, result))
        for n, (name, result) in enumerate(results.items())
    ]
    start = Line2D([], [], marker="o", color="black", ls="", ms=7, label="start")
    return [*methods, start, Patch(color="gold", alpha=0.7, label=f"the {episode.goal}")]


def _draw_track(axes: Axes, track: NDArray[np.float64], colour: str, end_pt: float) -> None:
    """The later a method the smaller is its mark at the end: all are seen where they end alike."""
    axes.plot(*track.T, "-", color="white", lw=4, alpha=0.8, zorder=3)
    axes.plot(*track.T, "-", color=colour, lw=2, zorder=4)
    axes.plot(*track[-1], "X", color=colour, mec="white", ms=end_pt, zorder=5)


def _said(name: str, result: EpisodeResult) -> str:
    outcome = "found" if result.success else "not found"
    return f"{name}: {outcome}, {result.path_m:.1f} m in {result.steps} steps"


def _colour(number: int) -> str:
    cycle: list[str] = mpl.rcParams["axes.prop_cycle"].by_key()["color"]
    return cycle[number % len(cycle)]
