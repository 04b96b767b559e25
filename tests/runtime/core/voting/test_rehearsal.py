"""What is prepared for a map to come is used only when experts would be told the same."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sighted import sight

from runtime.core.types import Absence, Ballot, Brief, FrontierBrief, Missing, NearbyObject, Sight
from runtime.core.voting.rehearsal import (
    CONFIDENCE_SLACK,
    DISTANCE_SLACK_M,
    complete,
    differs,
    expected,
    worthwhile,
)

VIEW = np.array([1.0, 0.0], np.float32)


@st.composite
def briefs(draw) -> Brief:
    ids = sorted(draw(st.sets(st.integers(1, 9), min_size=1, max_size=5)))
    names, metres = st.sampled_from(["sink", "bed", "lamp"]), st.floats(0.0, 3.5)
    things = st.builds(NearbyObject, names, st.floats(0.6, 1.0), metres)
    return Brief(
        "toilet",
        draw(st.integers(0, 10**9)),
        tuple(
            FrontierBrief(
                i,
                draw(st.floats(0.1, 20.0)),
                tuple(draw(st.lists(things, max_size=4))),
                draw(st.sampled_from([(), (("bathroom", 0.7), ("kitchen", 0.3))])),
                VIEW,
                doorway=draw(st.booleans()),
            )
            for i in ids
        ),
    )


def with_first(brief: Brief, **changes) -> Brief:
    return replace(brief, frontiers=(replace(brief.frontiers[0], **changes), *brief.frontiers[1:]))


@given(briefs(), st.integers(0, 10**9), st.floats(0.1, 50.0), st.randoms())
def test_time_the_robots_place_and_the_order_of_objects_do_not_matter(brief, stamp, far, rng):
    def later(f: FrontierBrief) -> FrontierBrief:
        return replace(f, distance_m=far, objects=tuple(rng.sample(f.objects, len(f.objects))))

    after = Brief(brief.goal, stamp, tuple(later(f) for f in brief.frontiers))
    assert differs(brief, after) == ""


@given(briefs(), st.data())
def test_the_explored_frontier_is_all_that_may_be_missing(brief: Brief, data):
    aim = data.draw(st.sampled_from([f.id for f in brief.frontiers]))
    prepared = expected(brief, aim)
    assert [f for f in brief.frontiers if f.id != aim] == list(prepared.frontiers)
    assert differs(prepared, expected(brief, aim)) == ""
    assert differs(prepared, brief) == f"frontier {aim} is new"
    assert differs(brief, prepared) == f"frontier {aim} is gone"


@given(briefs(), st.floats(-1.0, 1.0), st.floats(-0.3, 0.3))
def test_an_object_may_be_off_by_the_tolerances(brief: Brief, metres: float, sure: float):
    one = NearbyObject("toaster", 0.8, 2.0)
    prepared = with_first(brief, objects=(one,))
    moved = NearbyObject("toaster", 0.8 + sure, 2.0 + metres)
    now = with_first(brief, objects=(moved,))
    within = (
        abs(moved.distance_m - one.distance_m) <= DISTANCE_SLACK_M
        and abs(moved.confidence - one.confidence) <= CONFIDENCE_SLACK
    )
    assert (differs(prepared, now) == "") is within


@given(briefs())
def test_other_evidence_is_named(brief: Brief):
    id = brief.frontiers[0].id
    bare = with_first(brief, objects=(), rooms=(("bathroom", 1.0),), doorway=False)
    told = {
        "objects": with_first(bare, objects=(NearbyObject("sink", 0.9, 1.0),)),
        "rooms": with_first(bare, rooms=(("bathroom", 0.8), ("kitchen", 0.2))),
        "doorway": with_first(bare, doorway=True),
        "unknown area": with_first(bare, unknown_m2=bare.frontiers[0].unknown_m2 + 1.0),
        "view": with_first(bare, view=np.array([0.0, 1.0], np.float32)),
    }
    for what, now in told.items():
        assert differs(bare, now) == f"other {what} at frontier {id}"
    assert differs(bare, with_first(bare, rooms=())) == f"other rooms at frontier {id}"
    assert differs(bare, with_first(bare, view=VIEW[:0])) == f"other view at frontier {id}"
    assert differs(bare, replace(bare, goal="bed")) == "another goal"
    small = with_first(bare, rooms=(("bathroom", 0.95), ("kitchen", 0.05)))
    assert differs(bare, small) == ""


@pytest.mark.parametrize(
    ("ballot", "slow", "whole"),
    [
        (Ballot(latency_s={"o2f": 0.01}), False, True),
        (Ballot(latency_s={"o2f": 0.01, "sle": 1.5}), True, True),
        (Ballot(missing=(Missing("sle", Absence.LATE),)), True, False),
        (Ballot(missing=(Missing("sle", Absence.BUSY),)), True, False),
        (Ballot(missing=(Missing("sle", Absence.ERROR, "it fell over"),)), True, False),
        (Ballot(missing=(Missing("sle", Absence.NO_EVIDENCE),)), False, True),
        (Ballot(missing=(Missing("o2f", Absence.NO_PREFERENCE),)), False, True),
        (Ballot(), False, True),
    ],
)
def test_slow_votes_are_worth_preparing_and_only_whole_ballots_stand(ballot, slow, whole):
    assert worthwhile(ballot) is slow
    assert complete(ballot) is whole


def test_where_a_frontier_stands_in_the_view_may_be_off_a_little():
    def told(seen: Sight | None) -> Brief:
        return Brief("toilet", 0, (FrontierBrief(1, 1.0, (), (), VIEW, sight=seen),))

    before = told(sight(0.5, 2.0))
    assert differs(before, told(sight(0.55, 2.4))) == ""
    assert differs(before, told(sight(0.65, 2.0))) == "other view at frontier 1"
    assert differs(before, told(sight(0.5, 2.6))) == "other view at frontier 1"
    assert differs(before, told(None)) == "other view at frontier 1"
    assert differs(told(None), told(None)) == ""
