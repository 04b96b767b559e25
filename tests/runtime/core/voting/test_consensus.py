"""CDM against the paper's set algebra, written out as sets."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.types import Ballot, Frontier, Vote
from runtime.core.voting.consensus import ConsensusConfig, agree, elect, successor

IDS = st.integers(1, 6)
SETS = st.frozensets(IDS, min_size=1)


def frontier(id: int, distance_m: float) -> Frontier:
    return Frontier(id, np.zeros((1, 2)), (0.0, 0.0), distance_m)


def ballot(*sets: frozenset[int]) -> Ballot:
    return Ballot(tuple(Vote(f"e{n}", tuple(sorted(s)), (), "") for n, s in enumerate(sets)))


FRONTIERS = [frontier(i, float(7 - i)) for i in range(1, 7)]  # 6 is the closest


@given(SETS, SETS, SETS)
def test_three_experts_follow_the_paper(a: frozenset[int], b: frozenset[int], c: frozenset[int]):
    rule, chosen = agree([a, b, c])
    if a & b & c:
        assert (rule, chosen) == ("all", a & b & c)
    elif (a & b) | (a & c) | (b & c):
        assert (rule, chosen) == ("pairs", (a & b) | (a & c) | (b & c))
    else:
        assert (rule, chosen) == ("closest", frozenset())


@given(st.lists(SETS, min_size=2, max_size=5))
def test_any_number_of_experts_all_else_any_two(sets: list[frozenset[int]]):
    rule, chosen = agree(sets)
    shared = {i for i in range(1, 7) if all(i in s for s in sets)}
    twice = {i for i in range(1, 7) if sum(i in s for s in sets) >= 2}
    assert chosen == (shared or twice)
    assert rule == ("all" if shared else "pairs" if twice else "closest")


@given(st.lists(SETS, max_size=4), st.permutations(range(4)))
def test_the_order_of_experts_does_not_matter(sets: list[frozenset[int]], order: list[int]):
    shuffled = [sets[i] for i in order if i < len(sets)]
    assert agree(sets) == agree(shuffled)


@given(SETS)
def test_a_lone_vote_counts_only_when_lenient(a: frozenset[int]):
    assert agree([a]) == ("closest", frozenset())
    assert agree([a], lenient=True) == ("lone", a)


@given(st.lists(SETS, max_size=4))
def test_the_winner_is_the_nearest_of_the_chosen_set(sets: list[frozenset[int]]):
    decision = elect(ballot(*sets), FRONTIERS, ConsensusConfig(mode="strict"))
    assert decision.frontier == max(decision.chosen, default=6)
    assert decision.closest == 6


def test_farthest_is_the_literal_argmax():
    votes = ballot(frozenset({2, 4}), frozenset({2, 4}))
    assert elect(votes, FRONTIERS, ConsensusConfig(mode="strict", rank="farthest")).frontier == 2
    assert elect(votes, FRONTIERS, ConsensusConfig(mode="strict")).frontier == 4


@given(st.lists(SETS, max_size=4))
def test_unreachable_frontiers_are_never_elected(sets: list[frozenset[int]]):
    frontiers = [frontier(i, float("inf") if i % 2 else float(i)) for i in range(1, 7)]
    decision = elect(ballot(*sets), frontiers, ConsensusConfig(mode="strict"))
    assert decision.frontier is not None
    assert decision.frontier % 2 == 0
    assert all(i % 2 == 0 for i in decision.chosen)


def test_no_reachable_frontier_is_said_so():
    decision = elect(
        ballot(frozenset({1})), [frontier(1, float("inf"))], ConsensusConfig(mode="strict")
    )
    assert (decision.frontier, decision.rule) == (None, "none")


def test_equal_distances_go_to_the_older_frontier():
    same = [frontier(i, 2.0) for i in (5, 3, 4)]
    assert elect(Ballot(), same, ConsensusConfig(mode="strict")).frontier == 3


@pytest.mark.parametrize(("alive", "heir"), [((2, 4, 6), 4), ((2, 6), 2), ((6, 5), 6), ((), None)])
def test_a_vanished_winner_is_followed_by_the_chosen_then_the_closest(alive, heir):
    decision = elect(
        ballot(frozenset({2, 4}), frozenset({2, 4})), FRONTIERS, ConsensusConfig(mode="strict")
    )
    assert successor(decision, [f for f in FRONTIERS if f.id in alive]) == heir


@given(
    st.lists(SETS, max_size=4),
    st.dictionaries(st.integers(1, 9), st.sampled_from([0.5, 1.0, 2.0, float("inf")]), max_size=9),
    st.sampled_from(["nearest", "farthest"]),
)
def test_a_decision_on_a_newer_map(sets: list[frozenset[int]], newer: dict[int, float], rank: str):
    """1 to 6 may have vanished, moved or been cut off, 7 to 9 are new."""
    decision = elect(ballot(*sets), FRONTIERS, ConsensusConfig(mode="strict", rank=rank))
    heir = successor(decision, [frontier(i, d) for i, d in newer.items()], rank)
    alive = {i: d for i, d in newer.items() if d < float("inf")}
    left = set(decision.chosen) & set(alive)
    if not alive:
        assert heir is None
    elif decision.frontier in alive:
        assert heir == decision.frontier
    elif left:
        want = max if rank == "farthest" else min
        best = want(alive[i] for i in left)
        assert heir == min(i for i in left if alive[i] == best)
    else:
        assert heir == min(i for i in alive if alive[i] == min(alive.values()))


@given(st.lists(SETS, max_size=4), st.floats(0.1, 100.0))
def test_the_same_ballot_elects_the_same_however_far_all_of_it_is(
    sets: list[frozenset[int]], scale: float
):
    """A robot that drove on sees other distances; the same order of them is the same decision."""
    later = [frontier(f.id, f.distance_m * scale) for f in FRONTIERS]
    one, two = (
        elect(ballot(*sets), fs, ConsensusConfig(mode="strict")) for fs in (FRONTIERS, later)
    )
    assert one == two


@given(st.lists(SETS, max_size=4), st.frozensets(IDS))
def test_a_ballot_on_a_map_that_lost_frontiers_counts_what_is_left_of_it(
    sets: list[frozenset[int]], gone: frozenset[int]
):
    left = [f for f in FRONTIERS if f.id not in gone]
    decision = elect(ballot(*sets), left, ConsensusConfig(mode="strict"))
    rule, chosen = agree([rest for s in sets if (rest := s - gone)])
    assert (decision.rule, frozenset(decision.chosen)) == (rule if left else "none", chosen)
    assert decision.frontier not in gone


@given(st.lists(SETS, max_size=4))
def test_what_would_have_been_without_each_expert(sets: list[frozenset[int]]):
    decision = elect(ballot(*sets), FRONTIERS, ConsensusConfig(mode="strict"))
    for left_out, (name, frontier) in enumerate(decision.without):
        others = [s for n, s in enumerate(sets) if n != left_out]
        votes = Ballot(tuple(v for v in decision.ballot.votes if v.expert != name))
        assert frontier == elect(votes, FRONTIERS, ConsensusConfig(mode="strict")).frontier
        assert frontier == max(agree(others)[1], default=6)
    assert len(decision.without) == len(sets)


def test_pairs_need_not_be_the_same_pair():
    rule, chosen = agree([frozenset({1, 2}), frozenset({2, 3}), frozenset({3, 4})])
    assert (rule, chosen) == ("pairs", frozenset({2, 3}))


@given(st.lists(SETS, max_size=4), st.floats(0, 6), st.permutations(range(1, 7)))
def test_no_vote_costs_more_than_the_detour(sets: list[frozenset[int]], most: float, order):
    cfg = ConsensusConfig(mode="strict", detour_m=most)
    fallback = elect(ballot(), FRONTIERS, cfg, order=order).frontier
    assert fallback == order[0]
    winner = elect(ballot(*sets), FRONTIERS, cfg, order=order).frontier
    assert (7 - winner) <= (7 - fallback) + most
    near = [s & {f.id for f in FRONTIERS if f.distance_m <= 7 - fallback + most} for s in sets]
    _, chosen = agree([s for s in near if s])
    assert winner == (max(chosen) if chosen else fallback)
