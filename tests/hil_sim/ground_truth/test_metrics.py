"""The metrics' definitions, as properties."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.ground_truth.metrics import Outcome, bootstrap, soft_spl, spl, summarise, table

LENGTHS = st.floats(0.25, 50)
OUTCOMES = st.builds(
    Outcome,
    st.booleans(),
    LENGTHS,
    st.floats(0, 200),
    st.one_of(st.floats(0, 50), st.just(math.inf)),
    st.integers(1, 500),
)


@given(OUTCOMES)
def test_both_lie_between_0_and_1(outcome: Outcome) -> None:
    for value in (spl(outcome), soft_spl(outcome)):
        assert value is not None
        assert 0.0 <= value <= 1.0


@given(LENGTHS, st.floats(0, 1))
def test_a_perfect_episode_scores_1(shortest: float, share: float) -> None:
    """Also when the way driven was a little shorter than the grid's shortest path."""
    perfect = Outcome(True, shortest, shortest * share, 0.0, 9)
    assert spl(perfect) == soft_spl(perfect) == 1.0


@given(OUTCOMES, st.floats(0, 100))
def test_a_longer_way_never_scores_more(outcome: Outcome, more: float) -> None:
    longer = Outcome(
        outcome.success, outcome.shortest_m, outcome.path_m + more, outcome.distance_m, 1
    )
    assert spl(longer) <= spl(outcome)  # type: ignore[operator]
    assert soft_spl(longer) <= soft_spl(outcome)  # type: ignore[operator]


@given(OUTCOMES)
def test_failure_has_no_spl_but_may_have_made_progress(outcome: Outcome) -> None:
    failed = Outcome(False, outcome.shortest_m, outcome.path_m, outcome.shortest_m / 2, 1)
    assert spl(failed) == 0.0
    efficiency = failed.shortest_m / max(failed.shortest_m, failed.path_m)
    assert soft_spl(failed) == pytest.approx(0.5 * efficiency)


def test_twice_the_shortest_way_is_one_half() -> None:
    assert spl(Outcome(True, 4.0, 8.0, 0.0, 40)) == 0.5


def test_trivial_episodes_are_left_out_of_spl_and_counted() -> None:
    trivial = Outcome(True, 0.2, 0.0, 0.0, 1)
    assert spl(trivial) is None
    assert soft_spl(trivial) is None
    summary = summarise([trivial, Outcome(True, 4.0, 8.0, 0.0, 40)])
    assert (summary.episodes, summary.trivial) == (2, 1)
    assert (summary.success.mean, summary.success.n) == (1.0, 2)
    assert (summary.spl.mean, summary.spl.n) == (0.5, 1)


def test_a_cut_off_end_is_counted_and_makes_no_progress() -> None:
    cut = Outcome(False, 4.0, 1.0, math.inf, 500)
    assert soft_spl(cut) == 0.0
    summary = summarise([cut, Outcome(False, 4.0, 1.0, 3.0, 500)])
    assert (summary.cut_off, summary.distance_m.mean) == (1, 3.0)


@given(st.lists(st.floats(-5, 5), min_size=1, max_size=30), st.integers(0, 9))
def test_the_interval_holds_the_mean_and_repeats(values: list[float], seed: int) -> None:
    figure = bootstrap(values, seed)
    assert min(values) - 1e-9 <= figure.low <= figure.high <= max(values) + 1e-9
    if len(values) > 5:
        assert figure.low - 1e-9 <= figure.mean <= figure.high + 1e-9
    assert bootstrap(values, seed) == figure


def test_the_table_is_markdown() -> None:
    rows = [
        ("rfnav", summarise([Outcome(True, 4.0, 8.0, 0.0, 40)] * 3)),
        ("closest", summarise([])),
    ]
    lines = table(rows).splitlines()
    assert lines[2].startswith("| rfnav | 3 | 100.0 [100.0, 100.0] | 50.0 [50.0, 50.0] |")
    assert lines[3] == "| closest | 0 | – | – | – | – | – |"
    assert len({line.count("|") for line in lines}) == 1
