"""Weights learned with hindsight: what an expert's evidence saved in metres."""

import math
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.types import Vote
from runtime.core.voting.comparison_modes import evidence
from runtime.core.voting.expert_weights import NormalEquations, learned, weights

EXPERTS = ("o2f", "r2f", "sle")


def vote(expert: str, rng: random.Random, n: int = 6) -> Vote:
    """Evidence that is nowhere cut off."""
    raw = [math.exp(rng.uniform(-1.0, 1.0)) for _ in range(n)]
    p = tuple((i, x / sum(raw)) for i, x in enumerate(raw))
    return Vote(expert, (0,), p, "")


def lesson(true: dict[str, float], rng: random.Random, noise_m: float = 0.0):
    """Votes, and a way on that is as the true weights have it."""
    votes = [vote(e, rng) for e in EXPERTS]
    said = {v.expert: evidence(v, range(6)) for v in votes}
    return votes, {
        i: 8.0 - sum(true[e] * said[e][i] for e in EXPERTS) + rng.gauss(0.0, noise_m)
        for i in range(6)
    }


@settings(max_examples=20)
@given(st.tuples(*(st.floats(0.0, 3.0) for _ in EXPERTS)), st.integers(0, 1000))
def test_what_was_true_is_found_out(true, seed: int):
    truth, rng = dict(zip(EXPERTS, true, strict=True)), random.Random(seed)
    state = NormalEquations.of(EXPERTS)
    for _ in range(60):
        state = learned(state, *lesson(truth, rng))
    found = dict(weights(state, {}, decisions=1e-6))
    assert found == pytest.approx(truth, abs=1e-2)
    assert state.decisions == 60


def test_an_expert_at_random_and_one_that_misleads_are_not_listened_to():
    truth, rng = {"o2f": -1.5, "r2f": 1.0, "sle": 0.0}, random.Random(7)
    state = NormalEquations.of(EXPERTS)
    for _ in range(1500):
        state = learned(state, *lesson(truth, rng, noise_m=2.0))
    found = dict(weights(state, {}))
    assert found["o2f"] == 0.0
    assert found["r2f"] == pytest.approx(1.0, abs=0.2)
    assert found["sle"] < 0.2


@given(st.tuples(*(st.floats(0.0, 3.0) for _ in EXPERTS)))
def test_with_nothing_learned_the_prior_stands_and_much_of_it_holds(prior):
    start = dict(zip(EXPERTS, prior, strict=True))
    state = NormalEquations.of(EXPERTS)
    assert dict(weights(state, start)) == pytest.approx(start, abs=1e-4)
    rng = random.Random(1)
    for _ in range(5):
        state = learned(state, *lesson(dict.fromkeys(EXPERTS, 1.0), rng))
    near = dict(weights(state, start, decisions=1e9))
    assert near == pytest.approx(start, abs=1e-3)


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_the_order_of_decisions_does_not_matter(seed: int):
    rng = random.Random(seed)
    lessons = [lesson({"o2f": 1.0, "r2f": 0.2, "sle": 0.0}, rng, 1.0) for _ in range(10)]
    one = two = NormalEquations.of(EXPERTS)
    for votes, onward in lessons:
        one = learned(one, votes, onward)
    for votes, onward in lessons[::-1]:
        two = learned(two, votes, onward)
    assert dict(weights(one, {})) == pytest.approx(dict(weights(two, {})), abs=1e-3)


def test_nothing_is_learned_where_there_is_nothing_to_compare():
    state, rng = NormalEquations.of(EXPERTS), random.Random(0)
    votes, onward = lesson(dict.fromkeys(EXPERTS, 1.0), rng)
    assert learned(state, [], onward) is state
    assert learned(state, votes, {0: 3.0}) is state
    assert learned(state, votes, {0: 3.0, 1: math.inf}) is state
    stranger = learned(state, [vote("x", rng)], onward)
    assert not np.any(stranger.products)
    assert dict(weights(stranger, {})) == dict.fromkeys(EXPERTS, 0.0)
