"""SLE by what was seen toward frontiers: what it asks, and what it makes of the answers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.types import Absence, Brief, FrontierBrief, Missing, Vote
from runtime.core.voting.likelihood_experts import ExpertConfig, LikelihoodQuestion
from runtime.core.voting.sight_experts import (
    HEAD,
    LANGUAGE,
    SIGHT_REFERENCES,
    sight_evidence,
    sight_questions,
    vote_sights,
)

CFG, SAYS = ExpertConfig(), " Further on there is a"


def answers(nats: dict[tuple[str, str], float]) -> dict[LikelihoodQuestion, float]:
    return {LikelihoodQuestion(SAYS, f" {word}", seen): v for (seen, word), v in nats.items()}


def scored(goal: dict[str, float], others: dict[str, float]) -> dict[LikelihoodQuestion, float]:
    """By view the nats of a mug, and of all references."""
    known = {(seen, word): others[seen] for seen in goal for word in SIGHT_REFERENCES}
    return answers(known | {(seen, "mug"): nats for seen, nats in goal.items()})


def test_each_view_is_asked_of_the_goal_and_of_the_references_once():
    asked = sight_questions(SAYS, "bed", ("none", "a"))
    assert {(q.seen, q.context) for q in asked} == {("none", SAYS), ("a", SAYS)}
    assert [q.continuation for q in asked if q.seen == "a"] == [f" {w}" for w in SIGHT_REFERENCES]
    assert len(sight_questions(SAYS, "mug", ("a",))) == 1 + len(SIGHT_REFERENCES)


@given(st.floats(-9, 9), st.floats(-9, 9))
def test_what_makes_every_word_likely_and_a_word_that_is_likely_anyway_are_no_evidence(
    talkative: float, usual: float
):
    told = scored({"none": usual, "a": usual + talkative + 2.0}, {"none": 0.0, "a": talkative})
    known = sight_evidence(SAYS, "mug", ("a",), "none", told)
    assert known == {"a": pytest.approx(2.0)}


def test_a_view_of_which_not_all_is_answered_has_no_evidence():
    told = scored({"none": 0.0, "a": 1.0, "b": 3.0}, {"none": 0.0, "a": 0.0, "b": 0.0})
    del told[LikelihoodQuestion(SAYS, " lamp", "b")]
    assert sight_evidence(SAYS, "mug", ("a", "b"), "none", told) == {"a": 1.0}
    del told[LikelihoodQuestion(SAYS, " mug", "none")]
    assert sight_evidence(SAYS, "mug", ("a", "b"), "none", told) == {}


def test_of_a_frontier_that_was_never_seen_nothing_is_known():
    told = Brief("mug", 0, tuple(FrontierBrief(i, 1.0, (), ()) for i in (1, 2, 3)))
    shy = vote_sights(told, {2: -9.0}, CFG, LANGUAGE)
    assert isinstance(shy, Missing)
    assert shy.why is Absence.NO_PREFERENCE
    good = vote_sights(told, {2: 2.0}, CFG, LANGUAGE)
    assert isinstance(good, Vote)
    assert (good.frontiers, good.reason) == ((2,), "2: the view toward it")
    assert vote_sights(told, {}, CFG, HEAD) == Missing("sle", Absence.NO_EVIDENCE)


def test_who_prefers_none_says_what_was_seen_all_the_same():
    told = Brief("mug", 0, tuple(FrontierBrief(i, 1.0, (), ()) for i in (1, 2, 3, 4)))
    shy = vote_sights(told, {4: 0.1, 2: 0.0, 3: -0.2}, CFG, LANGUAGE)
    assert isinstance(shy, Missing)
    assert shy.cause == (
        "no preference: likeliest are 4 (0.303) and 1 (0.257, never looked at); it votes from "
        "0.375 on, 1.5 times an equal share"
    )


def test_what_was_taught_how_much_lies_beyond_counts_the_unknown_area_less():
    areas = {1: 0.0, 2: 19.8}
    told = Brief(
        "mug", 0, tuple(FrontierBrief(i, 1.0, (), (), unknown_m2=m2) for i, m2 in areas.items())
    )
    for rung, power in ((LANGUAGE, 0.5), (HEAD, 0.25)):
        vote = vote_sights(told, {1: 0.0, 2: 0.0}, CFG, rung)
        assert isinstance(vote, Vote)
        p = dict(vote.probabilities)
        assert p[2] / p[1] == pytest.approx((20.0 / 0.2) ** power)
