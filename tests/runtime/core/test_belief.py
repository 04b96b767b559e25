"""A probability over places: what it weighs, and what is told of it."""

from typing import NamedTuple

import numpy as np
import pytest

from runtime.core.belief import ELSEWHERE_M2, LIKELIEST, STANDING, Ahead, Belief, Expected, believed


class Patch(NamedTuple):
    id: int
    xy: tuple[float, float]
    area_m2: float
    missed: float


def ahead(*areas_m2: float, **more) -> Ahead:
    n = len(areas_m2)
    at = tuple((float(i), 0.0) for i in range(n))
    return Ahead(tuple(range(n)), at, areas_m2, np.ones(n), np.ones(n), np.ones((n, n)), **more)


def test_frontiers_weigh_their_unknown_area_and_surfaces_what_was_missed():
    found = believed(ahead(4.0, 1.0, patches=(Patch(9, (5.0, 5.0), 2.0, 0.5),)), {})
    total = 4.0 + 1.0 + STANDING * 1.0 + ELSEWHERE_M2
    assert [(p.kind, p.id) for p in found.places] == [
        ("frontier", 0),
        ("frontier", 1),
        ("surface", 9),
    ]
    assert [p.p * total for p in found.places] == pytest.approx([4.0, 1.0, STANDING])
    assert found.elsewhere * total == pytest.approx(ELSEWHERE_M2)


def test_evidence_multiplies_and_is_told_with_whose_it_is():
    plain, said = (
        believed(ahead(1.0, 1.0), {}),
        believed(ahead(1.0, 1.0), {1: 1.0}, {1: "kind of room"}),
    )
    assert plain.places[0].p == plain.places[1].p
    assert said.places[0].id == 1
    assert said.places[0].p / said.places[1].p == pytest.approx(np.e)
    assert said.places[0].why == "1.0 m² unknown behind it, +1.0 nats by kind of room"


def test_where_nothing_is_left_all_is_elsewhere():
    assert believed(ahead(), {}) == Belief((), 1.0)


def test_the_likeliest_are_told_and_what_the_others_come_to():
    places = tuple(Expected("frontier", i, (0.0, 0.0), 0.05, "") for i in range(LIKELIEST + 4))
    told = Belief(places, 0.3).told()
    assert len(told["places"]) == LIKELIEST
    assert told["others"] == pytest.approx(0.5)
