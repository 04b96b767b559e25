"""`settled` against every vote that could still come, tried one by one."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.types import Ballot, Frontier, Vote
from runtime.core.voting.consensus import ConsensusConfig, agreed, elect, settled

CASES = 400


def vote(expert: str, ids: frozenset[int]) -> Vote:
    return Vote(expert, tuple(sorted(ids)), tuple((i, 1 / len(ids)) for i in sorted(ids)), "")


def frontier(id: int, distance_m: float) -> Frontier:
    return Frontier(id, np.zeros((1, 2)), (0.0, 0.0), distance_m)


def every_vote(expert: str, ids: list[int]) -> Iterator[Vote | None]:
    """An abstention, then all non-empty sets."""
    yield None
    for size in range(1, len(ids) + 1):
        for chosen in combinations(ids, size):
            yield vote(expert, frozenset(chosen))


def winners(votes, pending, frontiers, cfg, order=()) -> set[int | None]:
    """Who can still win, by brute force."""
    ids = [f.id for f in frontiers if f.distance_m < float("inf")]
    found = set()
    for more in product(*(every_vote(name, ids) for name in pending)):
        ballot = Ballot((*votes, *(v for v in more if v is not None)))
        found.add(elect(ballot, frontiers, cfg, order=order).frontier)
    return found


@st.composite
def polls(draw, most: int):
    """Up to `most` frontiers at distances with ties, one of them perhaps out of reach."""
    n = draw(st.integers(1, most))
    far = st.sampled_from([1.0, 2.0, 3.0, 4.0, float("inf")])
    frontiers = [frontier(i, draw(far)) for i in range(1, n + 1)]
    rank = draw(st.sampled_from(["nearest", "farthest"]))
    mode = draw(st.sampled_from(["strict", "lenient"]))
    order = tuple(draw(st.permutations(range(1, n + 1)))) if draw(st.booleans()) else ()
    detour_m = draw(st.sampled_from([float("inf"), 0.0, 1.0, 2.0]))
    return frontiers, ConsensusConfig(rank=rank, mode=mode, detour_m=detour_m), order


def ballots(draw, frontiers, experts: int) -> list[Vote]:
    sets = st.frozensets(st.sampled_from([f.id for f in frontiers]), min_size=1)
    return [vote(f"e{n}", draw(sets)) for n in range(experts)]


@settings(max_examples=CASES, deadline=None)
@given(st.data(), polls(6), st.integers(0, 3))
def test_settled_is_exact_with_one_out(data, poll, cast: int):
    frontiers, cfg, order = poll
    votes = ballots(data.draw, frontiers, cast)
    can = winners(votes, ["x"], frontiers, cfg, order)
    assert settled(votes, ["x"], frontiers, cfg, order) == (len(can) == 1)


@pytest.mark.slow
@settings(max_examples=CASES, deadline=None)
@given(st.data(), polls(4), st.integers(0, 2))
def test_settled_is_exact_with_two_out(data, poll, cast: int):
    frontiers, cfg, order = poll
    votes = ballots(data.draw, frontiers, cast)
    can = winners(votes, ["x", "y"], frontiers, cfg, order)
    assert settled(votes, ["x", "y"], frontiers, cfg, order) == (len(can) == 1)


@settings(max_examples=12, deadline=None)
@given(st.data(), polls(6), st.integers(1, 2))
def test_settled_is_exact_with_two_out_and_six_frontiers(data, poll, cast: int):
    frontiers, cfg, order = poll
    votes = ballots(data.draw, frontiers, cast)
    can = winners(votes, ["x", "y"], frontiers, cfg, order)
    assert settled(votes, ["x", "y"], frontiers, cfg, order) == (len(can) == 1)


@settings(max_examples=40, deadline=None)
@given(st.data(), polls(3), st.integers(0, 1))
def test_settled_is_exact_with_three_out(data, poll, cast: int):
    frontiers, cfg, order = poll
    votes = ballots(data.draw, frontiers, cast)
    can = winners(votes, ["x", "y", "z"], frontiers, cfg, order)
    assert settled(votes, ["x", "y", "z"], frontiers, cfg, order) == (len(can) == 1)


@pytest.mark.parametrize("mode", ["strict", "lenient"])
@pytest.mark.parametrize("rank", ["nearest", "farthest"])
def test_settled_is_exact_for_every_pair_of_votes_on_three_frontiers(mode: str, rank: str):
    cfg = ConsensusConfig(rank=rank, mode=mode)
    frontiers = [frontier(i, float(4 - i)) for i in (1, 2, 3)]
    true = 0
    for cast in product(every_vote("a", [1, 2, 3]), every_vote("b", [1, 2, 3])):
        votes = [v for v in cast if v is not None]
        can = winners(votes, ["x"], frontiers, cfg)
        assert settled(votes, ["x"], frontiers, cfg) == (len(can) == 1), votes
        true += len(can) == 1
    assert true > 0


@given(st.data(), polls(6), st.integers(0, 4))
def test_with_nobody_out_everything_is_settled(data, poll, cast: int):
    frontiers, cfg, order = poll
    assert settled(ballots(data.draw, frontiers, cast), [], frontiers, cfg, order)


@given(st.data(), polls(6), st.integers(0, 4))
def test_agreed_means_that_the_fallback_is_not_needed(data, poll, cast: int):
    frontiers, cfg, _ = poll
    near = [frontier(f.id, min(f.distance_m, 9.0)) for f in frontiers]  # as in a brief
    ballot = Ballot(tuple(ballots(data.draw, near, cast)))
    anywhere = replace(cfg, detour_m=float("inf"))
    assert agreed(ballot, cfg) == (elect(ballot, near, anywhere).rule != "closest")


@pytest.mark.parametrize(("pending", "sure"), [(["o2f"], False), (["z"], True)])
def test_one_experts_mode_is_settled_once_the_first_by_name_has_voted(pending, sure):
    frontiers = [frontier(1, 1.0), frontier(2, 2.0)]
    votes = [vote("r2f", frozenset({2}))]
    assert settled(votes, pending, frontiers, ConsensusConfig(mode="best")) is sure
    assert not settled([], pending, frontiers, ConsensusConfig(mode="best"))
    assert agreed(Ballot(tuple(votes)), ConsensusConfig(mode="best"))
    assert not agreed(Ballot(), ConsensusConfig(mode="best"))
