from pathlib import Path

import numpy as np
import pytest
from drawn_homes import draw_homes

from models.train.beyond_data import Moments, read_homes
from models.train.beyond_scores import auc, by_table, correlation, judge, split


def test_area_under_the_curve_counts_ties_half():
    right = np.arange(40) < 20
    counted = np.ones(40, bool)
    assert auc(np.where(right, 1.0, 0.0), right, counted) == 1
    assert auc(np.zeros(40), right, counted) == 0.5
    assert auc(np.where(right, 0.0, 1.0), right, counted) == 0
    assert np.isnan(auc(np.zeros(40), np.arange(40) < 3, counted))
    assert split([0.9, 0.7, float("nan"), 0.5], np.array([True, True, True, False])) == (0.8, 0.5)


def test_rank_correlation_leaves_out_what_does_not_count():
    a = np.array([[1.0, 2.0, 9.0, 99.0], [3.0, 2.0, 1.0, 0.0], [1.0, 1.0, 1.0, 1.0]])
    b = np.array([[0.1, 0.2, 0.3, -5.0], [1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0]])
    counted = np.array([[True, True, True, False], [True] * 4, [True] * 4])
    told = correlation(a, b, counted)
    assert told[:2] == pytest.approx([1, -1])
    assert np.isnan(told[2])


def test_the_truth_is_judged_perfect_and_a_table_is_not(tmp_path: Path):
    draw_homes(tmp_path, 6, seed=1)
    homes = read_homes(tmp_path)
    rows, moments = np.flatnonzero(homes.best), Moments.of(homes)
    taught = np.ones(len(homes.categories), bool)
    truth = judge(homes.there().astype(float), homes, rows, taught, moments)
    assert truth.beyond == 1
    assert truth.onward == pytest.approx(1)
    table = judge(by_table(homes, homes), homes, rows, taught, moments)
    assert table.beyond < 0.8
    assert table.onward < 0.8
