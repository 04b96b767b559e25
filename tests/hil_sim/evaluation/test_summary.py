"""Figures over episodes: what is left out, intervals, the table."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.evaluation.summary import Figure, bootstrap, summarise, table
from hil_sim.ground_truth.metrics import Outcome


def test_trivial_episodes_are_left_out_of_spl_and_counted() -> None:
    trivial = Outcome(True, 0.2, 0.0, 0.0, 1)
    summary = summarise([trivial, Outcome(True, 4.0, 8.0, 0.0, 40)])
    assert (summary.episodes, summary.trivial) == (2, 1)
    assert (summary.success.mean, summary.success.n) == (1.0, 2)
    assert (summary.spl.mean, summary.spl.n) == (0.5, 1)


def test_a_cut_off_end_is_counted() -> None:
    cut = Outcome(False, 4.0, 1.0, math.inf, 500)
    summary = summarise([cut, Outcome(False, 4.0, 1.0, 3.0, 500)])
    assert (summary.cut_off, summary.distance_m.mean) == (1, 3.0)


@given(st.lists(st.floats(-5, 5), min_size=1, max_size=30), st.integers(0, 9))
def test_the_interval_holds_the_mean_and_repeats(values: list[float], seed: int) -> None:
    figure = bootstrap(values, seed)
    assert min(values) - 1e-9 <= figure.low <= figure.high <= max(values) + 1e-9
    if len(values) > 5:
        assert figure.low - 1e-9 <= figure.mean <= figure.high + 1e-9
    assert bootstrap(values, seed) == figure


def test_one_episode_has_no_spread_and_none_no_mean() -> None:
    assert bootstrap([2.5]) == Figure(2.5, 2.5, 2.5, 1)
    assert math.isnan(bootstrap([]).mean)
    assert bootstrap([]).n == 0


def test_the_interval_of_a_mean_is_as_wide_as_theory_says() -> None:
    figure = bootstrap([float(n % 2) for n in range(100)])
    spread = 1.96 * 0.5 / math.sqrt(100)
    assert figure.high - figure.mean == pytest.approx(spread, rel=0.1)
    assert figure.mean - figure.low == pytest.approx(spread, rel=0.1)


def test_the_table_is_markdown() -> None:
    rows = [
        ("rfnav", summarise([Outcome(True, 4.0, 8.0, 0.0, 40)] * 3)),
        ("closest", summarise([])),
    ]
    lines = table(rows).splitlines()
    assert lines[2].startswith("| rfnav | 3 | 100.0 [100.0, 100.0] | 50.0 [50.0, 50.0] |")
    assert lines[3] == "| closest | 0 | – | – | – | – | – |"
    assert len({line.count("|") for line in lines}) == 1
