"""`rfnav bench` with runs that are given."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from runtime.__main__ import cli
from runtime.bench.measure import BenchError, Measured, Subject
from runtime.tracing.budgets import read_budgets
from runtime.tracing.histogram import Histogram


def told(ms: float) -> dict[str, float]:
    histogram = Histogram()
    for _ in range(200):
        histogram.add(ms / 1e3)
    return histogram.told()


def figures(share: float) -> Measured:
    """Every stage takes that share of its median."""
    budgets = read_budgets()
    stages = {s.value: told(share * b.median_ms) for s, b in budgets.stages.items()}
    return Measured(stages, told(1.0), 20.0, 2.0, 0.2, 500.0, 1.0, {"jump": 2}, 3)


@pytest.fixture
def subjects(monkeypatch: pytest.MonkeyPatch) -> list[Subject]:
    """Those that were measured; another commit's take twice as long."""
    seen: list[Subject] = []

    def measured(subject: Subject, *_: object) -> Measured:
        seen.append(subject)
        return figures(0.5 if subject.root is None else 0.25)

    monkeypatch.setattr("runtime.bench.measure.measured", measured)
    return seen


def test_within_the_budgets_it_ends_well(subjects: list[Subject]):
    done = CliRunner().invoke(cli, ["bench", "--set", "map.max_depth_m=4.0"])
    assert done.exit_code == 0, done.output
    assert "halts: jump 2" in done.output
    one_after_the_other = ("research.keep_stages=true", "research.keep_scores=false")
    settings = ("map.max_depth_m=4.0", *one_after_the_other)
    assert subjects == [Subject([x for s in settings for x in ("--set", s)])]


def test_a_broken_budget_is_exit_status_1(subjects: list[Subject], tmp_path: Path):
    text = (Path(__file__).parents[3] / "deploy" / "budgets.toml").read_text()
    (tmp_path / "strict.toml").write_text(text.replace("memory_mb = 700", "memory_mb = 400"))
    done = CliRunner().invoke(cli, ["bench", "--budgets", str(tmp_path / "strict.toml")])
    assert done.exit_code == 1
    (line,) = (line for line in done.output.splitlines() if "BROKEN" in line)
    assert line.startswith("memory")


def test_another_commit_is_measured_in_turns(subjects: list[Subject]):
    done = CliRunner().invoke(cli, ["bench", "--against", "HEAD", "--pairs", "3"])
    assert done.exit_code == 0, done.output
    assert [s.root is None for s in subjects] == [False, True, True, False, False, True]
    others = {s.root for s in subjects if s.root}
    assert not any(root.exists() for root in others)  # it is gone again
    ratio = next(line for line in done.output.splitlines() if line.startswith("survey"))
    assert float(ratio.split()[1]) == pytest.approx(2.0, rel=0.1)


def test_a_commit_that_there_is_none_is_told_in_a_line(subjects: list[Subject]):
    done = CliRunner().invoke(cli, ["bench", "--against", "no-such-commit"])
    assert isinstance(done.exception, BenchError)
    assert "no-such-commit" in str(done.exception)
    assert "\n" not in str(done.exception)
