"""The page says what was measured, and whether that is enough."""

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from hil_sim.benchmarks.performance_page import StageRow, draw_growth, page


@pytest.mark.parametrize(
    ("median_ms", "p99_ms", "met"), [(1.0, 3.0, True), (2.5, 3.0, False), (1.0, 5.5, False)]
)
def test_a_goal_is_met_by_median_and_p99(median_ms: float, p99_ms: float, met: bool):
    row = StageRow("integrate", median_ms, p99_ms, 2.0, (2.0, 4.0))
    assert row.met is met
    assert row.line().endswith("| yes |" if met else "| no |")
    assert StageRow("integrate", median_ms, p99_ms, 2.0, None).met


def test_others_and_growth_are_told_where_they_were_measured():
    row = StageRow("integrate", 1.0, 2.0, 3.0, None)
    bare = page("a machine", 0.5, [row], {}, (240, 480), {})
    assert "a machine" in bare
    assert "Others" not in bare
    assert "Growth" not in bare
    larger = {"integrate": [1.0, 1.25], "megabytes": [11.0, 18.0]}
    told = page("a machine", 0.5, [row], {"VLFM": [0.08, 0.09]}, (240, 480), larger)
    assert "| VLFM | 85.0 |" in told
    assert "| integrate | 1.00 | 1.25 |" in told
    assert "| megabytes | 11 | 18 |" in told


def test_the_plot_has_plain_numbers_and_the_goals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    out = tmp_path / "figures" / "growth.png"
    drawn: list[Figure] = []
    real = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda figure, *where: (
        drawn.append(figure), real(figure, *where)))  # fmt: skip
    larger = {"integrate": [0.3, 1.2], "frontiers": [0.2, 0.4], "megabytes": [1.0, 2.0]}
    goals = {"integrate": None, "frontiers": (4.0, 8.0), "plan": (50.0, 60.0)}
    draw_growth((240, 480), larger, goals, out)
    assert out.read_bytes().startswith(b"\x89PNG")
    (axes,) = drawn[0].axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["0.2", "0.5", "1", "2"]
    dashed = {line.get_ydata()[0] for line in axes.lines
              if line.get_linestyle() == "--" and len(line.get_ydata())}  # fmt: skip
    assert dashed == {4.0}
    assert axes.get_ylim()[1] > 4.0
