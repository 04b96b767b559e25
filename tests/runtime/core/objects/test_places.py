"""Which instances may be meant by a place: none that is may be left out."""

import math
from dataclasses import dataclass

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from runtime.core.objects.places import InstancePlaces
from runtime.core.types import F64

WITHIN_M = 0.6


@dataclass
class Thing:
    """Something in a place."""

    id: int
    xy: tuple[float, float]
    cells_xy: F64
    z_m: float = 0.4


def things(count: int, seed: int) -> list[Thing]:
    rng = np.random.default_rng(seed)
    found = []
    for id in range(1, count + 1):
        at = rng.uniform(-3, 3, 2)
        cells = at + rng.normal(0, 0.4, (rng.integers(1, 30), 2))
        found.append(Thing(id, (float(at[0]), float(at[1])), cells))
    return found


def gap_m(one: Thing, other: Thing) -> float:
    return min(
        math.dist(one.xy, other.xy),
        float(np.hypot(*(one.cells_xy - other.xy).T).min()),
        float(np.hypot(*(other.cells_xy - one.xy).T).min()),
    )


@given(st.integers(0, 90), st.integers(0, 2**32 - 1))
def test_whatever_is_near_is_found_nearest_first_and_none_is_nearer_than_told(
    count: int, seed: int
):
    (asked, *others) = things(count + 1, seed)
    places = InstancePlaces.of({one.id: one for one in others})
    found = places.near(asked.xy, asked.cells_xy, WITHIN_M)
    gaps = {one.id: gap_m(one, asked) for one in others}
    assert {id for id, gap in gaps.items() if gap <= WITHIN_M} <= {id for _, id in found}
    assert all(least <= gaps[id] for least, id in found)
    assert found == sorted(found)


@given(st.integers(1, 90), st.floats(0, 4), st.integers(0, 2**32 - 1))
def test_what_is_in_range_is_where_it_was_put_last(count: int, range_m: float, seed: int):
    before, now = things(count, seed), things(count, seed + 1)
    places = InstancePlaces.of({one.id: one for one in before})
    places.put(now)
    ids, middles = places.within((0.5, 0.5), range_m)
    assert {one.id for one in now if math.dist(one.xy, (0.5, 0.5)) <= range_m} <= set(ids)
    assert [tuple(row) for row in middles] == [(*now[id - 1].xy, 0.4) for id in ids]
    assert len(places) == count


@given(st.integers(2, 12), st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_what_was_moved_meanwhile_is_found_where_it_is_now(asked: int, known: int, seed: int):
    every = things(asked + known, seed)
    wanted, others = every[:asked], {one.id: one for one in every[asked:]}
    places = InstancePlaces.of(others)
    now = things(asked + 2 * known, seed + 1)[asked:]  # as many again are new
    for one in now[::2]:
        others[one.id] = one
        places.put([one])
    for thing in wanted:
        found = {id: least for least, id in places.near(thing.xy, thing.cells_xy, WITHIN_M)}
        gaps = {one.id: gap_m(one, thing) for one in others.values()}
        assert {id for id, gap in gaps.items() if gap <= WITHIN_M} <= set(found)
        assert all(least <= gaps[id] for id, least in found.items())
    assert len(places) == len(others)
