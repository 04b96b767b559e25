"""When the target is believed, and what becomes of doubts."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from open_floor import at, bed

from runtime.core.objects.instances import Instance, reject
from runtime.core.objects.verdict import (
    REJECTION_LOG_ODDS,
    UNSEEN_LOOKS,
    Reached,
    Verdict,
    confirmed,
    from_two_sides,
    settle,
    verdict,
)
from runtime.core.types import Pose


def come(thing: Instance, reached: Reached, pose: Pose) -> Verdict:
    """The robot has come so far with it: what follows, booked."""
    outcome = verdict(thing, "bed", reached)
    settle(thing, "bed", outcome, pose)
    return outcome


def wants_other_side(thing: Instance) -> bool:
    return verdict(thing, "bed", Reached.ON_THE_WAY) is Verdict.OTHER_SIDE


def rejections(thing: Instance) -> int:
    return thing.evidence["bed"].rejections


@given(
    st.floats(-math.pi, math.pi), st.floats(0.8, 3.0), st.floats(-0.34, 0.34), st.floats(1, 1.39)
)
def test_views_from_nearly_one_place_are_one_look(
    bearing: float, range_m: float, turned: float, nearer: float
):
    thing = bed(at(bearing, range_m), at(bearing + turned, range_m / nearer))
    assert not confirmed(thing, "bed")


@given(st.floats(-math.pi, math.pi), st.floats(0.8, 3.0), st.floats(0.36, math.pi))
def test_another_direction_is_a_second_look(bearing: float, range_m: float, turned: float):
    for sign in (1, -1):
        assert confirmed(bed(at(bearing, range_m), at(bearing + sign * turned, range_m)), "bed")


@given(st.floats(-math.pi, math.pi), st.floats(1.0, 3.0), st.floats(1.41, 4.0))
def test_so_is_a_much_nearer_one(bearing: float, range_m: float, nearer: float):
    assert from_two_sides(bed(at(bearing, range_m), at(bearing, range_m / nearer)), "bed")


def test_one_view_is_never_two():
    assert not confirmed(bed(at(0.0, 1.0)), "bed")
    assert not confirmed(bed(), "bed")


def test_a_doubt_is_settled_by_the_second_look_at_the_latest():
    seen = at(0, 1)
    thing = bed(seen, at(0.1, 1.0), odds=2.0)  # enough evidence, from one side
    assert come(thing, Reached.FACED, seen) is not Verdict.FOUND
    assert wants_other_side(thing)
    come(thing, Reached.NO_OTHER_SIDE, seen)  # there is no other side to stand on
    assert not rejections(thing)
    assert come(thing, Reached.FACED, seen) is Verdict.FOUND


def test_what_is_rather_something_else_is_never_found():
    thing = bed(at(0, 1), at(2, 1), odds=4.0)
    thing.evidence_of("sofa").odds = 4.5
    outcomes = {come(thing, Reached.FACED, at(0, 1)) for _ in range(4)}
    assert not confirmed(thing, "bed")
    assert Verdict.FOUND not in outcomes
    assert rejections(thing)


def test_too_little_evidence_after_two_looks_is_a_rejection():
    thing = bed(at(0, 1), at(0.1, 1.0), odds=1.2)
    assert come(thing, Reached.FACED, at(0, 1)) is not Verdict.FOUND
    assert come(thing, Reached.FACED, at(0.5, 1)) is not Verdict.FOUND
    assert rejections(thing) == 1
    assert thing.odds_of("bed") == REJECTION_LOG_ODDS
    assert not wants_other_side(thing)


def test_what_nothing_speaks_for_gets_no_second_look():
    thing = bed(at(0, 1), at(0.1, 1.0), odds=0.0)
    assert come(thing, Reached.FACED, at(0, 1)) is not Verdict.FOUND
    assert rejections(thing) == 1


def test_what_was_only_seen_from_afar_is_not_stopped_at():
    thing = bed(at(0, 4), at(1.0, 2.5), range_m=2.5)
    assert confirmed(thing, "bed")
    assert come(thing, Reached.FACED, at(0, 1)) is not Verdict.FOUND
    assert wants_other_side(thing)  # where it may be seen from near
    assert come(thing, Reached.FACED, at(0, 1)) is not Verdict.FOUND
    assert rejections(thing) == 1


@given(st.floats(-3, 8), st.lists(st.booleans(), min_size=3, max_size=3))
def test_three_looks_always_end_it(odds: float, second_side: list[bool]):
    thing = bed(at(0, 1), odds=odds)
    for other in second_side:
        if come(thing, Reached.FACED, at(0, 1)) is Verdict.FOUND or rejections(thing):
            return
        if other:
            thing.evidence["bed"].backing.append(at(1.0, 1.0))
    raise AssertionError("neither believed nor rejected")


def test_what_is_hidden_where_it_is_faced_is_looked_for_from_some_more_places():
    thing = bed(at(0, 1), at(1.0, 1.0))
    for n in range(UNSEEN_LOOKS):
        assert come(thing, Reached.UNSEEN, at(0, 1 - n / 10)) is Verdict.STEP_BACK
        assert not wants_other_side(thing)
    assert [pose.x_m for pose in thing.unseen] == pytest.approx([3.0, 2.9])
    assert come(thing, Reached.UNSEEN, at(0, 1)) is Verdict.FOUND  # it is nowhere to be seen from
    reject(thing, "bed", REJECTION_LOG_ODDS)
    assert not thing.unseen


def test_what_is_hidden_and_not_believed_is_rejected_as_ever():
    thing = bed(at(0, 1), odds=0.0)
    assert come(thing, Reached.UNSEEN, at(0, 1)) is Verdict.REJECT
