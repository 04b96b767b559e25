"""What a goal may be bound to: read within bounds, in the map frame."""

import math
from typing import Any

import pytest

from runtime.core.destination import Destination
from runtime.core.mapping.zones import wrong_corners
from runtime.core.types import Pose
from runtime.errors import ConfigError
from runtime.service.bounds import (
    ABOUT_M,
    ANYWHERE,
    GoalBounds,
    names_place,
    place_words,
    read_bounds,
    read_zone,
    tells_where,
)

SQUARE = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]]
ROOMS = ("kitchen", "living room")
TABLE = Pose(2.0, 1.0, 0.5)


def bound(origin_xy: tuple[float, float] = (0.0, 0.0), **body: Any) -> GoalBounds:
    return read_bounds(body, ROOMS, origin_xy, {"kitchen table": TABLE}.get)


def test_a_goal_that_says_nothing_is_bound_to_nothing():
    assert bound(goal="mug") == ANYWHERE


def test_an_area_is_a_polygon_a_type_of_room_or_round_a_place():
    area = bound(area={"polygon": SQUARE}).area
    assert area is not None
    assert (area.area, area.corners_xy) == (True, tuple(map(tuple, SQUARE)))
    assert bound(area={"room": "Living Room"}) == GoalBounds(room="living room")
    area = bound(area={"place": "kitchen table"}).area
    assert area is not None
    assert wrong_corners(area.corners_xy) == ""
    assert area.outside_m((2.0, 1.0)) == pytest.approx(-ABOUT_M, abs=0.1)


def test_a_place_has_a_name_or_is_told():
    assert bound(go_to="kitchen table").to == Destination("kitchen table", (2.0, 1.0), 0.5)
    assert bound(go_to={"x_m": 1, "y_m": -2.04}).to == Destination("(1.0, -2.0)", (1.0, -2.04))
    to = bound(go_to={"x_m": 1, "y_m": 2, "yaw_rad": 1.5}).to
    assert to is not None
    assert to.yaw_rad == 1.5


def test_where_a_robot_goes_afterwards_has_a_name():
    there = Destination("kitchen table", (2.0, 1.0), 0.5)
    assert bound(afterwards={"place": "kitchen table"}) == GoalBounds(then_to=there)
    assert bound(afterwards="return") == ANYWHERE
    with pytest.raises(ConfigError, match="goal request: afterwards: place 'dock' is not known"):
        bound(afterwards={"place": "dock"})


def test_what_is_told_in_odometrys_frame_is_on_the_map():
    far = (5e5, 4e6)
    to = bound(far, go_to={"x_m": 500_001, "y_m": 4_000_002}).to
    assert to is not None
    assert to.xy == (1.0, 2.0)
    moved = [[x + far[0], y + far[1]] for x, y in SQUARE]
    area = bound(far, area={"polygon": moved}).area
    assert area is not None
    assert area.corners_xy == tuple(map(tuple, SQUARE))
    assert bound(far, go_to="kitchen table").to == bound(go_to="kitchen table").to


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ({"area": "kitchen"}, "area: must have one of polygon, room, place"),
        ({"area": {}}, "area: must have one of polygon, room, place"),
        ({"area": {"room": "kitchen", "place": "x"}}, "area: must have one of"),
        ({"area": {"rooms": "kitchen"}}, "area: unknown; did you mean room?"),
        ({"area": {"polygon": SQUARE[:2]}}, "area: polygon: has 2 corners"),
        ({"area": {"polygon": {}}}, "area: polygon: must be a list of corners"),
        ({"area": {"room": 5}}, "area: room: must be a name"),
        ({"area": {"room": "kitchn"}}, "area: room: 'kitchn': unknown; did you mean kitchen?"),
        ({"area": {"place": "sofa"}}, "area: place 'sofa' is not known: name it first"),
        ({"go_to": "sofa"}, "go_to: place 'sofa' is not known: name it first (rfnav/places)"),
        ({"go_to": ""}, "go_to: place: must be a name"),
        ({"go_to": [1, 2]}, 'go_to: must be the name of a place, or {"x_m", "y_m", "yaw_rad"}'),
        ({"go_to": {"x_m": 1}}, "go_to: y_m: must be a number"),
        ({"go_to": {"x_m": True, "y_m": 1}}, "go_to: x_m: must be a number"),
        ({"go_to": {"x_m": math.nan, "y_m": 1}}, "go_to: x_m: is nan, must be -1000 to 1000"),
        ({"go_to": {"x_m": 10**400, "y_m": 1}}, "go_to: x_m: is 1000"),
        ({"go_to": {"x_m": 1001, "y_m": 1}}, "go_to: x_m: is 1001, must be"),
        ({"go_to": {"x_m": 1, "y_m": 1, "yaw_rad": 90}}, "go_to: yaw_rad: is 90, must be -7 to 7"),
        ({"go_to": {"x_m": 1, "y_m": 1, "z_m": 1}}, "go_to: unknown; did you mean"),
    ],
)
def test_what_cannot_be_meant_is_refused_in_a_line(body: dict[str, Any], says: str):
    with pytest.raises(ConfigError) as refusal:
        bound(**body)
    assert str(refusal.value).startswith(f"goal request: {says}")
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 200


def test_without_types_of_rooms_none_can_be_meant():
    with pytest.raises(ConfigError, match="tells no types of rooms: give a polygon"):
        read_bounds({"area": {"room": "kitchen"}}, (), (0.0, 0.0), lambda name: None)


def test_a_place_is_called_something_before_it_is_known():
    assert place_words("kitchen table") == "go to kitchen table"
    assert place_words({"x_m": 1}) == "go to a place"
    assert len(place_words("a" * 500)) == 60


def test_a_polygon_may_be_closed():
    assert read_zone("a", [*SQUARE, SQUARE[0]]) == read_zone("a", SQUARE)


def test_a_name_outlives_an_odometry_and_metres_do_not():
    metres = {"go_to": {"x_m": 1.0, "y_m": 2.0}}, {"area": {"polygon": SQUARE}}
    names = {"go_to": "dock"}, {"area": {"room": "kitchen"}}, {"area": {"place": "dock"}}, {}
    assert [tells_where(body) for body in metres] == [True, True]
    assert not any(map(tells_where, (*names, {"area": ["polygon"]})))
    then = {"afterwards": {"place": "dock"}}
    assert [names_place(binds) for binds in (*names, *metres, then)] == [
        True, False, True, False, False, False, True,
    ]  # fmt: skip
