"""Areas under ROC curves, by hand and against every pair counted."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.expert_bench.auc import LEAST, HomeAreas

ONE = np.array([0])


def pairs(scores: list[float], true: list[bool]) -> float:
    """Share of pairs in the right order, ties half."""
    won = [
        1.0 if a > b else 0.5 if a == b else 0.0
        for a, yes in zip(scores, true, strict=True) if yes
        for b, no in zip(scores, true, strict=True) if not no
    ]  # fmt: skip
    return sum(won) / len(won)


@given(st.lists(st.tuples(st.integers(0, 4), st.booleans(), st.integers(0, 3)), min_size=2))
def test_it_is_the_share_of_pairs_in_order(rows: list[tuple[int, bool, int]]) -> None:
    scores, true, home = ([row[k] for row in rows] for k in range(3))
    if len(set(true)) < 2:
        return
    areas = HomeAreas([str(h) for h in home], 0)
    column = np.array(scores, float)[:, None]
    answers = np.array(true)[:, None]
    found = areas.micro(column, np.ones_like(answers), answers, ONE)
    assert found.mean == pytest.approx(pairs(scores, true))
    assert found.n == len(rows)


def test_what_was_not_asked_does_not_count() -> None:
    areas = HomeAreas(["a"] * 4, 0)
    scores, true = np.array([[3.0], [2.0], [1.0], [9.0]]), np.array([[1], [1], [0], [0]], bool)
    asked = np.array([[1], [1], [1], [0]], bool)
    assert areas.micro(scores, asked, true, ONE).mean == 1.0
    assert areas.micro(scores, np.ones_like(asked), true, ONE).mean == 0.5


def test_a_mean_is_of_names_that_have_enough_answers() -> None:
    rows = 4 * LEAST
    true = np.zeros((rows, 3), bool)
    true[: 2 * LEAST, 0], true[: LEAST - 1, 1], true[LEAST : 2 * LEAST, 2] = True, True, True
    scores = np.column_stack((true[:, 0], ~true[:, 1], ~true[:, 2])).astype(float)
    areas = HomeAreas([str(n % 4) for n in range(rows)], 0)
    found = areas.macro(scores, np.ones_like(true), true, np.arange(3))
    assert (found.mean, found.n) == (0.5, 2)  # the second has one answer too few
    assert areas.macro(scores, np.ones_like(true), true, np.array([1])).n == 0


def test_intervals_are_over_homes_and_differences_are_paired() -> None:
    homes = [str(n // 20) for n in range(200)]
    rng = np.random.default_rng(1)
    true = rng.random((200, 1)) < 0.5
    hard = (np.arange(200) // 20 % 2)[:, None]  # in every second home it is guessed
    good = np.where(hard, rng.random((200, 1)), true) + 0.0
    areas, asked = HomeAreas(homes, 0), np.ones_like(true)
    one, other = (areas.macro(s, asked, true, ONE) for s in (good, good + 1))
    assert 0.6 < one.figure.low < one.mean < one.figure.high < 1.0
    gap = one.minus(other).figure
    assert (gap.mean, gap.low, gap.high) == (0.0, 0.0, 0.0)
    assert HomeAreas(homes, 0).macro(good, asked, true, ONE).figure == one.figure


def test_shares_by_hand() -> None:
    areas = HomeAreas(["a", "a", "b", "b"], 0)
    found = areas.share(np.array([True, True, False, False]))
    assert (found.mean, found.figure.low, found.figure.high) == (0.5, 0.0, 1.0)


def test_of_nothing_there_is_no_interval() -> None:
    areas = HomeAreas(["a", "b"], 0)
    none = areas.macro(np.zeros((2, 1)), np.ones((2, 1), bool), np.ones((2, 1), bool), ONE)
    assert math.isnan(none.figure.mean)
    assert none.figure.n == 0
