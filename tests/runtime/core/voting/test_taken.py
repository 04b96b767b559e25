"""What a frontier was taken for, in numbers and in words."""

import pytest

from runtime.core.belief import Belief, Expected, Said, Taken, signed
from runtime.core.types import Ballot, Decision
from runtime.core.voting.taken import LEAST_NATS, by_whom, in_words, said_of, taken


def test_only_who_says_something_of_it_is_named_and_who_said_it_earlier_is_told_so():
    evidence = {"sle": {7: -0.3}, "o2f": {7: 0.4, 9: 1.0}, "r2f": {7: 0.9 * LEAST_NATS}}
    said = said_of(7, evidence, {"o2f": {7: 0.5}, "r2f": {7: 0.1}, "sle": {9: 1.0}})
    assert said == (Said("o2f", 0.4), Said("sle", -0.3, earlier=True))
    assert by_whom(said) == "objects near by and look of the view (said earlier)"
    assert said_of(7, evidence) == (Said("o2f", 0.4), Said("sle", -0.3))
    assert by_whom(said_of(8, evidence)) == ""


def test_all_that_is_known_is_told_in_one_line():
    all_of_it = Taken(4.23, 3.04, (Said("o2f", 0.42), Said("r2f", -0.2)), 0.124, 1, 9)
    assert in_words(all_of_it, asked=True) == (
        "4.2 m on foot, 3.0 m² unknown behind it, +0.4 nats by objects near by, "
        "-0.2 nats by kind of room, 12 % of the belief, first of 9 in the planned order"
    )
    assert in_words(Taken(4.23), asked=True) == "4.2 m on foot"
    assert "no expert says anything of it" in in_words(Taken(4.23, 3.04), asked=True)
    assert in_words(Taken(4.23, 3.04, place=2, planned=3), asked=False) == (
        "4.2 m on foot, 3.0 m² unknown behind it, number 2 of 3 in the planned order"
    )


@pytest.mark.parametrize(("nats", "text"), [(0.44, "+0.4"), (-0.04, "+0.0"), (-1.0, "-1.0")])
def test_nats_have_a_sign(nats: float, text: str):
    assert signed(nats) == text


def test_its_share_is_that_of_the_frontier_not_of_a_surface_of_the_same_number():
    places = (
        Expected("surface", 7, (0.0, 0.0), 0.6, ""),
        Expected("frontier", 7, (0.0, 0.0), 0.3, ""),
    )
    decision = Decision(7, "prior", (7,), 7, Ballot(), 0, "", belief=Belief(places, 0.1))
    assert taken(decision, 2.0, None, ()) == Taken(2.0, share=0.3)
