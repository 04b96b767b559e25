"""The metrics' definitions, as properties."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.ground_truth.metrics import Outcome, soft_spl, spl

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


def test_trivial_episodes_have_no_spl() -> None:
    trivial = Outcome(True, 0.2, 0.0, 0.0, 1)
    assert spl(trivial) is None
    assert soft_spl(trivial) is None


def test_an_end_that_is_cut_off_makes_no_progress() -> None:
    assert soft_spl(Outcome(False, 4.0, 1.0, math.inf, 500)) == 0.0
