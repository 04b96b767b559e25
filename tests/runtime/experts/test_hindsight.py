"""A found target teaches who was right: in a flat-land apartment, from the place where it ends."""

import math

import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment

from runtime import navigate
from runtime.config import Config, load
from runtime.core.types import Action, Ballot, Decision, Pose, Vote
from runtime.core.world import World
from runtime.experts.hindsight import Choice, Hindsight

SEATS = ('panel.experts=["o2f", "r2f"]',)


def config(*settings: str) -> Config:
    return load(None, [*SEATS, *settings])


@pytest.fixture(scope="module")
def world() -> World:
    """As it stands after a look around."""
    home, cfg = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)), config().navigate
    world = World.begin("toilet", ("toilet",), (), home.pose, 12, 0.18, cfg.map)
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
    hindsight, asked = Hindsight(), config('consensus.mode="weighted"')
    assert hindsight.applied(asked) == asked  # nothing was learned yet
    told = hindsight.learn(world, [choice(world, o2f=0.2, r2f=-0.2)] * 100, asked)
    assert told["decisions"] == 100
    weights = told["weights"]
    assert weights["r2f"] > 0.5
    assert weights["o2f"] == 0.0
    after = hindsight.applied(asked)
    assert dict(after.navigate.consensus.weights) == weights
    assert after.panel == asked.panel


def test_configured_weights_are_where_it_begins_and_count_once(world: World):
    hindsight = Hindsight()
    asked = config('consensus.mode="weighted"', 'consensus.weights=[["o2f", 2.0], ["r2f", 0.0]]')
    told = {}
    for _ in range(2):  # the second search runs with the weights of the first
        running = hindsight.applied(asked)
        told = hindsight.learn(world, [choice(world, o2f=0.2, r2f=-0.2)], running)
    once = Hindsight()
    once.applied(asked)
    same = once.learn(world, [choice(world, o2f=0.2, r2f=-0.2)] * 2, asked)
    assert told["weights"] == pytest.approx(same["weights"])
    assert told["weights"]["o2f"] < 2.0


def test_the_plain_vote_hears_of_no_weights(world: World):
    hindsight = Hindsight()
    hindsight.learn(world, [choice(world, r2f=-0.2)] * 100, config())
    assert hindsight.applied(config()) == config()
    other = load(None, ['panel.experts=["o2f"]', 'consensus.mode="weighted"'])
    assert hindsight.applied(other) == other  # others were seated
