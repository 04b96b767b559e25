"""A found target teaches who was right: in a flat-land apartment, from the place where it ends."""

import math
from dataclasses import replace

import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment

from runtime import navigate
from runtime.core.settings import NavigateConfig
from runtime.core.types import Action, Ballot, Decision, Pose, Vote
from runtime.core.voting.consensus import ConsensusConfig
from runtime.core.world import World
from runtime.experts.hindsight import Choice, Hindsight

SEATS = ("o2f", "r2f")
WEIGHTED = ConsensusConfig(mode="weighted")


@pytest.fixture(scope="module")
def world() -> World:
    """As it stands after a look around."""
    home, cfg = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)), NavigateConfig()
    world = World.begin("toilet", ("toilet",), (), home.pose, 0.18)
    for _ in range(12):
        obs = home.observe()
        navigate.perceive(world, obs, home.detect(("toilet",), obs), MOUNT, cfg)
        home.apply(Action.TURN_LEFT)
    return world


def choice(world: World, **nats_a_metre: float) -> Choice:
    """A vote after each expert's kind: evidence for a frontier rises so much by metre of way."""
    reach = [f for f in world.frontiers if math.isfinite(f.distance_m)]
    votes = []
    for expert, slope in sorted(nats_a_metre.items()):
        odds = {f.id: math.exp(slope * f.distance_m) for f in reach}
        total = sum(odds.values())
        best = max(odds, key=lambda i: odds[i])
        votes.append(Vote(expert, (best,), tuple((i, o / total) for i, o in odds.items()), ""))
    ballot = Ballot(tuple(votes))
    decision = Decision(reach[0].id, "all", (), reach[0].id, ballot, 0, "")
    return Choice.of(decision, world.frontiers)


def test_who_pointed_at_the_place_gains_and_who_pointed_away_is_not_listened_to(world: World):
    hindsight = Hindsight()
    assert hindsight.applied(WEIGHTED, SEATS) == WEIGHTED  # nothing was learned yet
    told = hindsight.learn(world, [choice(world, o2f=0.2, r2f=-0.2)] * 100, SEATS)
    assert told["decisions"] == 100
    weights = told["weights"]
    assert weights["r2f"] > 0.5
    assert weights["o2f"] == 0.0
    after = hindsight.applied(WEIGHTED, SEATS)
    assert dict(after.weights) == weights
    assert replace(after, weights=()) == WEIGHTED


def test_configured_weights_are_where_it_begins_and_count_once(world: World):
    hindsight = Hindsight()
    asked = replace(WEIGHTED, weights=(("o2f", 2.0), ("r2f", 0.0)))
    told = {}
    for _ in range(2):  # the second search runs with the weights of the first
        hindsight.applied(asked, SEATS)
        told = hindsight.learn(world, [choice(world, o2f=0.2, r2f=-0.2)], SEATS)
    once = Hindsight()
    once.applied(asked, SEATS)
    same = once.learn(world, [choice(world, o2f=0.2, r2f=-0.2)] * 2, SEATS)
    assert told["weights"] == pytest.approx(same["weights"])
    assert told["weights"]["o2f"] < 2.0


def test_the_plain_vote_hears_of_no_weights(world: World):
    hindsight = Hindsight()
    hindsight.learn(world, [choice(world, r2f=-0.2)] * 100, SEATS)
    assert hindsight.applied(ConsensusConfig(mode="strict"), SEATS) == ConsensusConfig(
        mode="strict"
    )
    assert hindsight.applied(WEIGHTED, ("o2f",)) == WEIGHTED  # others were seated
