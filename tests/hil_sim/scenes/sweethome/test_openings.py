"""Drawn doors -> openings in walls."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.scenes.format import ON_WALL_M, Polygon, Wall, on_wall
from hil_sim.scenes.sweethome.drawing import UNIT, Drawn, Opening
from hil_sim.scenes.sweethome.openings import doorway

LEFT: Polygon = ((-3, 0), (0, 0), (0, 4), (-3, 4))
RIGHT: Polygon = ((0, 0), (3, 0), (3, 4), (0, 4))
WALL = Wall((0, 0), (0, 4), 0.2)
DOOR = Drawn(
    "doorOrWindow[0]", "Door", "eTeks#door", (0.0, 2.0, 0.0), (0.9, 0.2, 2.05), math.pi / 2, UNIT,
    False, (0.0, 0.0), None, None, None, (), Opening(), None,
)  # fmt: skip


def test_a_door_between_rooms_is_a_hole_on_the_wall() -> None:
    way = doorway(DOOR, [WALL], [LEFT, RIGHT], 2.5)
    (door,) = way.doors
    assert sorted((door.start[1], door.end[1])) == pytest.approx([1.55, 2.45])
    assert on_wall(door, WALL)


def test_a_door_to_nowhere_stays_shut() -> None:
    assert doorway(DOOR, [WALL], [LEFT], 2.5).shut == "outside"


@pytest.mark.parametrize(
    "change",
    [
        {"position_m": (0.0, 2.0, 0.9)},
        {"size_m": (0.9, 0.2, 0.6)},
        {"size_m": (0.2, 0.2, 2.05)},
        {"name": "Fenêtre", "catalog_id": ""},
        {"opening": Opening(top=0.0, height=0.5)},
    ],
)
def test_what_cannot_be_driven_through_is_a_window(change: dict[str, object]) -> None:
    piece = replace(DOOR, **change)  # type: ignore[arg-type]
    assert doorway(piece, [WALL], [LEFT, RIGHT], 2.5).shut == "window"


def test_the_frame_is_left_out_of_the_hole() -> None:
    piece = replace(DOOR, opening=Opening(left=0.1, width=0.5))
    (door,) = doorway(piece, [WALL], [LEFT, RIGHT], 2.5).doors
    assert sorted((door.start[1], door.end[1])) == pytest.approx([1.64, 2.09])
    (door,) = doorway(replace(piece, mirrored=True), [WALL], [LEFT, RIGHT], 2.5).doors
    assert sorted((door.start[1], door.end[1])) == pytest.approx([1.91, 2.36])


def test_double_walls_and_joints_are_both_cut() -> None:
    double = [
        replace(WALL, start=(-0.1, 0), end=(-0.1, 4)),
        replace(WALL, start=(0.1, 0), end=(0.1, 4)),
    ]
    assert len(doorway(DOOR, double, [LEFT, RIGHT], 2.5).doors) == 2
    joined = [Wall((0, 0), (0, 2), 0.2), Wall((0, 2), (0, 4), 0.2)]
    assert len(doorway(DOOR, joined, [LEFT, RIGHT], 2.5).doors) == 2


def test_a_crossing_wall_is_not_cut() -> None:
    crossing = Wall((-3, 2), (3, 2), 0.2)
    assert len(doorway(DOOR, [WALL, crossing], [LEFT, RIGHT], 2.5).doors) == 1
    assert doorway(DOOR, [crossing], [LEFT, RIGHT], 2.5).shut == "no wall"


@given(st.floats(-0.3, 0.3), st.floats(-1, 5), st.floats(1.4, 1.75), st.floats(0.3, 3))
def test_holes_lie_on_their_walls(x: float, y: float, yaw: float, width: float) -> None:
    piece = replace(DOOR, position_m=(x, y, 0.0), yaw_rad=yaw, size_m=(width, 0.2, 2.05))
    for door in doorway(piece, [WALL], [LEFT, RIGHT], 2.5).doors:
        assert on_wall(door, WALL)
        assert math.dist(door.start, door.end) >= 0.02 - ON_WALL_M * 0
        assert min(door.start[1], door.end[1]) >= -1e-9
        assert max(door.start[1], door.end[1]) <= 4 + 1e-9
