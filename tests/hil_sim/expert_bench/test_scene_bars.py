"""Votes by other bars, of an expert whose evidence is known."""

import numpy as np

from hil_sim.expert_bench.scene_bars import BARS
from tests.hil_sim.expert_bench.test_scene_bank import bank, judged, picture


def test_a_lower_bar_votes_more_often_and_here_for_what_is_best():
    rows = judged(lambda f: 0.1 * picture(f))  # 1.17 times an equal share, of the one behind
    bars = rows.bars
    assert {*BARS, 1.17} == set(bars)
    assert {bar: set(row.votes.tolist()) for bar, row in bars.items()} == {
        bar: {float(bar <= 1.17)} for bar in bars
    }
    assert bars[1.1].regret_m["sle"].tolist() == [0.0] * 4
    assert bars[1.2].regret_m["sle"].tolist() == [6.0] * 4  # the closest
    assert bars[1.2].regret_m["consensus+geometry"].tolist() == [2.0] * 4  # who votes alone is none


def test_by_the_bar_as_it_is_the_rows_are_the_same():
    rows = judged()
    for method, regret in rows.regret_m.items():
        assert rows.bars[1.5].regret_m[method].tolist() == regret.tolist()
    assert rows.bars[1.5].votes.tolist() == rows.votes.tolist()


def test_where_nothing_is_seen_no_bar_is_low_enough():
    rows = judged(of=bank(pictures=(1, 0, 0)))
    assert set(rows.bars) == set(BARS)
    assert all(np.isnan(row.votes).all() for row in rows.bars.values())
