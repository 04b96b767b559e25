"""What a search tells of its belief."""

from runtime.core.belief import Belief, Expected, Said, Taken
from runtime.core.types import Absence, Ballot, Decision, Missing
from runtime.loops.reports import told_belief, told_taken


def test_a_belief_is_told_as_it_is_published_and_none_where_none_is_worked_out():
    place = Expected("frontier", 4, (1.0, 2.0), 0.71234, "5.0 m² unknown behind it")
    decision = Decision(4, "prior", (4,), 4, Ballot(), 0, "", belief=Belief((place,), 0.28766))
    assert told_belief(decision) == {
        "places": [
            {"kind": "frontier", "id": 4, "xy": (1.0, 2.0), "p": 0.712,
             "why": "5.0 m² unknown behind it"}
        ],
        "others": 0.288,
    }  # fmt: skip
    assert told_belief(None) is None
    assert told_belief(Decision(4, "all", (4,), 4, Ballot(), 0, "")) is None


def test_what_a_frontier_was_taken_for_is_told_in_numbers_and_in_words():
    took = Taken(4.234, 3.04, (Said("o2f", 0.123, earlier=True),), 0.12345, 1, 9)
    ballot = Ballot((), (Missing("o2f", Absence.NO_EVIDENCE),))
    assert told_taken(Decision(4, "prior", (4,), 4, ballot, 0, "", taken=took)) == {
        "way_m": 4.234, "unknown_m2": 3.04, "share": 0.123, "place": 1, "planned": 9,
        "said": [{"expert": "o2f", "nats": 0.123, "earlier": True}],
        "in_words": "4.2 m on foot, 3.0 m² unknown behind it, +0.1 nats by objects near by (said "
        "earlier), 12 % of the belief, first of 9 in the planned order",
    }  # fmt: skip
    assert told_taken(Decision(None, "none", (), None, Ballot(), 0, "")) is None
