"""Counts made evidence: what is likelier where, and names that were never counted."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.types import Brief, FrontierBrief, NearbyObject, Vote
from runtime.core.voting.counts import Count, CountTable, doors_together, together
from runtime.core.voting.likelihood_experts import ExpertConfig, vote_objects, vote_rooms

PUBLIC = Count(
    rooms={"kitchen": 30, "bathroom": 30},
    holding={"mug": {"kitchen": 30, "bathroom": 0}, "towel": {"kitchen": 3, "bathroom": 27}},
    things={"mug": 40, "towel": 60},
    beside={"mug": {"mug": 10}, "towel": {"towel": 50, "mug": 3}},
    doors={},
)
HOMES = Count(
    rooms={"kitchen": 10, "study": 10},
    holding={"mug": {"kitchen": 5, "study": 5}, "desk": {"kitchen": 0, "study": 10}},
    things={"mug": 10, "desk": 10},
    beside={"mug": {"desk": 5}, "desk": {"mug": 8}},
    doors={"kitchen": {"study": 3, "kitchen": 1}, "study": {"kitchen": 3}},
)
TABLE = CountTable.of([PUBLIC, HOMES])


def frontiers(*near: str) -> tuple[FrontierBrief, ...]:
    return tuple(
        FrontierBrief(n, float(n), (NearbyObject(name, 0.9, 0.5),), ((room, 1.0),), unknown_m2=2.0)
        for n, (name, room) in enumerate(zip(near, ("kitchen", "bathroom"), strict=True), 1)
    )


def test_a_room_counts_for_what_stands_in_it() -> None:
    rates = TABLE.in_room("mug")
    assert rates["kitchen"] == pytest.approx((31 / 32 + 6 / 12) / 2), "the mean of both sets"
    assert rates["bathroom"] == pytest.approx(1 / 32)
    assert rates["study"] == pytest.approx(6 / 12)
    assert TABLE.in_room("guitar") == {}


def test_what_one_set_has_none_of_is_not_counted_there() -> None:
    assert set(TABLE.in_room("desk")) == {"kitchen", "study"}
    assert TABLE.near("desk")["mug"] > 1, "although the public rooms have mugs and no desks"


def test_likelier_near_what_has_it_near() -> None:
    lifts = CountTable.of([HOMES]).near("mug")
    assert lifts["desk"] == pytest.approx((8 + 5 * 0.4) / 15 / 0.4)
    assert lifts["desk"] > 1 > lifts["mug"]


def test_counts_vote_as_words_do() -> None:
    told = Brief("mug", 0, frontiers("desk", "towel"))
    by_object = vote_objects(told, TABLE.by_object("mug"), ExpertConfig())
    by_room = vote_rooms(told, TABLE.by_room("mug"), ExpertConfig(), TABLE.spoken_doors)
    assert isinstance(by_object, Vote)
    assert by_object.frontiers == (1,)
    assert isinstance(by_room, Vote)
    assert by_room.frontiers == (1,)


def test_rooms_are_called_as_the_experts_call_them() -> None:
    assert set(TABLE.by_room("desk")) == {"kitchen", "home office"}
    assert TABLE.spoken_doors == {
        "kitchen": {"home office": 0.75, "kitchen": 0.25},
        "home office": {"kitchen": 1.0},
    }


def test_a_name_alike_stands_in() -> None:
    known = TABLE.standing_in("cup", {"mug": 0.9, "towel": 0.1, "desk": 0.1})
    assert known.in_room("cup") == pytest.approx(TABLE.in_room("mug"))
    assert known.near("cup") == pytest.approx(TABLE.near("mug"))
    assert known.near("mug")["cup"] == pytest.approx(TABLE.near("mug")["mug"])
    assert TABLE.in_room("cup") == {}, "the table that was asked is as it was"


def test_it_is_believed_the_less_the_stranger_it_is() -> None:
    def nats(cosine: float) -> float:
        known = TABLE.standing_in("cup", {"mug": cosine, "towel": 0.0})
        return known.by_room("cup")["kitchen"]

    assert nats(0.9) > nats(0.7) > nats(0.5) > 0
    assert TABLE.standing_in("cup", {"mug": 0.3}) is TABLE
    assert TABLE.standing_in("cup", {}) is TABLE


def test_names_that_the_table_has_not_do_not_stand_in() -> None:
    assert TABLE.standing_in("cup", {"beaker": 0.99}) is TABLE


def test_as_if_never_counted() -> None:
    blind = TABLE.without("mug")
    assert blind.in_room("mug") == {}
    assert blind.near("mug") == {}
    assert "mug" not in blind.near("desk")
    assert blind.in_room("desk") == TABLE.in_room("desk")


@given(
    st.dictionaries(st.sampled_from("abc"), st.integers(0, 20)),
    st.dictionaries(st.sampled_from("abc"), st.integers(0, 20)),
)
def test_nats_are_finite_and_lifts_average_out(near: dict[str, int], rooms: dict[str, int]) -> None:
    count = Count(
        rooms=dict.fromkeys("abc", 20),
        holding={"mug": rooms},
        things={**dict.fromkeys("abc", 20), "mug": 20},
        beside={name: {"mug": near.get(name, 0)} for name in "abc"} | {"mug": {}},
        doors={},
    )
    table = CountTable.of([count])
    assert all(math.isfinite(n) for n in table.by_room("mug").values())
    lifts = table.near("mug")
    assert not lifts or sum(lifts.values()) / len(lifts) == pytest.approx(1.0)


def test_two_kinds_of_evidence_are_averaged_where_both_have_some() -> None:
    assert together({"a": 1.0, "b": 2.0}, {"b": 4.0, "c": 5.0}) == {"a": 1.0, "b": 3.0, "c": 5.0}
    assert doors_together({"a": {"b": 1.0}}, {}) == {"a": {"b": 1.0}}
