"""A decision told in full: who, by what, who not, and what else."""

from dataclasses import replace

import pytest

from runtime.core.belief import Belief, Expected, Said, Taken
from runtime.core.types import (
    Absence,
    Ballot,
    Brief,
    Decision,
    FrontierBrief,
    Missing,
    NearbyObject,
    Vote,
)
from runtime.core.voting.consensus import ConsensusConfig, elect
from runtime.core.voting.in_full import (
    FRONTIERS_TOLD,
    OBJECTS_TOLD,
    PLACES_TOLD,
    ToldDecision,
    in_full,
)

SINK = NearbyObject("sink", 0.83, 0.6)
TOWEL = NearbyObject("towel", 0.7, 1.24)
ROOMS = (("kitchen", 0.2), ("bathroom", 0.62), ("study", 0.1), ("hallway", 0.08))
BRIEF = Brief(
    "mug",
    0,
    (
        FrontierBrief(3, 1.1, (), ()),
        FrontierBrief(7, 4.23, (SINK, TOWEL), ROOMS, doorway=True, unknown_m2=3.04),
        FrontierBrief(9, 5.0, (), ()),
    ),
)
O2F = Vote(
    "o2f", (7, 9), ((3, 0.1), (7, 0.61), (9, 0.29)), "all",
    against=(3,), reasons=((7, "sink, towel"), (9, "no object known near it")),
)  # fmt: skip
R2F = Vote("r2f", (7,), ((7, 0.8),), "door of bathroom", rung="embedding")
SLE = Missing("sle", Absence.NO_PREFERENCE)


def told(*votes: Vote, missing: tuple[Missing, ...] = (), **cfg) -> ToldDecision:
    ballot = Ballot(votes, missing, {"o2f": 0.342})
    rule = ConsensusConfig(**{"mode": "strict", **cfg})
    decision = elect(ballot, BRIEF.frontiers, rule, 0, "frontier 5 is gone")
    at = {3: (1.0, 0.0), 7: (3.14, -0.4)}
    return ToldDecision(12, "mug", decision, BRIEF, at, decision.frontier, 34.4)


def test_it_says_where_to_by_whom_by_what_and_what_else():
    assert in_full(told(O2F, R2F, missing=(SLE,))) == (
        'Decision 12 of the search for "mug", 34 s into it.',
        "It was due: frontier 5 is gone.",
        "Taken: frontier 7, at (3.1, -0.4) m, 4.2 m on foot.",
        "  What took it: 4.2 m on foot.",
        "  A frontier is an edge of what has been seen; behind it is the unknown.",
        "Rule: all that voted name it (objects near by and kind of room).",
        "Objects near by (o2f): votes for 7 and 9; answered by the model on the robot in 0.34 s.",
        "  frontier 7, at (3.1, -0.4) m, 4.2 m on foot, 61 % of its belief: sink, towel",
        "    it knew: sink 0.6 m from it (83 % sure), towel 1.2 m from it (70 % sure), 3.0 m² "
        "unknown behind it",
        "  frontier 9, 5.0 m on foot, 29 % of its belief: no object known near it",
        "    it knew: 0.0 m² unknown behind it",
        "  against 3",
        "Kind of room (r2f): votes for 7; answered by the likeness of words, without a language "
        "model.",
        "  frontier 7, at (3.1, -0.4) m, 4.2 m on foot, 80 % of its belief: door of bathroom",
        "    it knew: bathroom 62 %, kitchen 20 %, study 10 %, a doorway, 3.0 m² unknown behind it",
        "Look of the view (sle): does not vote: no preference.",
        "Without objects near by it would have been frontier 3, at (1.0, 0.0) m, 1.1 m on foot.",
        "Without kind of room it would have been frontier 3, at (1.0, 0.0) m, 1.1 m on foot.",
        "The closest was frontier 3, at (1.0, 0.0) m, 1.1 m on foot.",
    )


@pytest.mark.parametrize(
    ("votes", "cfg", "rule"),
    [
        (
            (O2F, replace(O2F, expert="sle")),
            {},
            "all that voted name it (objects near by and look of the view), as they do 9; of these "
            "it is the nearest",
        ),
        (
            (O2F, replace(O2F, expert="sle")),
            {"rank": "farthest"},
            "all that voted name it (objects near by and look of the view), as they do 7; of these "
            "it is ranked first",
        ),
        (
            (O2F, R2F, replace(R2F, expert="sle", frontiers=(3,))),
            {},
            "two of them name it (objects near by and kind of room)",
        ),
        ((R2F,), {"mode": "lenient"}, "one alone voted, and here one voice counts (kind of room)"),
        ((R2F,), {"mode": "best"}, "the surest of them names it (kind of room)"),
        (
            (R2F,),
            {"mode": "majority-3"},
            "it came most often in samples of what one of them holds likely (kind of room)",
        ),
        (
            (O2F,),
            {"mode": "weighted", "weights": (("o2f", 9.0),)},
            "the least way, shortened by the weighed evidence of all (objects near by)",
        ),
        (
            (R2F,),
            {},
            "it is the closest: nobody's word decided, as kind of room votes alone",
        ),
        ((), {}, "it is the closest: nobody's word decided, as nobody was asked"),
    ],
)
def test_every_rule_is_told(votes: tuple[Vote, ...], cfg: dict, rule: str):
    assert f"Rule: {rule}." in in_full(told(*votes, **cfg))


def test_the_fallback_by_geometry_says_what_it_weighs():
    rule = ConsensusConfig(mode="strict", fallback="geometry")
    decision = elect(Ballot(), BRIEF.frontiers, rule, 0, "", (9, 7, 3))
    lines = in_full(ToldDecision(1, "mug", decision, BRIEF, {}, 3))
    assert lines[:2] == (
        'Decision 1 of the search for "mug".', "It was due: nobody noted why.",
    )  # fmt: skip
    assert (
        "Rule: the most unknown behind it for the way there: nobody's word decided, as nobody was "
        "asked." in lines
    )
    assert lines[-2:] == (
        "The closest was frontier 3, 1.1 m on foot.",
        "When the votes were in it was gone: the robot went for frontier 3.",
    )


def test_what_would_have_been_the_same_is_said_so():
    third = replace(R2F, expert="sle")
    lines = in_full(told(replace(O2F, frontiers=(3,)), replace(R2F, frontiers=(3,)), third))
    assert lines[-2:] == ("Any one expert left out: the same.", "It is the closest, too.")
    assert "    it knew: the camera's picture toward it, 3.0 m² unknown behind it" in lines


def test_one_expert_for_two_knows_what_both_would():
    lines = in_full(told(replace(O2F, expert="both"), mode="lenient"))
    [knew, _] = [line for line in lines if "it knew" in line]
    assert "sink 0.6 m from it" in knew
    assert "bathroom 62 %" in knew


def test_nowhere_to_go_is_told_and_no_more():
    nowhere = elect(Ballot(), (), ConsensusConfig(mode="strict"))
    lines = in_full(ToldDecision(2, "mug", nowhere, Brief("mug", 0, ()), {}, None))
    assert lines[2:] == (
        "No frontier (an edge of what has been seen) could be reached: none was taken",
    )


def test_much_is_cut_short_and_what_a_terminal_obeys_left_out():
    many = tuple(range(1, FRONTIERS_TOLD + 3))
    things = tuple(NearbyObject(f"thing{n}", 0.9, n / 10) for n in range(OBJECTS_TOLD + 2))
    brief = Brief("mug", 0, tuple(FrontierBrief(i, float(i), things, ()) for i in many))
    p = tuple((i, 1 / len(many)) for i in many)
    vote = Vote("o2f", many, p, "\x1b[31m" + "because " * 100, rung="a model of mine")
    decision = elect(Ballot((vote,)), brief.frontiers, ConsensusConfig(mode="lenient"))
    lines = in_full(ToldDecision(1, "mug", decision, brief, {}, None))
    assert "  and 2 less likely" in lines
    assert f"thing{OBJECTS_TOLD}" not in "".join(lines)
    assert "answered by a model of mine." in "".join(lines)
    assert all(line.isprintable() for line in lines)
    assert max(map(len, lines)) < 400


def test_a_vote_on_what_the_brief_does_not_have_is_told_without_it():
    lines = in_full(replace(told(O2F, R2F), brief=Brief("mug", 0, ())))
    assert "Taken: frontier 7, at (3.1, -0.4) m." in lines
    assert not [line for line in lines if "it knew" in line]


def test_what_is_not_among_the_places_that_are_told_is_elsewhere():
    places = tuple(Expected("frontier", i, (0.0, 0.0), 0.2, "") for i in range(4))
    decision = Decision(7, "geometry", (), 3, Ballot(), 0, "", belief=Belief(places, 0.2))
    lines = in_full(ToldDecision(2, "mug", decision, BRIEF, {}, 7))
    assert "Where it may be, likeliest first (40 % elsewhere):" in lines
    assert len([line for line in lines if line.startswith("  behind frontier")]) == PLACES_TOLD


def test_a_planned_order_tells_what_comes_after_and_where_the_thing_may_be():
    places = (
        Expected("frontier", 9, (3.1, 2.0), 0.52, "3.0 m² unknown behind it"),
        Expected("surface", "b4", (1.0, 2.0), 0.1, "0.8 m² on which it is missed with 40 %"),
    )
    took = Taken(4.2, 3.04, (Said("o2f", 0.42), Said("sle", -0.21, earlier=True)), 0.07, 1, 3)
    decision = Decision(
        7, "prior", (7,), 3, Ballot((O2F,), (SLE,)), 0, "",
        (("o2f", 3), ("r2f", 7), ("sle", 7)), (7, 3, 9), Belief(places, 0.38), taken=took,
    )  # fmt: skip
    lines = in_full(ToldDecision(2, "mug", decision, BRIEF, {7: (3.14, -0.4)}, 7))
    begins = lines.index("Taken: frontier 7, at (3.1, -0.4) m, 4.2 m on foot.")
    assert lines[begins + 1 : begins + 7] == (
        "  What took it: 4.2 m on foot, 3.0 m² unknown behind it, +0.4 nats by objects near by, "
        "-0.2 nats by look of the view (said earlier), 7 % of the belief, first of 3 in the "
        "planned order.",
        "  A frontier is an edge of what has been seen; behind it is the unknown.",
        "Rule: the thing is found soonest in the mean by looking there first, by the unknown and "
        "what all say.",
        "After it: 3, 9, as far as is known now.",
        "Where it may be, likeliest first (38 % elsewhere):",
        "  behind frontier 9, at (3.1, 2.0) m, 52 %: 3.0 m² unknown behind it",
    )
    assert "Without objects near by it would have been frontier 3, 1.1 m on foot." in lines
    assert "Without kind of room or look of the view: the same." in lines


def test_where_nobody_was_asked_nobody_is_said_to_say_nothing():
    took = Taken(4.2, 3.04, (), 0.07, 1, 3)
    silent = Decision(7, "ahead", (), 3, Ballot(), 0, "", order=(7, 3, 9), taken=took)
    lines = in_full(ToldDecision(2, "mug", silent, BRIEF, {}, 7))
    assert (
        "  What took it: 4.2 m on foot, 3.0 m² unknown behind it, 7 % of the belief, first of 3 "
        "in the planned order."
    ) in lines
    assert (
        "Rule: most of the unknown is seen soonest by looking there first: nobody's word decided, "
        "as nobody was asked."
    ) in lines
    heard = in_full(
        ToldDecision(2, "mug", replace(silent, ballot=Ballot((), (SLE,))), BRIEF, {}, 7)
    )
    assert "no expert says anything of it" in heard[3]


def test_of_a_decision_of_a_recording_what_the_brief_has_is_told():
    bare = Decision(7, "geometry", (), 3, Ballot((), (SLE,)), 0, "")
    lines = in_full(ToldDecision(2, "mug", bare, BRIEF, {}, 7))
    assert "  What took it: 4.2 m on foot, 3.0 m² unknown behind it." in lines
