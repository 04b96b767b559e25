"""A report's figures as PNG: paths over the plan, actions by goal, why episodes failed."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
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
CAUSE_COLOURS = ("tab:orange", "tab:purple", "tab:brown", "0.3")
MODES = tuple(Mode)


def draw_paths(
    scene: Scene, episode: Episode, folder: Path, results: Mapping[str, EpisodeResult], out: Path
) -> Path:
    """The ways that methods drove in one episode, over the plan of the home."""
    low, high = plan_bounds(scene)
    width, height = high - low
    figure = Figure(figsize=(9, 9 * height / width + 0.9), dpi=DPI, layout="constrained")
    axes = figure.add_subplot()
    axes.imshow(plan_image(scene), extent=(low[0], high[0], low[1], high[1]), alpha=0.55)
    for index in instances(scene, episode.goal):
        corners = box_of(scene.objects[index]).corners()
        axes.fill(*corners.T, color="gold", alpha=0.7, zorder=2)
    for number, (name, result) in enumerate(results.items()):
        track = read_track(folder / name / episode.id, episode)
        _draw_track(axes, track, _colour(number), _said(name, result))
    axes.plot(episode.start.x_m, episode.start.y_m, "o", color="black", ms=9, zorder=6)
    axes.set_title(f"{episode.id}: find a {episode.goal}", loc="left", fontsize=11)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.08), ncols=2, fontsize=8)
    figure.savefig(out)
    return out


def read_track(folder: Path, episode: Episode) -> NDArray[np.float64]:
    """(N, 2) positions, m, scene frame, from the start on; only the start where nothing is."""
    points = [(episode.start.x_m, episode.start.y_m)]
    path = folder / TRACK_FILE
    if path.is_file():
        rows = (json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
        points += [(row["x"], row["y"]) for row in rows]
    return np.array(points)


def draw_actions(runs: Runs, out: Path) -> Path:
    """Steps an episode took by goal, one box a method; and what the steps were, by mode."""
    goals = sorted({r.goal for results in runs.values() for r in results})
    figure = Figure(figsize=(max(8.0, 1.3 * len(goals) + 4), 4.6), dpi=DPI, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(3, 1))
    width = 0.8 / len(runs)
    for number, (name, results) in enumerate(runs.items()):
        steps = [[r.steps for r in results if r.goal == goal] for goal in goals]
        places = np.arange(len(goals)) + (number - (len(runs) - 1) / 2) * width
        boxes = left.boxplot(steps, positions=places, widths=0.85 * width, patch_artist=True,
                             medianprops={"color": "black"}, flierprops={"ms": 3})  # fmt: skip
        for box in boxes["boxes"]:
            box.set_facecolor(_colour(number))
        left.plot([], [], "s", color=_colour(number), label=name)
        means = [np.mean([r.actions.get(mode, 0) for r in results]) for mode in MODES]
        right.bar(np.arange(len(MODES)) + (number - (len(runs) - 1) / 2) * width, means, width,
                  color=_colour(number))  # fmt: skip
    left.set_xticks(range(len(goals)), goals, rotation=30, ha="right")
    left.set_ylabel("actions an episode")
    left.legend(fontsize=8)
    right.set_xticks(range(len(MODES)), MODES, rotation=30, ha="right")
    right.set_ylabel("mean actions, by what for")
    figure.savefig(out)
    return out


def draw_failures(runs: Runs, out: Path) -> Path:
    """For each method, the share of episodes that failed, by cause."""
    figure = Figure(figsize=(8, 0.42 * len(runs) + 1.4), dpi=DPI, layout="constrained")
    axes = figure.add_subplot()
    names = list(runs)
    begun = np.zeros(len(names))
    for cause, colour in zip(Cause, CAUSE_COLOURS, strict=True):
        shares = np.array([100 * split(runs[n])[cause] / max(1, len(runs[n])) for n in names])
        axes.barh(names, shares, left=begun, color=colour, label=cause)
        begun += shares
    axes.invert_yaxis()
    axes.set_xlabel("failed episodes, %")
    axes.legend(fontsize=8, ncols=len(Cause), loc="lower left", bbox_to_anchor=(0.0, 1.0))
    figure.savefig(out)
    return out


def _draw_track(axes: Axes, track: NDArray[np.float64], colour: str, label: str) -> None:
    axes.plot(*track.T, "-", color="white", lw=4, alpha=0.8, zorder=3)
    axes.plot(*track.T, "-", color=colour, lw=2, label=label, zorder=4)
    axes.plot(*track[-1], "X", color=colour, mec="white", ms=11, zorder=5)


def _said(name: str, result: EpisodeResult) -> str:
    outcome = "found" if result.success else "not found"
    return f"{name}: {outcome}, {result.path_m:.1f} m in {result.steps} steps"


def _colour(number: int) -> str:
    cycle: list[str] = mpl.rcParams["axes.prop_cycle"].by_key()["color"]
    return cycle[number % len(cycle)]
