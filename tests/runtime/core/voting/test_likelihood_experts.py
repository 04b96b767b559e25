"""From scores to votes: what the experts ask, and what they make of the answers."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.types import Absence, Brief, FrontierBrief, Missing, NearbyObject, Vote
from runtime.core.voting.likelihood_experts import (
    OBJECTS,
    REFERENCES,
    ROOMS,
    ExpertConfig,
    LikelihoodQuestion,
    affinities,
    averaged,
    behind,
    door_questions,
    questions,
    recommend,
    vote_objects,
    vote_rooms,
    vote_where_known,
)

CFG = ExpertConfig()


def brief(*frontiers: FrontierBrief) -> Brief:
    return Brief("toilet", 0, frontiers)


def near(id: int, *objects: tuple[str, float, float]) -> FrontierBrief:
    return FrontierBrief(id, float(id), tuple(NearbyObject(*o) for o in objects), ())


def in_rooms(id: int, **rooms: float) -> FrontierBrief:
    return FrontierBrief(
        id, float(id), (), tuple((k.replace("_", " "), p) for k, p in rooms.items())
    )


def answered(score) -> dict[LikelihoodQuestion, float]:
    """Answers to everything about a sink, a bed and all room types."""
    asked = questions(OBJECTS, "toilet", ("sink", "bed")) + questions(ROOMS, "toilet", ())
    return {q: score(q) for q in asked}


def test_no_question_is_asked_twice():
    asked = questions(OBJECTS, "toilet", ("sink", "bed", "sink"))
    assert len(asked) == len(set(asked))
    assert all(q.continuation.startswith(" ") for q in asked)


def test_equal_contexts_stay_together_for_the_prefix_cache():
    contexts = [q.context for q in questions(OBJECTS, "toilet", ("sink", "lamp"))]
    changes = sum(a != b for a, b in pairwise(contexts))
    assert changes == len(set(contexts)) - 1


@given(st.dictionaries(st.sampled_from([*REFERENCES, "toilet"]), st.floats(-20, 0)))
def test_words_that_are_likely_everywhere_win_nothing(bias: dict[str, float]):
    answers = answered(lambda q: bias.get(q.continuation.strip(), -5.0))
    found = affinities(OBJECTS, "toilet", ("sink", "bed"), answers)
    assert found["sink"] == pytest.approx(0.0, abs=1e-9)
    assert found["bed"] == pytest.approx(0.0, abs=1e-9)


def test_contexts_that_make_every_word_likely_win_nothing():
    answers = answered(lambda q: 3.0 if "sink" in q.context else -4.0)
    assert affinities(OBJECTS, "toilet", ("sink",), answers)["sink"] == pytest.approx(0.0)


def test_what_makes_the_goal_likely_wins():
    answers = answered(lambda q: -1.0 if "sink" in q.context and "toilet" in q.continuation else -5)
    found = affinities(OBJECTS, "toilet", ("sink", "bed"), answers)
    assert found["sink"] > 2.0 > found["bed"]


def test_unanswered_things_are_left_out():
    answers = answered(lambda q: -3.0)
    assert set(affinities(OBJECTS, "toilet", ("sink", "piano"), answers)) == {"sink"}
    assert affinities(OBJECTS, "toilet", ("sink",), {}) == {}


def test_o2f_prefers_near_and_certain_evidence():
    affinity = {"sink": 3.0, "sofa": -2.0}
    told = brief(
        near(1, ("sink", 0.9, 0.5)), near(2, ("sofa", 0.9, 0.5)), near(3, ("sink", 0.9, 3.4))
    )
    vote = vote_objects(told, affinity, CFG)
    assert isinstance(vote, Vote)
    assert vote.frontiers == (1,)
    p = dict(vote.probabilities)
    assert p[1] > p[3] > p[2]
    assert sum(p.values()) == pytest.approx(1.0)
    assert vote.reason == "1: sink"
    assert vote.reason_for(1) == "sink"


def test_the_goal_itself_is_no_evidence_for_the_goal():
    told = brief(near(1, ("toilet", 0.9, 0.5)), near(2, ("sofa", 0.9, 0.5)))
    outcome = vote_objects(told, {"toilet": 9.0, "sofa": 0.0}, CFG)
    assert outcome == Missing(
        "o2f", Absence.NO_PREFERENCE
    )  # one frontier with evidence is no choice


def test_r2f_follows_the_room_distribution():
    told = brief(
        in_rooms(1, bathroom=0.8, kitchen=0.2),
        in_rooms(2, kitchen=0.9, bathroom=0.1),
        in_rooms(3, study=1.0),
    )
    affinity = {"bathroom": 3.0, "kitchen": -0.5, "home office": -1.0}
    vote = vote_rooms(told, affinity, CFG)
    assert isinstance(vote, Vote)
    assert vote.frontiers == (1,)


def test_nothing_known_is_an_abstention():
    told = brief(near(1), near(2))
    assert vote_objects(told, {"sink": 1.0}, CFG) == Missing("o2f", Absence.NO_EVIDENCE)
    assert vote_rooms(told, {"bathroom": 1.0}, CFG) == Missing("r2f", Absence.NO_EVIDENCE)


def test_why_nothing_is_known_of_a_frontier_is_said_by_what_is_near_it():
    told = brief(
        near(1, ("sink", 0.9, 0.5)), near(2, ("lamp", 0.9, 0.5)), near(3), in_rooms(4, kitchen=1.0)
    )
    every = ExpertConfig(bar=0.0)
    objects = vote_objects(told, {"sink": 1.0}, every)
    rooms = vote_rooms(told, {"kitchen": 1.0}, every)
    assert isinstance(objects, Vote)
    assert isinstance(rooms, Vote)
    alone = ": by what is unknown behind it"
    nothing = f"no object or room known near it{alone}"
    assert [objects.reason_for(i) for i in (1, 2, 3, 4)] == [
        "sink", f"nothing near it that tells of the goal{alone}", nothing,
        f"no object known near it{alone}",
    ]  # fmt: skip
    assert [rooms.reason_for(i) for i in (2, 3, 4)] == [
        f"no room known near it{alone}",
        nothing,
        "kitchen",
    ]
    views = vote_where_known("sle", told, {1: (0.5, "the view toward it")}, every)
    assert isinstance(views, Vote)
    assert views.reason_for(3) == f"no view of it yet{alone}"


@given(st.dictionaries(st.integers(1, 9), st.floats(-30, 30), min_size=1, max_size=9))
def test_the_set_is_exactly_what_is_above_the_bar(evidence: dict[int, float]):
    told = brief(*(near(i) for i in sorted(evidence)))
    outcome = recommend("o2f", told, evidence, dict.fromkeys(evidence, "x"), CFG)
    weights = {
        i: math.exp((e - max(evidence.values())) / CFG.temperature) for i, e in evidence.items()
    }
    bar = CFG.bar / len(evidence)
    total = math.fsum(weights.values())
    expected = tuple(sorted(i for i in evidence if weights[i] / total >= bar))
    if expected:
        assert isinstance(outcome, Vote)
        assert outcome.frontiers == expected
    else:
        assert outcome == Missing("o2f", Absence.NO_PREFERENCE)


def test_equal_evidence_is_no_preference():
    told = brief(near(1), near(2), near(3))
    outcome = recommend("o2f", told, {1: 1.0, 2: 1.0, 3: 1.0}, {1: "", 2: "", 3: ""}, CFG)
    assert outcome == Missing("o2f", Absence.NO_PREFERENCE)


ALL_ROOMS = ("kitchen", "bathroom", "hallway")


def told_of_doors(likely: str) -> dict[LikelihoodQuestion, float]:
    """Answers of a model that says `likely` behind the hallway's door, and else the same room."""
    return {
        q: 3.0 * (q.continuation == f" {likely}" and "hallway" in q.context)
        + 5.0 * (q.continuation.strip() in q.context)
        for q in door_questions(ALL_ROOMS)
    }


def test_a_door_leads_to_another_room_type() -> None:
    doors = behind(ALL_ROOMS, told_of_doors("bathroom"))
    assert doors["hallway"]["bathroom"] > 0.8
    for room in ALL_ROOMS:
        assert room not in doors[room]
        assert sum(doors[room].values()) == pytest.approx(1.0)


def test_doors_are_unknown_while_a_question_is_open() -> None:
    answers = told_of_doors("bathroom")
    answers.popitem()
    assert behind(ALL_ROOMS, answers) == {}


def test_a_doorway_is_judged_by_what_it_leads_to() -> None:
    affinity = {"bathroom": 3.0, "kitchen": -1.0, "hallway": 0.0}
    doors = behind(ALL_ROOMS, told_of_doors("bathroom"))
    here = in_rooms(1, hallway=1.0), replace(in_rooms(2, hallway=1.0), doorway=True)
    vote = vote_rooms(brief(*here), affinity, CFG, doors)
    assert isinstance(vote, Vote)
    assert vote.frontiers == (2,)
    assert "door of hallway" in vote.reason


def test_evidence_of_another_kind_is_averaged_where_both_have_some() -> None:
    told = brief(near(1, ("sink", 0.9, 0.5)), near(2, ("sofa", 0.9, 0.5)), near(3))
    one = averaged({1: (2.0, "sink"), 2: (-1.0, "sofa")}, {1: (-4.0, "x"), 3: (1.0, "y")})
    assert one == {1: (-1.0, "sink"), 2: (-1.0, "sofa"), 3: (1.0, "y")}
    alone = vote_objects(told, {"sink": 3.0, "sofa": -2.0}, CFG)
    beside = vote_objects(told, {"sink": 3.0, "sofa": -2.0}, CFG, {1: (-9.0, ""), 2: (9.0, "")})
    assert isinstance(alone, Vote)
    assert alone.frontiers == (1,)
    assert isinstance(beside, Vote)
    assert beside.frontiers == (2,)
