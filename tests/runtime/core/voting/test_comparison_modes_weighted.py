"""Evidence weighed against way, and votes against a frontier: off unless asked for, and bounded."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from runtime.config import load
from runtime.core.types import Ballot, Frontier, Vote
from runtime.core.voting.comparison_modes import PULL, evidence
from runtime.core.voting.consensus import ConsensusConfig, agreed, elect, settled

FRONTIERS = [Frontier(i, np.zeros((1, 2)), (0.0, 0.0), float(7 - i)) for i in range(1, 7)]
CLOSEST = 6
IDS = st.integers(1, 6)
SETS = st.frozensets(IDS, min_size=1)


@st.composite
def votes(draw, name: str) -> Vote:
    odds = draw(st.dictionaries(IDS, st.integers(1, 50), min_size=1))
    total = sum(odds.values())
    p = tuple((i, odds[i] / total) for i in sorted(odds))
    against = tuple(sorted(draw(st.frozensets(IDS))))
    return Vote(name, tuple(sorted(draw(SETS))), p, "", against=against)


BALLOTS = st.tuples(votes("o2f"), votes("r2f"), votes("sle")).map(Ballot)
WEIGHTS = st.tuples(*(st.floats(0.0, 5.0) for _ in range(3))).map(
    lambda w: tuple(zip(("o2f", "r2f", "sle"), w, strict=True))
)


@given(BALLOTS, WEIGHTS)
def test_the_least_way_is_elected_with_evidence_as_metres(ballot: Ballot, weights):
    decision = elect(ballot, FRONTIERS, ConsensusConfig(mode="weighted", weights=weights))
    cost = {f.id: f.distance_m for f in FRONTIERS}
    for vote in ballot.votes:
        p = dict(vote.probabilities)
        mean = sum(map(math.log, p.values())) / len(p)
        for i in p:
            cost[i] -= dict(weights)[vote.expert] * np.clip(math.log(p[i]) - mean, -PULL, PULL)
    best = min(cost.values())
    assert cost[decision.frontier] <= best + 1e-9


@given(BALLOTS, WEIGHTS)
def test_no_expert_makes_more_of_a_detour_than_its_weight_allows(ballot: Ballot, weights):
    decision = elect(ballot, FRONTIERS, ConsensusConfig(mode="weighted", weights=weights))
    detour_m = FRONTIERS[decision.frontier - 1].distance_m - 1.0  # the closest is 1 m away
    assert detour_m <= 2 * PULL * sum(w for _, w in weights) + 1e-9


@given(BALLOTS)
def test_without_weights_it_is_the_closest(ballot: Ballot):
    for weights in ((), (("o2f", 0.0), ("x", 3.0))):
        decision = elect(ballot, FRONTIERS, ConsensusConfig(mode="weighted", weights=weights))
        assert (decision.frontier, decision.rule) == (CLOSEST, "closest")


@given(votes("o2f"))
def test_evidence_is_centred_and_bounded(vote: Vote):
    nats = evidence(vote, range(1, 7))
    assert all(abs(x) <= PULL for x in nats.values())
    if all(abs(x) < PULL for x in nats.values()):
        assert abs(sum(nats.values())) < 1e-9
    assert evidence(vote, ()) == {}


@given(BALLOTS, st.integers(1, 3), st.sampled_from(["strict", "lenient", "weighted", "best"]))
def test_what_enough_experts_are_against_is_not_elected(ballot: Ballot, veto: int, mode: str):
    cfg = ConsensusConfig(mode=mode, veto=veto, weights=(("o2f", 1.0),))
    decision = elect(ballot, FRONTIERS, cfg)
    against = [sum(i in v.against for v in ballot.votes) for i in range(1, 7)]
    out = {i for i in range(1, 7) if against[i - 1] >= veto}
    if len(out) < 6:
        assert decision.frontier not in out
        assert not out & set(decision.chosen)
        left = [f for f in FRONTIERS if f.id not in out]
        alone = elect(ballot, left, ConsensusConfig(mode=mode, weights=cfg.weights))
        assert (decision.frontier, decision.chosen) == (alone.frontier, alone.chosen)
    else:  # all of them: then it means nothing
        assert decision.frontier == elect(ballot, FRONTIERS, ConsensusConfig(
            mode=mode, weights=cfg.weights)).frontier  # fmt: skip
    assert decision.closest == CLOSEST  # what the fallback alone would have been


@given(BALLOTS)
def test_votes_against_count_for_nothing_by_default(ballot: Ballot):
    plain = Ballot(tuple(Vote(v.expert, v.frontiers, v.probabilities, "") for v in ballot.votes))
    one, two = (elect(b, FRONTIERS, ConsensusConfig(mode="strict")) for b in (ballot, plain))
    assert (one.frontier, one.rule, one.chosen) == (two.frontier, two.rule, two.chosen)


@given(BALLOTS)
def test_where_numbers_count_everyone_is_waited_for(ballot: Ballot):
    for cfg in (ConsensusConfig(mode="weighted"), ConsensusConfig(mode="strict", veto=1)):
        assert not settled(ballot.votes, ["x"], FRONTIERS, cfg)
        assert settled(ballot.votes, [], FRONTIERS, cfg)


def test_agreement_counts_what_is_left_after_the_veto():
    both = Ballot((Vote("a", (1, 2), (), ""), Vote("b", (1,), (), "", against=(2,))))
    assert agreed(both, ConsensusConfig(mode="strict", veto=1))
    against = Ballot((Vote("a", (1, 2), (), ""), Vote("b", (1,), (), "", against=(1,))))
    assert not agreed(against, ConsensusConfig(mode="strict", veto=1))
    assert agreed(against, ConsensusConfig(mode="strict"))


def test_weights_come_from_the_configuration():
    settings = [
        'research.consensus_mode="weighted"',
        'research.consensus_weights=[["r2f", 0.5], ["o2f", 1.0]]',
    ]
    assert load(None, settings).navigate.consensus.weights == (("r2f", 0.5), ("o2f", 1.0))
