"""Right, or not at all."""

import math
from dataclasses import replace

import numpy as np
import pytest
from floor_plan import CORRIDOR, OTHER_ROOMS, ROOMS, TWINS, mapped

from runtime.core.geometry import placed, seen_from, wrap_angle
from runtime.core.mapping.relocate import (
    ANYWHERE,
    SAID,
    SAID_WITHIN,
    Relief,
    Relocation,
    believed,
    knowable,
    match,
    refuted,
)
from runtime.core.types import Pose

WHOLE = (0.0, 0.0, 9.0, 7.0)
LEFT = (0.0, 0.0, 4.5, 7.0)
FIRST = Pose(2.0, 2.0, 0.3)
KNOWN = Relief(mapped(ROOMS, WHOLE, FIRST))


def off(found: Relocation, truly: Pose, first: Pose = FIRST) -> tuple[float, float]:
    """How far a match is from where the robot truly is in the home."""
    true = seen_from(first, truly)
    apart = math.hypot(found.at.x_m - true.x_m, found.at.y_m - true.y_m)
    return apart, abs(wrap_angle(found.at.yaw_rad - true.yaw_rad))


@pytest.mark.parametrize("start", [Pose(3.0, 4.2, -2.0), Pose(1.0, 3.6, 1.3), Pose(2.4, 1.5, 3.0)])
def test_a_room_is_known_again_from_wherever_the_robot_began(start: Pose):
    seen = mapped(ROOMS, LEFT, start, np.random.default_rng(1))
    here = Pose(0.4, 0.2, 0.5)
    found = match(Relief(seen), here, KNOWN)
    assert found is not None
    apart_m, turned = off(found, placed(start, here))
    assert apart_m < 0.1
    assert turned < math.radians(2)
    assert believed(found, ANYWHERE)
    assert found.seen > 0.9


def test_another_home_is_not_taken_for_it():
    start = Pose(2.0, 2.5, 0.8)
    for part in ((0.0, 0.0, 7.0, 4.1), (0.0, 0.0, 7.0, 8.5)):
        found = match(Relief(mapped(OTHER_ROOMS, part, start)), Pose(0, 0, 0), KNOWN)
        assert found is None or not believed(found, ANYWHERE)


def test_of_two_rooms_that_are_alike_neither_is_it():
    known = Relief(mapped(TWINS, (0.0, 0.0, 9.0, 5.0), Pose(2.0, 2.0, 0.0)))
    start = Pose(6.5, 2.5, 1.0)  # in the second
    found = match(Relief(mapped(TWINS, (4.5, 0.0, 9.0, 5.0), start)), Pose(0, 0, 0), known)
    assert found is not None
    assert found.rival > 0.9
    assert not believed(found, ANYWHERE)
    told = match(
        Relief(mapped(TWINS, (4.5, 0.0, 9.0, 5.0), start)), Pose(0, 0, 0), known,
        (seen_from(Pose(2.0, 2.0, 0.0), Pose(6.9, 2.3, 1.2)), *SAID_WITHIN),
    )  # fmt: skip
    assert told is not None
    assert believed(told, SAID)
    assert off(told, start, Pose(2.0, 2.0, 0.0))[0] < 0.1


def test_along_a_corridor_all_places_are_as_good():
    known = Relief(mapped(CORRIDOR, (0.0, 0.0, 30.0, 2.0), Pose(15.0, 1.0, 0.0)))
    seen = Relief(mapped(CORRIDOR, (9.0, 0.0, 19.0, 2.0), Pose(14.0, 1.0, 0.1)))
    found = match(seen, Pose(0, 0, 0), known)
    assert found is not None
    assert found.agree > 0.9
    assert not believed(found, ANYWHERE)


def test_where_nothing_is_seen_or_known_nothing_matches():
    seen = mapped(ROOMS, LEFT, FIRST)
    bare = replace(seen, occupied=seen.occupied & False, free=~seen.unknown)
    assert match(Relief(bare), Pose(0, 0, 0), KNOWN) is None
    assert match(Relief(seen), Pose(0, 0, 0), Relief(bare)) is None
    unseen = replace(seen, free=seen.free & False)
    assert match(Relief(unseen), Pose(0, 0, 0), KNOWN) is None


def test_a_map_of_next_to_nothing_can_never_be_known_again():
    assert knowable(KNOWN)
    assert not knowable(Relief(mapped(ROOMS, (1.0, 3.0, 4.0, 4.6), FIRST)))


def test_a_place_that_it_is_not_at_is_refuted():
    start = Pose(2.0, 6.0, 0.4)
    seen = Relief(mapped(OTHER_ROOMS, (0.0, 4.1, 7.0, 8.5), start))
    said = Pose(0.0, 0.0, 0.0)
    found = match(seen, Pose(0, 0, 0), KNOWN, (said, *SAID_WITHIN))
    assert found is None or not believed(found, SAID)
    assert refuted(None)
    good = Relocation(said, 0.9, 0.9, 9.0, 0.5)
    assert not refuted(good)
    assert not refuted(good._replace(agree=0.1))  # most of it was never seen
    assert refuted(good._replace(agree=0.5, seen=0.5))


@pytest.mark.parametrize(
    "lacks", [{"agree": 0.9}, {"seen": 0.69}, {"metres": 7.9}, {"rival": 0.81}]
)
def test_a_match_must_be_good_in_all(lacks: dict[str, float]):
    good = Relocation(FIRST, 0.92, 0.7, 8.0, 0.8)
    assert believed(good, ANYWHERE)
    assert not believed(good._replace(**lacks), ANYWHERE)
