"""What rooms have, counted on plans whose rooms are known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hil_sim.expert_bench.plan_counts import LAPLACE, LEAST_M2, PlanCounts, count_plans
from hil_sim.ground_truth.labels import LABELLED
from hil_sim.scenes.format import ROOM_TYPES, Scene
from tests.hil_sim.expert_bench.test_drive import scene

BEDROOM, KITCHEN = (ROOM_TYPES.index(name) for name in ("bedroom", "kitchen"))
BED, TOILET, MUG = (LABELLED.index(name) for name in ("bed", "toilet", "mug"))


def with_kitchen() -> Scene:
    """The home of three bedrooms, of which the last is a kitchen."""
    home = scene()
    return replace(home, rooms=(*home.rooms[:2], replace(home.rooms[2], type="kitchen")))


def test_rooms_with_a_thing_are_counted() -> None:
    counts = PlanCounts.of([scene(), with_kitchen()])
    # 5 bedrooms, of which 4 have a bed and 1 the toilet; 1 kitchen, which has the other
    assert counts.share[BEDROOM, BED] == pytest.approx((4 + LAPLACE) / (5 + 2 * LAPLACE))
    assert counts.share[BEDROOM, TOILET] == pytest.approx((1 + LAPLACE) / (5 + 2 * LAPLACE))
    assert counts.share[KITCHEN, TOILET] == pytest.approx((1 + LAPLACE) / (1 + 2 * LAPLACE))


def test_what_is_next_door_is_nearby() -> None:
    counts = PlanCounts.of([with_kitchen()])
    # two bedrooms with a bed in a row, a kitchen with a toilet behind the second
    bedrooms, kitchens = 2 + 2 * LAPLACE, 1 + 2 * LAPLACE
    assert counts.nearby[BEDROOM, BED] == pytest.approx((2 + LAPLACE) / bedrooms)
    assert counts.nearby[BEDROOM, TOILET] == pytest.approx((1 + LAPLACE) / bedrooms)
    assert counts.nearby[KITCHEN, BED] == pytest.approx((1 + LAPLACE) / kitchens)
    assert counts.nearby[KITCHEN, MUG] == pytest.approx(LAPLACE / kitchens)


def test_floor_is_what_a_body_can_stand_on() -> None:
    counts = PlanCounts.of([with_kitchen()])
    # 4 m x 4 m, less the body's radius beside walls and things, which are half a metre wide
    assert 10.0 < counts.floor_m2[KITCHEN] < (4 - 2 * 0.18) ** 2
    assert counts.floor_m2[ROOM_TYPES.index("study")] == 0.0


def test_two_rooms_have_it_more_likely_than_one_and_half_a_room_less() -> None:
    share = np.full((len(ROOM_TYPES), len(LABELLED)), 0.5)
    counts = PlanCounts(share, share, np.full(len(ROOM_TYPES), 8.0))
    room_m2 = np.zeros((3, len(ROOM_TYPES)))
    room_m2[0, BEDROOM] = room_m2[1, [BEDROOM, KITCHEN]] = 8.0
    room_m2[2, BEDROOM] = 4.0
    by_floor = counts.by_floor(room_m2)[:, BED]
    assert by_floor == pytest.approx(np.log([0.5, 0.75, 1 - math.sqrt(0.5)]))
    by_rooms = counts.by_rooms(room_m2)[:, BED]
    assert by_rooms == pytest.approx(np.log([0.5, 0.75, 0.5]))


def test_a_sliver_of_a_room_does_not_lie_there() -> None:
    counts = PlanCounts.of([with_kitchen()])
    room_m2 = np.zeros((2, len(ROOM_TYPES)))
    room_m2[:, KITCHEN] = LEAST_M2 / 2, LEAST_M2
    nats = counts.by_rooms(room_m2)[:, TOILET]
    assert nats[0] < -10 < nats[1]


def test_plans_of_train_homes_say_where_beds_are() -> None:
    counts = count_plans(3)
    assert counts.share[BEDROOM, BED] > 0.8 > 0.3 > counts.share[KITCHEN, BED]
