"""A decision told in full: who, by what, who not, and what else."""

from dataclasses import replace

import pytest

from runtime.core.belief import Belief, Expected
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
    ANSWERED_BY,
    FRONTIERS_TOLD,
    OBJECTS_TOLD,
    PLACES_TOLD,
    WHO,
    ToldDecision,
    in_full,
)
from runtime.experts.cloud import RUNG
from runtime.experts.panel import EXPERTS
from runtime.experts.seating import COUNTS, EMBEDDING, HEAD, LANGUAGE, LOCAL, TOGETHER
from runtime.robot.told_votes import TOLD

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
    against=(3,), reasons=((7, "sink, towel (0.61)"), (9, "nothing known (0.29)")),
)  # fmt: skip
R2F = Vote("r2f", (7,), ((7, 0.8),), "door of bathroom (0.80)", rung="embedding")
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
        "  A frontier is an edge of what has been seen; behind it is the unknown.",
        "Rule: all that voted name it (o2f and r2f).",
        "o2f, by the objects near by, votes for 7 and 9; answered by the model on the robot "
        "in 0.34 s.",
        "  frontier 7, at (3.1, -0.4) m, 4.2 m on foot, 61 % of its belief: sink, towel (0.61)",
        "    it knew: sink 0.6 m from it (83 % sure), towel 1.2 m from it (70 % sure), 3.0 m² "
        "unknown behind it",
        "  frontier 9, 5.0 m on foot, 29 % of its belief: nothing known (0.29)",
        "    it knew: 0.0 m² unknown behind it",
        "  against 3",
        "r2f, by the kind of room, votes for 7; answered by the likeness of words, without a "
        "language model.",
        "  frontier 7, at (3.1, -0.4) m, 4.2 m on foot, 80 % of its belief: door of bathroom "
        "(0.80)",
        "    it knew: bathroom 62 %, kitchen 20 %, study 10 %, a doorway, 3.0 m² unknown behind it",
        "sle, by the look of the view, does not vote: no preference.",
        "Without o2f it would have been frontier 3, at (1.0, 0.0) m, 1.1 m on foot.",
        "Without r2f it would have been frontier 3, at (1.0, 0.0) m, 1.1 m on foot.",
        "The closest was frontier 3, at (1.0, 0.0) m, 1.1 m on foot.",
    )


@pytest.mark.parametrize(
    ("votes", "cfg", "rule"),
    [
        (
            (O2F, replace(O2F, expert="r2f")),
            {},
            "all that voted name it (o2f and r2f), as they do 9; of these it is the nearest",
        ),
        (
            (O2F, replace(O2F, expert="r2f")),
            {"rank": "farthest"},
            "all that voted name it (o2f and r2f), as they do 7; of these it is ranked first",
        ),
        (
            (O2F, R2F, replace(R2F, expert="sle", frontiers=(3,))),
            {},
            "not all agree, but two of them name it (o2f and r2f)",
        ),
        ((R2F,), {"mode": "lenient"}, "r2f alone voted, and here one voice counts"),
        ((R2F,), {"mode": "best"}, "r2f is surest of it"),
        (
            (R2F,),
            {"mode": "majority-3"},
            "it came most often in samples of what r2f holds likely",
        ),
        (
            (O2F,),
            {"mode": "weighted", "weights": (("o2f", 9.0),)},
            "the least way, shortened by the weighed evidence of o2f",
        ),
        ((R2F,), {}, "the closest, as r2f votes alone"),
        ((), {}, "the closest, as no expert votes"),
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
        "Rule: the one with the most unknown behind it for the way there, as no expert votes."
        in lines
    )
    assert lines[-2:] == (
        "The closest was frontier 3, 1.1 m on foot.",
        "When the votes were in it was gone: the robot went for frontier 3.",
    )


def test_what_would_have_been_the_same_is_said_so():
    third = replace(R2F, expert="sle")
    lines = in_full(told(replace(O2F, frontiers=(3,)), replace(R2F, frontiers=(3,)), third))
    assert "Without sle it would have been the same." in lines
    assert lines[-1] == "It is the closest, too."
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


def test_experts_and_rungs_are_those_that_there_are():
    assert set(WHO) == set(EXPERTS)
    models = {LOCAL, RUNG, LANGUAGE, HEAD, EMBEDDING}
    assert set(ANSWERED_BY) == {*models, COUNTS, TOGETHER, TOLD}


def test_what_is_not_among_the_places_that_are_told_is_elsewhere():
    places = tuple(Expected("frontier", i, (0.0, 0.0), 0.2, "") for i in range(4))
    decision = Decision(7, "geometry", (), 3, Ballot(), 0, "", belief=Belief(places, 0.2))
    lines = in_full(ToldDecision(2, "mug", decision, BRIEF, {}, 7))
    assert "Where it may be, likeliest first (40 % elsewhere):" in lines
    assert len([line for line in lines if line.startswith("  behind frontier")]) == PLACES_TOLD


def test_a_planned_order_tells_what_comes_after_and_where_the_thing_may_be():
    places = (
        Expected("frontier", 7, (3.14, -0.4), 0.62, "3.0 m² unknown behind it, +1.2 nats by o2f"),
        Expected("surface", "b4", (1.0, 2.0), 0.1, "0.8 m² on which it is missed with 40 %"),
    )
    decision = Decision(
        7, "prior", (7,), 3, Ballot((O2F,)), 0, "", (("o2f", 3),), (7, 3, 9), Belief(places, 0.28)
    )  # fmt: skip
    lines = in_full(ToldDecision(2, "mug", decision, BRIEF, {7: (3.14, -0.4)}, 7))
    begins = lines.index(
        "Rule: by what is unknown and what is said by o2f, the thing is found soonest in the mean "
        "by looking there first."
    )
    assert lines[begins + 1 : begins + 5] == (
        "After it: 3, 9, as far as is known now.",
        "Where it may be, likeliest first (28 % elsewhere):",
        "  behind frontier 7, at (3.1, -0.4) m, 62 %: 3.0 m² unknown behind it, +1.2 nats by o2f",
        "  surface b4, at (1.0, 2.0) m, 10 %: 0.8 m² on which it is missed with 40 %",
    )
    assert "Without o2f it would have been frontier 3, 1.1 m on foot." in lines
    silent = replace(decision, rule="ahead", chosen=(), ballot=Ballot(), without=(), belief=None)
    assert (
        "Rule: looking there first sees most of the unknown soonest, as no expert votes."
        in in_full(ToldDecision(2, "mug", silent, BRIEF, {}, 7))
    )
