"""What a search tells of its belief."""

from runtime.core.belief import Belief, Expected
from runtime.core.types import Ballot, Decision
from runtime.loops.reports import told_belief


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
