"""The modes to compare with: one expert's surest frontier, the most frequent of its samples, and
the fallback's ranking."""

from collections import Counter

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.types import Ballot, Frontier, Vote
from runtime.core.voting.consensus import ConsensusConfig, elect

FRONTIERS = [Frontier(i, np.zeros((1, 2)), (0.0, 0.0), float(7 - i)) for i in range(1, 7)]
WEIGHTS = st.dictionaries(st.integers(1, 6), st.integers(1, 9), min_size=1)


def ballot(weights: dict[int, int]) -> Ballot:
    total = sum(weights.values())
    p = tuple((i, weights[i] / total) for i in sorted(weights))
    return Ballot((Vote("both", tuple(sorted(weights)), p, ""),))


@given(WEIGHTS)
def test_best_follows_the_surest_and_the_nearer_of_equals(weights: dict[int, int]):
    decision = elect(ballot(weights), FRONTIERS, ConsensusConfig(mode="best"))
    most = max(weights.values())
    assert decision.frontier == max(i for i in weights if weights[i] == most)  # 6 is the nearest
    assert decision.rule == "best"


@given(WEIGHTS, st.integers(0, 10**12))
def test_a_majority_repeats_and_elects_what_has_probability(weights: dict[int, int], stamp: int):
    cfg = ConsensusConfig(mode="majority-5")
    first, again = (elect(ballot(weights), FRONTIERS, cfg, stamp) for _ in range(2))
    assert first == again
    assert first.frontier in weights
    assert first.rule == "majority"


def test_more_samples_follow_the_distribution_more_closely():
    weights = {1: 6, 2: 4}
    share = {}
    for mode in ("majority-3", "majority-5"):
        cfg = ConsensusConfig(mode=mode)
        winners = Counter(elect(ballot(weights), FRONTIERS, cfg, n).frontier for n in range(2000))
        share[mode] = winners[1] / 2000
    # binomial: P(at least 2 of 3) = 0.648, P(at least 3 of 5) = 0.683
    assert abs(share["majority-3"] - 0.648) < 0.04
    assert abs(share["majority-5"] - 0.683) < 0.04


def test_without_a_vote_every_mode_takes_the_closest():
    for mode in ("best", "majority-3", "strict", "lenient"):
        decision = elect(Ballot(), FRONTIERS, ConsensusConfig(mode=mode))
        assert (decision.frontier, decision.rule) == (6, "closest")


def test_a_fallback_ranking_replaces_the_closest_but_not_the_vote():
    cfg = ConsensusConfig(mode="lenient", fallback="geometry")
    alone = elect(Ballot(), FRONTIERS, cfg, order=(9, 2, 1))
    assert (alone.frontier, alone.rule, alone.closest) == (2, "geometry", 6)
    assert elect(ballot({4: 1}), FRONTIERS, cfg, order=(9, 2, 1)).frontier == 4
