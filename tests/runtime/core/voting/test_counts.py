"""Counts made evidence: what is likelier where, and names that were never counted."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.types import Brief, FrontierBrief, NearbyObject
from runtime.core.voting.counts import Count, CountTable, object_nats, room_nats

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
    level = (31 / 32 + 6 / 12) / 2
    assert rates["kitchen"] == pytest.approx(level), "the mean of both sets"
    assert rates["study"] == pytest.approx(level), "as often as in kitchens, where both are known"
    assert rates["bathroom"] == pytest.approx(1 / 32 * level / (31 / 32))
    assert TABLE.in_room("guitar") == {}


def test_what_one_set_has_none_of_is_not_counted_there() -> None:
    assert set(TABLE.in_room("desk")) == {"kitchen", "study"}
    assert TABLE.near("desk")["mug"] > 1, "although the public rooms have mugs and no desks"


def test_likelier_near_what_has_it_near() -> None:
    lifts = CountTable.of([HOMES]).near("mug")
    assert lifts["desk"] == pytest.approx((8 + 5 * 0.4) / 15 / 0.4)
    assert lifts["desk"] > 1 > lifts["mug"]


def test_evidence_is_for_what_is_near_and_for_the_room() -> None:
    told = Brief("mug", 0, frontiers("desk", "towel"))
    near, around = object_nats(told, TABLE.near("mug")), room_nats(told, TABLE.beyond("mug"))
    assert near[1][0] > 0 > near[2][0]
    assert near[1][1] == "desk"
    assert around[1][0] > 0 > around[2][0]
    assert around[1][1] == "kitchen"
    assert object_nats(told, {}) == {}
    assert room_nats(told, {}) == {}


def test_a_frontier_may_lie_in_several_rooms() -> None:
    def told(kitchen: float) -> float:
        rooms = (("kitchen", kitchen), ("bathroom", 1.0 - kitchen))
        brief = Brief("mug", 0, (FrontierBrief(1, 1.0, (), rooms),))
        return room_nats(brief, TABLE.beyond("mug"))[1][0]

    assert told(1.0) > told(0.5) > told(0.0)
    nowhere = Brief("mug", 0, (FrontierBrief(1, 1.0, (), (("garage", 1.0),)),))
    assert room_nats(nowhere, TABLE.beyond("mug")) == {}


def test_a_hallway_is_what_its_doors_lead_to() -> None:
    rooms = dict.fromkeys(("kitchen", "bathroom", "hallway"), 98)
    count = Count(
        rooms=rooms,
        holding={"mug": {"kitchen": 97, "bathroom": 0, "hallway": 0}},
        things={"mug": 97},
        beside={"mug": {}},
        doors={"hallway": {"kitchen": 3, "bathroom": 1}, "bathroom": {"hallway": 1}},
    )
    table = CountTable.of([count])
    beyond, rate = table.beyond("mug"), table.in_room("mug")
    mean = sum(rate.values()) / 3
    led_to = 0.75 * rate["kitchen"] + 0.25 * rate["bathroom"]
    assert beyond["hallway"] == pytest.approx((0.2 * rate["hallway"] + 0.8 * led_to) / mean)
    assert beyond["bathroom"] == pytest.approx(rate["bathroom"] / mean), "both have next to none"
    assert beyond["kitchen"] == pytest.approx(rate["kitchen"] / mean), "whose doors nobody counted"
    assert table.beyond("guitar") == {}


def test_a_name_alike_stands_in() -> None:
    known = TABLE.standing_in("cup", {"mug": 0.9, "towel": 0.1, "desk": 0.1})
    assert known.in_room("cup") == pytest.approx(TABLE.in_room("mug"))
    assert known.near("cup") == pytest.approx(TABLE.near("mug"))
    assert known.near("mug")["cup"] == pytest.approx(TABLE.near("mug")["mug"])
    assert TABLE.in_room("cup") == {}, "the table that was asked is as it was"


def test_it_is_believed_the_less_the_stranger_it_is() -> None:
    def lift(cosine: float) -> float:
        known = TABLE.standing_in("cup", {"mug": cosine, "towel": 0.0})
        return known.beyond("cup")["kitchen"]

    assert lift(0.7) > lift(0.6) > lift(0.5) > 1
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
def test_lifts_are_finite_and_lifts_average_out(
    near: dict[str, int], rooms: dict[str, int]
) -> None:
    count = Count(
        rooms=dict.fromkeys("abc", 20),
        holding={"mug": rooms},
        things={**dict.fromkeys("abc", 20), "mug": 20},
        beside={name: {"mug": near.get(name, 0)} for name in "abc"} | {"mug": {}},
        doors={},
    )
    table = CountTable.of([count])
    assert all(0 < lift < math.inf for lift in table.beyond("mug").values())
    lifts = table.near("mug")
    assert not lifts or sum(lifts.values()) / len(lifts) == pytest.approx(1.0)
