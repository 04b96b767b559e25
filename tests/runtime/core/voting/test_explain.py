"""One line for a person: what was elected, by whose word, and what else it could have been."""

from dataclasses import replace

import pytest

from runtime.core.belief import Said, Taken
from runtime.core.types import Absence, Ballot, Decision, FrontierBrief, Missing, Vote
from runtime.core.voting.consensus import ConsensusConfig, elect
from runtime.core.voting.explain import in_words

FRONTIERS = [FrontierBrief(i, float(i), (), ()) for i in (1, 2, 3)]


def vote(expert: str, *ids: int) -> Vote:
    p = tuple((i, 1 / len(ids)) for i in ids)
    reasons = tuple((i, f"thing {i} (0.50)") for i in ids)
    return Vote(expert, ids, p, "; ".join(f"{i}: {why}" for i, why in reasons), reasons=reasons)


@pytest.mark.parametrize(
    ("votes", "mode", "line"),
    [
        (
            [vote("o2f", 2, 3), vote("r2f", 3)],
            "strict",
            "frontier 3, on which o2f and r2f agree (o2f: thing 3 (0.50); r2f: thing 3 (0.50)); "
            "the closest is 1; without o2f: 1; without r2f: 1",
        ),
        (
            [vote("o2f", 1), vote("r2f", 3)],
            "strict",
            "frontier 1, the closest, as o2f and r2f do not agree (x: late)",
        ),
        (
            [vote("o2f", 3)],
            "strict",
            "frontier 1, the closest, as o2f votes alone (x: late)",
        ),
        ([], "strict", "frontier 1, the closest, as no expert votes (x: late)"),
        (
            [vote("o2f", 3)],
            "lenient",
            "frontier 3, for which o2f alone speaks (o2f: thing 3 (0.50)); the closest is 1; "
            "without o2f: 1",
        ),
        (
            [vote("o2f", 3)],
            "best",
            "frontier 3, of which o2f is surest (o2f: thing 3 (0.50)); the closest is 1; "
            "without o2f: 1",
        ),
    ],
)
def test_it_says_who_and_what_else(votes: list[Vote], mode: str, line: str):
    ballot = Ballot(tuple(votes), (Missing("x", Absence.LATE),))
    assert in_words(elect(ballot, FRONTIERS, ConsensusConfig(mode=mode))) == line


def test_every_rule_has_words_even_where_no_set_names_the_winner():
    p = ((1, 0.1), (2, 0.2), (3, 0.7))
    for mode in ("best", "weighted", "majority-3"):
        cfg = ConsensusConfig(mode=mode, weights=(("o2f", 9.0),))
        decision = elect(Ballot((Vote("o2f", (1,), p, "it looks so"),)), FRONTIERS, cfg)
        assert decision.rule == mode.partition("-")[0]
        assert "o2f" in in_words(decision)


def test_nothing_to_choose_and_too_much_to_say():
    assert (
        in_words(elect(Ballot(), [], ConsensusConfig(mode="strict")))
        == "no frontier can be reached"
    )
    prose = Vote("sle", (2,), ((2, 1.0),), "because " * 40)
    line = in_words(elect(Ballot((prose,)), FRONTIERS, ConsensusConfig(mode="lenient")))
    assert "…" in line
    assert len(line) < 220


def test_a_reason_of_the_whole_set_is_told_whole():
    prose = Vote("o2f", (2, 3), ((2, 0.5), (3, 0.5)), "both are near a sink; 3: it is a bathroom")
    assert prose.reason_for(3) == prose.reason
    line = in_words(elect(Ballot((prose,)), FRONTIERS, ConsensusConfig(mode="lenient")))
    assert "o2f: both are near a sink; 3: it is a bathroom" in line


def test_an_agreement_on_what_is_too_far_away_is_told():
    votes = (vote("o2f", 3), vote("r2f", 3))
    decision = elect(Ballot(votes), FRONTIERS, ConsensusConfig(mode="strict", detour_m=1.0))
    assert in_words(decision).startswith(
        "frontier 1, the closest, as what o2f and r2f agree on is too far away"
    )


def test_a_planned_order_is_told_with_whose_word_it_rests_on():
    took = Taken(3.0, 2.0, (Said("o2f", 0.5), Said("sle", 0.2)))
    planned = Decision(
        3, "prior", (3,), 1, Ballot((vote("o2f", 3),)), 0, "", (("o2f", 1), ("r2f", 3)), (3, 1, 2),
        taken=took,
    )  # fmt: skip
    assert in_words(planned) == (
        "frontier 3, where it is found soonest by the unknown and the word of o2f and sle "
        "(o2f: thing 3 (0.50)); then 1, 2; the closest is 1; without o2f: 1"
    )
    nobody = replace(planned, ballot=Ballot(), taken=Taken(3.0, 2.0))
    assert in_words(nobody).startswith(
        "frontier 3, where it is found soonest by the unknown alone;"
    )
    silent = Decision(1, "ahead", (), 1, Ballot(), 0, "", order=(1, 2))
    assert in_words(silent) == (
        "frontier 1, from where the unknown is looked through soonest, as nobody was asked; then 2"
    )
