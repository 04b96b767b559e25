"""A report's figures: what they show, and that it can be read."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from hil_sim.driving.episode_result import End, Ended, EpisodeResult
from hil_sim.evaluation.failures import Cause
from hil_sim.evaluation.figures import beside, draw_actions, draw_causes, draw_paths
from hil_sim.ground_truth.episodes import Episode, Start
from hil_sim.scenes.open import open_scene

EPISODE = Episode("maple-bed-0", "maple", Start(5.0, 6.0, 0.0), "bed", 4.0)


def result(goal: str, steps: int) -> EpisodeResult:
    return EpisodeResult(
        episode=f"maple-{goal}-0", scene="maple", goal=goal, method="rfnav", protocol="hm3d",
        success=True, ended=Ended(End.STOP), steps=steps, collisions=0, decisions=2,
        shortest_path_m=4.0, path_m=5.0, distance_m=0.0, spl=0.8, soft_spl=0.4,
        actions={"frontier": steps - 8, "target": 8}, stopped=True, frontier_m=(3.0, 5.0), wall={},
    )  # fmt: skip


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    figures: list[Figure] = []
    real = Figure.savefig

    def savefig(figure: Figure, *where: Any) -> None:
        figures.append(figure)
        real(figure, *where)

    monkeypatch.setattr(Figure, "savefig", savefig)
    return figures


def test_ways_that_coincide_lie_side_by_side_there_and_back() -> None:
    there = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
    left, right = beside(there, 0.1), beside(there, -0.1)
    back = beside(there[::-1], 0.1)
    assert np.abs(left - right).max() == pytest.approx(0.2)
    assert np.hypot(*(left - right).T) == pytest.approx(np.full(len(left), 0.2))
    assert sorted(back.tolist()) == sorted(left.tolist())  # the same side both ways
    stood = np.array([[1.0, 1.0], [1.0, 1.0]])
    assert (beside(stood, 0.1) == stood).all()


def test_the_legend_of_paths_has_all_methods_the_start_and_the_goal_below_the_axes(
    tmp_path: Path, drawn: list[Figure]
) -> None:
    results = {"closest": result("bed", 30), "rfnav": result("bed", 20)}
    for name in results:
        track = tmp_path / name / EPISODE.id / "track.jsonl"
        track.parent.mkdir(parents=True)
        track.write_text('{"x": 5.5, "y": 6.0}\n{"x": 6.0, "y": 6.5}\n')
    draw_paths(open_scene("maple"), EPISODE, tmp_path, results, tmp_path / "paths.png")
    (figure,) = drawn
    (axes,), (legend,) = figure.axes, figure.legends
    told = [text.get_text() for text in legend.get_texts()]
    assert [text.split(":")[0] for text in told] == ["closest", "rfnav", "start", "the bed"]
    whole = axes.get_tightbbox()  # with the axis' name
    assert whole is not None
    assert legend.get_window_extent().y1 <= whole.y0
    lines = [np.asarray(line.get_xydata()) for line in axes.lines]
    ways = [line for line in lines if len(line) > 2]
    assert np.abs(ways[0] - ways[2]).max() > 0.02  # one beside the other


def test_goals_are_listed_downward_and_what_nobody_did_is_left_out(
    tmp_path: Path, drawn: list[Figure]
) -> None:
    goals = [f"goal {n}" for n in range(20)]
    results = [result(goal, 20) for goal in goals] + [result("goal 7", 30 + n) for n in range(4)]
    runs = dict.fromkeys(("closest", "geometry", "rfnav"), results)
    draw_actions(runs, tmp_path / "actions.png")
    (figure,) = drawn
    wide, high = figure.get_size_inches() * figure.dpi
    assert wide <= 1600
    assert high >= wide  # for so many goals
    left, right = figure.axes
    assert [label.get_text() for label in left.get_yticklabels()] == sorted(goals)
    assert left.get_ylim()[0] > left.get_ylim()[1]  # the first above
    assert [label.get_text() for label in right.get_yticklabels()] == ["frontier", "target"]
    dots = [line for line in left.lines if line.get_marker() == "o" and line.get_markersize() == 5]
    assert len(dots) == 3 * (len(goals) - 1)  # single episodes; of five a box
    assert len(left.patches) == 3


def test_failures_are_counted_at_their_bars(tmp_path: Path, drawn: list[Figure]) -> None:
    none = dict.fromkeys(Cause, 0)
    counts = {"rfnav": none | {Cause.DETECTION: 5, Cause.PLANNING: 4}, "oracle-goal": none}
    draw_causes(counts, {"rfnav": 60, "oracle-goal": 60}, tmp_path / "failures.png")
    (axes,) = drawn[0].axes
    told = [text.get_text() for text in axes.texts]
    assert [text for text in told if text] == ["5", "4", "9 of 60", "0 of 60"]
    assert axes.get_xlim()[1] > 16  # beyond the longest bar, of 15 %
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["detection", "planning"]
