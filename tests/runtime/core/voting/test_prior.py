"""Votes as evidence: how far each can go alone, and what they come to together."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.belief import Ahead, Taken
from runtime.core.types import Absence, Ballot, Missing, Vote
from runtime.core.voting import prior, search_order
from runtime.core.voting.consensus import (
    ConsensusConfig,
    agreed,
    decides,
    elect,
    settled,
    successor,
)
from runtime.core.voting.explain import in_words
from runtime.core.voting.information_gain import DISCOUNT_PER_M
from runtime.core.voting.prior import (
    LONE,
    NAMED,
    NEWEST,
    PULL,
    WEIGHTS,
    counted,
    heard,
    pooled,
    remembering,
)

NATS = st.dictionaries(st.integers(1, 4), st.floats(-9.0, 9.0), min_size=1)
PRIOR = ConsensusConfig(mode="prior", fallback="ahead")
ONE_STEP = ConsensusConfig(mode="prior", fallback="geometry")


def star(masses=(1.0, 1.0, 1.0, 1.0), far_m=(2.0, 2.0, 2.0, 2.0), **more) -> Ahead:
    """Frontiers 1, 2, … each its own way off, and no way between two but by the robot."""
    n, first_m = len(masses), np.array(far_m[: len(masses)])
    between_m = (first_m[:, None] + first_m) * (1 - np.eye(n))
    ids, at = tuple(range(1, n + 1)), ((0.0, 0.0),) * n
    return Ahead(ids, at, tuple(masses), np.array(masses), first_m, between_m, **more)


def vote(expert: str, nats: dict[int, float]) -> Vote:
    best = max(nats, key=lambda i: nats[i])
    return Vote(expert, (best,), (), "so it is", nats=tuple(sorted(nats.items())))


def ballot(**nats: dict[int, float]) -> Ballot:
    return Ballot(tuple(vote(expert, each) for expert, each in sorted(nats.items())))


class _Reachable:
    def __init__(self, id: int, distance_m: float) -> None:
        self.id, self.distance_m = id, distance_m


def elected(votes: Ballot, ahead: Ahead, cfg: ConsensusConfig = PRIOR, order=()):
    frontiers = [_Reachable(i, float(m)) for i, m in zip(ahead.ids, ahead.first_m, strict=True)]
    return elect(votes, frontiers, cfg, 7, "due", order or ahead.ids, ahead)


def apart(masses=(1.0, 1.0, 1.0, 1.0), far_m=(2.0, 2.0, 2.0, 2.0), **more) -> Ahead:
    """As `star`, without the ways between them."""
    return replace(star(masses, far_m, **more), between_m=np.zeros((0, 0)))


@given(NATS)
def test_one_expert_alone_is_heard_in_part_and_within_bounds(nats: dict[int, float]):
    ahead = star()
    found = pooled(heard(ballot(o2f=nats), ahead), ahead.ids)
    assert max(abs(x) for x in found.values()) <= LONE * PULL + 1e-9


@given(NATS, NATS)
def test_an_expert_moves_no_frontier_farther_than_another_backs_it(a, b):
    """However wild it is: beyond what the other says as well, it adds the lone part alone."""
    ahead = star()
    known = heard(ballot(o2f=a), ahead)["o2f"]
    both = pooled(heard(ballot(o2f=a, r2f=b), ahead), ahead.ids)
    for id in ahead.ids:
        most = 2 * abs(known[id]) + LONE * PULL
        assert abs(both[id]) <= most + 1e-9


def test_what_two_say_counts_in_full():
    ahead, said = star(), {1: 0.45, 2: -0.15, 3: -0.15, 4: -0.15}
    both = pooled(heard(ballot(o2f=said, sle=said), ahead), ahead.ids)
    assert both == pytest.approx({i: 2 * x for i, x in said.items()})
    rooms = pooled(heard(ballot(o2f=said, r2f=said), ahead), ahead.ids)
    more = WEIGHTS["r2f"] - 1.0  # which nobody backs
    assert rooms == pytest.approx({i: (2 + LONE * more) * x for i, x in said.items()})


def test_experts_that_contradict_each_other_cancel_out():
    said = {1: 1.0, 2: -1.0}
    ahead = star(masses=(1.0, 1.0))
    found = pooled(heard(ballot(o2f=said, r2f={1: -1.0, 2: 1.0}), ahead), ahead.ids)
    assert found == {1: 0.0, 2: 0.0}


def test_nobody_who_is_wild_alone_takes_the_robot_to_the_far_end():
    """Frontier 2 is four times as far: one expert's word is not worth that, two experts' is."""
    ahead = star(masses=(1.0, 1.0), far_m=(2.0, 8.0))
    wild = {1: -50.0, 2: 50.0}
    assert elected(ballot(o2f=wild), ahead).frontier == 1
    assert elected(ballot(o2f=wild, r2f=wild), ahead).frontier == 2


def test_what_is_said_at_random_fades_and_what_is_known_stays():
    rng, steady = np.random.default_rng(1), {1: 1.0, 2: -1.0}
    known, drawn, last = {}, {}, []
    for _ in range(40):
        drawn_now = dict(zip((1, 2), rng.normal(size=2), strict=True))
        drawn = heard(ballot(o2f=drawn_now), star(masses=(1.0, 1.0), before=drawn))
        known = heard(ballot(o2f=steady), star(masses=(1.0, 1.0), before=known))
        last.append(drawn["o2f"][1])
    assert known["o2f"] == pytest.approx(steady)
    alone = np.std(rng.normal(size=(4000, 2)) @ [0.5, -0.5])
    assert np.std(last) < 0.8 * alone


def test_who_says_the_contrary_of_what_it_said_is_not_believed():
    ahead = star(masses=(1.0, 1.0), before={"o2f": {1: 1.0, 2: -1.0}, "r2f": {1: 1.0, 2: -1.0}})
    votes = ballot(o2f={1: -1.0, 2: 1.0}, r2f={1: 0.5, 2: -0.5})
    said = heard(votes, ahead)
    counts = counted(votes, ahead, said)
    assert counts["o2f"] == {1: 0.0, 2: 0.0}
    assert counts["r2f"] == pytest.approx(said["r2f"])
    first = ballot(o2f={1: 1.0, 2: -1.0})
    alone = heard(first, star(masses=(1.0, 1.0)))
    assert counted(first, star(masses=(1.0, 1.0)), alone) == alone


def test_who_is_late_goes_on_counting_less_and_less():
    ahead = star(masses=(1.0, 1.0), before={"o2f": {1: 1.0, 2: -1.0}})
    late = Ballot(missing=(Missing("o2f", Absence.LATE),))
    left = 1 - NEWEST
    assert heard(late, ahead)["o2f"] == pytest.approx({1: left, 2: -left})


def test_what_a_decision_is_not_made_on_is_remembered_while_it_is_there():
    """Frontier 3 is not asked about in the second decision, and is in the third."""
    first = elected(ballot(o2f={1: -1.0, 2: 0.0, 3: 1.0}), star(masses=(1.0, 1.0, 1.0)))
    assert first.said["o2f"][3] == 1.0
    two = star(masses=(1.0, 1.0), before=first.said)
    second = elected(ballot(o2f={1: 0.5, 2: -0.5}), two)
    assert 3 not in second.said["o2f"]
    stands = remembering(second, first, (1, 2, 3, 4))
    assert stands.said == {"o2f": second.said["o2f"] | {3: 1.0}}
    assert replace(stands, said=second.said) == second
    third = elected(Ballot(), star(masses=(1.0, 1.0, 1.0), before=stands.said))
    assert third.said["o2f"][3] == pytest.approx(1 - NEWEST)


def test_what_was_said_of_a_frontier_that_is_gone_is_forgotten():
    first = elected(ballot(o2f={1: -1.0, 2: 1.0}, sle={1: 0.5, 2: -0.5}), star(masses=(1.0, 1.0)))
    nothing = elect(Ballot(), [], PRIOR)
    assert remembering(nothing, first, (2,)).said == {"o2f": {2: 1.0}, "sle": {2: -0.5}}
    assert remembering(first, None, (1,)).said == {"o2f": {1: -1.0}, "sle": {1: 0.5}}


def test_an_expert_without_a_preference_leans_all_the_same():
    ahead = star(masses=(1.0, 1.0))
    leaning = Missing("r2f", Absence.NO_PREFERENCE, nats=((1, -0.2), (2, 0.2)))
    told = elected(Ballot(missing=(leaning,)), ahead)
    assert told.frontier == 2
    assert told.without == (("r2f", 1),)


@pytest.mark.parametrize("level", [-5.0, 0.0, 5.0])
def test_what_an_expert_does_not_know_of_a_frontier_is_no_evidence(level: float):
    """Scores of views may lie anywhere: who has none for a frontier neither speaks for it nor
    against."""
    told = heard(ballot(sle={1: level + 0.2, 2: level - 0.2}), star())
    assert told["sle"] == pytest.approx({1: 0.2, 2: -0.2, 3: 0.0, 4: 0.0})


def test_a_vote_without_numbers_is_worth_so_much_where_it_names():
    named = Vote("cloud", (2,), (), "there")
    said = heard(Ballot((named,)), star(masses=(1.0, 1.0)))
    assert said == {"cloud": {1: -NAMED / 2, 2: NAMED / 2}}


def test_the_decision_tells_the_order_the_belief_and_what_each_changed():
    ahead = star(far_m=(1.0, 2.0, 4.0, 5.0))
    said = {1: -1.0, 2: 0.0, 3: 1.0, 4: 0.0}
    told = elected(ballot(o2f=said, r2f=said), ahead)
    assert (told.rule, told.frontier, told.closest) == ("prior", 3, 1)
    assert told.order[0] == 3
    assert sorted(told.order) == [1, 2, 3, 4]
    assert dict(told.without) == {"o2f": 1, "r2f": 1}
    assert told.belief is not None
    assert told.belief.places[0].id == 3
    total = sum(place.p for place in told.belief.places) + told.belief.elsewhere
    assert total == pytest.approx(1.0)
    gone = [_Reachable(i, 1.0) for i in told.order[1:]]
    assert successor(told, gone) == told.order[1]


def test_without_a_word_the_order_alone_decides():
    told = elected(Ballot(), star(far_m=(3.0, 2.0, 1.0, 4.0)))
    assert (told.rule, told.chosen, told.frontier) == ("ahead", (), 3)


def test_without_an_order_the_best_for_the_way_there_is_elected_by_area_evidence_and_way():
    """Twice the area, and what two say of it, against 3 m more of way."""
    near, away = (1.0, 4.0)
    ahead = apart(masses=(1.0, 2.0), far_m=(near, away))
    short = DISCOUNT_PER_M * (away - near) - math.log(2.0)  # nats that the farther one lacks
    for said, best in ((short - 0.05, 1), (short + 0.05, 2)):
        nats = {1: -said / 4, 2: said / 4}  # of two, which count in full: said in all
        told = elected(ballot(o2f=nats, sle=nats), ahead, ONE_STEP)
        assert (told.rule, told.frontier, told.order) == ("prior", best, ())


def test_without_an_order_it_is_told_who_was_heard_and_what_each_changed():
    said = {1: -1.0, 2: 1.0}
    ahead = apart(masses=(1.0, 1.0), far_m=(1.0, 5.0))
    told = elected(ballot(o2f=said, r2f=said), ahead, ONE_STEP)
    assert dict(told.without) == {"o2f": 1, "r2f": 1}
    assert told.belief is not None
    assert told.belief.places[0].id == 2
    assert in_words(told) == (
        "frontier 2, the most to find for the way by the unknown and the word of o2f and r2f "
        "(o2f: so it is; r2f: so it is); the closest is 1; without o2f: 1; without r2f: 1"
    )
    silent = elected(Ballot(), ahead, ONE_STEP)
    assert (silent.rule, silent.frontier, silent.chosen) == ("geometry", 1, ())


@given(
    st.lists(st.floats(0.1, 9.0), min_size=4, max_size=4), st.floats(0.0, 8.0), NATS, st.booleans()
)
def test_no_evidence_costs_more_than_the_detour(far_m, most: float, nats, planned: bool):
    ahead = (star if planned else apart)(far_m=far_m)
    bounded = replace(PRIOR if planned else ONE_STEP, detour_m=most)
    way_m = dict(zip(ahead.ids, far_m, strict=True))
    order = search_order.ordered(ahead, {})
    told = elected(ballot(o2f=nats, r2f=nats), ahead, bounded, order)
    least = way_m[order[0]] + most
    assert way_m[told.frontier] <= least
    assert all(way_m[id] <= least for _, id in told.without)
    free = elected(ballot(o2f=nats, r2f=nats), ahead, replace(bounded, detour_m=math.inf), order)
    if way_m[free.frontier] <= least:
        assert (told.frontier, told.order) == (free.frontier, free.order)
    assert sorted(told.order) == sorted(free.order)


def test_of_what_is_near_enough_evidence_takes_the_best():
    """The fallback is 1, 2 m off; 4 has the most evidence, and 3 the most of those within 3 m."""
    ahead = star(masses=(4.0, 1.0, 1.0, 3.0), far_m=(2.0, 3.0, 3.0, 5.0))
    said = {1: -0.8, 2: -0.8, 3: 0.7, 4: 0.9}
    votes = ballot(o2f=said, r2f=said)
    assert elected(votes, ahead).order == (4, 3, 1, 2)
    told = elected(votes, ahead, replace(PRIOR, detour_m=1.0))
    assert (told.order, told.rule, told.chosen) == ((3, 4, 1, 2), "prior", (3,))
    assert elected(votes, ahead, replace(PRIOR, detour_m=0.5)).frontier == 1


def test_what_enough_experts_are_against_is_not_elected():
    ahead, said = star(far_m=(1.0, 2.0, 4.0, 5.0)), {1: -1.0, 2: 0.0, 3: 1.0, 4: 0.0}
    o2f, r2f = ballot(o2f=said, r2f=said).votes
    votes = Ballot((o2f, replace(r2f, against=(3,))))
    assert elected(votes, ahead).frontier == 3
    told = elected(votes, ahead, replace(PRIOR, veto=1))
    assert told.frontier not in (None, 3)
    assert sorted(told.order) == [1, 2, 3, 4]
    assert dict(told.without)["r2f"] == dict(elected(votes, ahead).without)["r2f"]
    everything = Ballot((replace(o2f, against=(1, 2, 3, 4)), r2f))
    assert elected(everything, ahead, replace(PRIOR, veto=1)).frontier == 3  # means nothing


def test_where_all_that_are_ordered_are_voted_against_the_nearest_of_the_others_is_elected():
    ahead = star(masses=(1.0, 1.0))
    frontiers = [_Reachable(i, far_m) for i, far_m in ((1, 2.0), (2, 2.0), (3, 7.0), (4, 5.0))]
    votes = Ballot((replace(vote("o2f", {1: 1.0, 2: 0.0}), against=(1, 2)),))
    told = elect(votes, frontiers, replace(PRIOR, veto=1), order=ahead.ids, ahead=ahead)
    assert (told.frontier, told.order) == (4, (4, 1, 2))


@pytest.mark.parametrize("cfg", [PRIOR, ONE_STEP])
def test_with_one_frontier_to_choose_from_it_says_what_sets_would(cfg: ConsensusConfig):
    """Nothing was decided by evidence, though some was heard before."""
    alone = (star if cfg.plans else apart)(masses=(1.0,), before={"o2f": {1: 1.0, 2: -1.0}})
    leans = Missing("r2f", Absence.NO_PREFERENCE, nats=((1, 0.3),))
    named = [Vote(expert, (1,), (), "there") for expert in ("o2f", "sle")]
    for votes in ((), named[:1], named):
        asked = Ballot(tuple(votes), (leans,))
        told = elected(asked, alone, cfg)
        sets = elected(asked, alone, replace(cfg, mode="strict"))
        assert in_words(told) == in_words(sets)
        assert told == sets
    assert elected(Ballot((), (leans,)), alone, cfg).rule == cfg.fallback


def test_with_one_frontier_near_enough_it_says_what_sets_would():
    ahead, said = star(far_m=(2.0, 6.0, 6.0, 6.0)), {1: -1.0, 2: 1.0, 3: 0.0, 4: 0.0}
    votes, cfg = ballot(o2f=said, r2f=said), replace(PRIOR, detour_m=1.0)
    told = elected(votes, ahead, cfg)
    assert (told.frontier, told.rule, told.chosen) == (1, "ahead", ())
    assert "what o2f and r2f agree on is too far away" in in_words(told)


def test_without_ways_to_plan_over_the_fallback_decides():
    frontiers = [_Reachable(1, 1.0), _Reachable(2, 2.0)]
    assert elect(ballot(o2f={2: 5.0, 1: 0.0}), frontiers, PRIOR, order=(2, 1)).frontier == 2


def test_everyone_is_waited_for_where_evidence_counts():
    frontiers = [_Reachable(1, 1.0), _Reachable(2, 2.0)]
    assert not settled((), ("o2f",), frontiers, PRIOR)
    assert settled((), (), frontiers, PRIOR)


def test_whoever_leans_any_way_has_a_say_and_two_agree_where_they_name_one_frontier():
    leaning = Missing("r2f", Absence.NO_PREFERENCE, nats=((1, 0.2), (2, -0.2)))
    one, two, late = {1: 1.0, 2: 0.0}, {1: 0.0, 2: 1.0}, Missing("o2f", Absence.LATE)
    for votes, decided, of_one_mind in (
        (ballot(o2f=one, r2f=one), True, True),
        (ballot(o2f=one, r2f=two), True, False),
        (ballot(o2f=one), True, False),
        (Ballot(missing=(leaning,)), True, False),
        (Ballot(missing=(late,)), False, False),
    ):
        assert (decides(votes, PRIOR), agreed(votes, PRIOR)) == (decided, of_one_mind)
    o2f, r2f = ballot(o2f=one, r2f=one).votes
    opposed = Ballot((o2f, replace(r2f, against=(1,))))
    assert not agreed(opposed, replace(PRIOR, veto=1))


def test_rank_gain_takes_of_the_chosen_what_the_fallback_puts_first():
    frontiers = [_Reachable(1, 1.0), _Reachable(2, 2.0), _Reachable(3, 3.0)]
    votes = Ballot((Vote("a", (1, 3), (), ""), Vote("b", (1, 3), (), "")))
    for rank, best in (("nearest", 1), ("gain", 3), ("farthest", 3)):
        cfg = ConsensusConfig(mode="strict", rank=rank)
        assert elect(votes, frontiers, cfg, order=(2, 3, 1)).frontier == best


def test_a_planned_order_begins_with_what_sets_elected():
    frontiers = [_Reachable(1, 1.0), _Reachable(2, 2.0), _Reachable(3, 3.0)]
    votes = Ballot((Vote("a", (1,), (), ""), Vote("b", (1,), (), "")))
    cfg = ConsensusConfig(mode="strict", fallback="ahead")
    told = elect(votes, frontiers, cfg, order=(2, 3, 1), ahead=star(masses=(1.0, 1.0, 1.0)))
    assert (told.rule, told.frontier, told.order) == ("all", 1, (1, 2, 3))
    assert "; then 2, 3;" in in_words(told) + ";"


def test_belief_follows_evidence():
    ahead = star(masses=(1.0, 3.0))
    before = prior.belief(ahead, {})
    after = prior.belief(ahead, {"o2f": {1: 2.0, 2: -2.0}, "r2f": {1: 2.0, 2: -2.0}})
    assert [p.id for p in before.places] == [2, 1]
    assert [p.id for p in after.places] == [1, 2]


def test_belief_names_who_says_something_of_each_place():
    said = {"o2f": {1: 0.5, 2: 0.01}, "r2f": {1: 0.0, 2: 0.5}, "sle": {1: 0.0, 2: -0.4}}
    told = prior.belief(star(masses=(1.0, 1.0)), said, {"o2f": {1: 1.0, 2: 0.5}, "r2f": {2: 1.0}})
    why = {place.id: place.why for place in told.places}
    assert why[1] == "1.0 m² unknown behind it, +0.3 nats by objects near by"
    assert why[2].endswith(" nats by kind of room and look of the view (said earlier)")


def test_a_decision_has_what_its_frontier_was_taken_for():
    frontiers = [_Reachable(1, 1.0), _Reachable(2, 2.0), _Reachable(3, 3.0)]
    ahead = replace(star(masses=(1.0, 1.0, 9.0)), before={"sle": {1: 0.0, 2: 0.0, 3: 0.5}})
    vote = Vote("o2f", (3,), (), "", nats=((1, 0.0), (2, 0.0), (3, 0.9)))
    quiet = Missing("r2f", Absence.NO_EVIDENCE)
    told = elect(Ballot((vote,), (quiet,)), frontiers, ConsensusConfig(), ahead=ahead)
    took = told.taken
    assert took is not None
    assert told.belief is not None
    assert (told.frontier, took.way_m, took.unknown_m2) == (3, 3.0, 9.0)
    assert [(one.expert, one.earlier) for one in took.said] == [("o2f", False), ("sle", True)]
    assert took.said[0].nats == pytest.approx(0.6)
    assert took.said[1].nats == pytest.approx(0.6 * 0.5)
    share = next(place.p for place in told.belief.places if place.id == 3)
    assert (took.share, took.place, took.planned) == (share, told.order.index(3) + 1, 3)


def test_without_areas_a_frontier_is_taken_for_its_way_alone():
    cfg = ConsensusConfig(mode="strict", fallback="closest")
    told = elect(Ballot(), [_Reachable(1, 1.0), _Reachable(2, 2.0)], cfg)
    assert told.taken == Taken(1.0)
    assert elect(Ballot(), [], cfg).taken is None
