"""Means over a bank, with whole layouts resampled."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.expert_bench.statistics import Resampling, rank_correlation


def test_questions_of_one_layout_count_as_one() -> None:
    values = np.array([0.0, 1.0] * 10)
    alike = Resampling(["a", "b"] * 10, 0).mean(values)  # a's are all 0, b's all 1
    apart = Resampling([str(n) for n in range(20)], 0).mean(values)
    assert alike.mean == apart.mean == 0.5
    assert (alike.low, alike.high) == (0.0, 1.0)
    assert 0.2 < apart.low < 0.4 < 0.6 < apart.high < 0.8


def test_larger_layouts_weigh_more() -> None:
    figure = Resampling(["a"] * 3 + ["b"], 0).mean(np.array([1.0, 1.0, 1.0, 5.0]))
    assert figure.mean == 2.0
    assert (figure.low, figure.high) == (1.0, 5.0)


def test_what_is_not_known_is_left_out() -> None:
    figure = Resampling(["a", "b", "c"], 0).mean(np.array([2.0, math.nan, 2.0]))
    assert (figure.mean, figure.low, figure.high, figure.n) == (2.0, 2.0, 2.0, 2)
    assert Resampling(["a"], 0).mean(np.array([math.nan])).n == 0


def test_the_same_seed_gives_the_same_interval() -> None:
    layouts, values = [str(n % 7) for n in range(50)], np.arange(50.0) ** 1.5
    one, other = Resampling(layouts, 3).mean(values), Resampling(layouts, 3).mean(values)
    assert one == other
    assert Resampling(layouts, 4).mean(values).low != one.low


def test_rank_correlation_by_hand() -> None:
    assert rank_correlation([1, 2, 3], [10, 100, 1000]) == pytest.approx(1.0)
    assert rank_correlation([1, 2, 3], [3, 2, 1]) == pytest.approx(-1.0)
    # ranks 0 1 2 3 against 0.5 0.5 2 3: r = 4.5 / sqrt(5 * 4.5)
    assert rank_correlation([1, 2, 3, 4], [1, 1, 2, 3]) == pytest.approx(4.5 / math.sqrt(22.5))
    assert math.isnan(rank_correlation([1, 2, 3], [5, 5, 5]))
    assert math.isnan(rank_correlation([1, 2], [1, 2]))


@given(st.lists(st.integers(-5, 5), min_size=3, max_size=9))
def test_rank_correlation_knows_nothing_of_scale(values: list[int]) -> None:
    other = [(v * 7) % 5 for v in values]
    one, scaled = (
        rank_correlation(values, other),
        rank_correlation([3 * v + 1 for v in values], other),
    )
    assert one == scaled or (math.isnan(one) and math.isnan(scaled))
    assert math.isnan(one) or -1 - 1e-9 <= one <= 1 + 1e-9
