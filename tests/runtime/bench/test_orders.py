"""The home in which a planned order is timed is one, and what is timed is what a decision does."""

import numpy as np

from runtime.bench.orders import EXPERTS, HOME_M, PLACES, frontiers, home, stages
from runtime.core.belief import Ahead
from runtime.core.types import Decision
from runtime.core.voting.search_order import MOST


def test_every_room_is_reached_by_its_doors():
    terrain = home()
    found = frontiers(terrain)
    assert len(found) == len(PLACES) == MOST
    assert all(np.isfinite(f.distance_m) for f in found)
    farthest = max(found, key=lambda f: f.distance_m)
    assert farthest.goal_xy == PLACES[-1]
    assert farthest.distance_m > np.hypot(*HOME_M) / 2
    assert 0.8 < terrain.traversable.mean() < 0.95  # of the rest the body fits nowhere


def test_ways_are_measured_and_an_order_planned():
    (_, ways), (_, order) = stages()
    ahead, decision = ways(), order()
    assert isinstance(ahead, Ahead)
    assert np.isfinite(ahead.between_m).all()
    assert ahead.between_m.shape == (MOST, MOST)
    assert isinstance(decision, Decision)
    assert (decision.rule, len(decision.order)) == ("prior", MOST)
    assert [expert for expert, _ in decision.without] == sorted(EXPERTS)
