"""Information gain counts the unknown that can be walked to; rooms end at doorways."""

import math

import numpy as np
import pytest

from runtime.core.distances.terrain import survey
from runtime.core.mapping.grid import NavigationMap
from runtime.core.objects.semantic_map import SemanticMap
from runtime.core.types import Frontier, Pose
from runtime.core.voting.brief import compose, worthwhile
from runtime.core.voting.information_gain import by_worth, masses, room_of

AREA = {1: 4.0, 2: 4.0}
POSE = Pose(0.0, 0.0, 0.0)
RADIUS_M = 0.18


def two_rooms(door_m: float = 0.8) -> NavigationMap:
    """Known free: x -1.9..1.9 by y -1.4..1.4 and, beyond a wall at x = 2, x 2.1..4 by the same.
    A door in the wall; nothing else is known, but walls all round except at the far right."""
    grid = NavigationMap.around(POSE, RADIUS_M)
    grid.grow(np.array([4.0, 0.0]), 6.0)
    rows, cols = np.indices(grid.frame.shape)
    xy = grid.frame.centres(np.stack([rows.ravel(), cols.ravel()], 1).astype(np.int32))
    x, y = xy[:, 0].reshape(grid.frame.shape), xy[:, 1].reshape(grid.frame.shape)
    inside = (x > -1.9) & (x < 4.0) & (np.abs(y) < 1.4)
    around = (x > -2.1) & (x < 4.0) & (np.abs(y) < 1.6) & ~inside
    wall = inside & (np.abs(x - 2.0) < 0.06) & (np.abs(y) > door_m / 2)
    paint(grid, inside & ~wall, around | wall)
    return grid


def paint(grid: NavigationMap, free: np.ndarray, occupied: np.ndarray) -> None:
    grid.evidence[free], grid.evidence[occupied] = -10, 10
    grid.changed()


def edge(id: int, x: float, grid: NavigationMap, distance_m: float) -> Frontier:
    ys = np.arange(-1.3, 1.3, 0.05)
    cells = grid.frame.cells(np.stack([np.full_like(ys, x), ys], 1))
    centres = grid.frame.centres(cells)
    return Frontier(id, centres, (float(centres[26, 0]), float(centres[26, 1])), distance_m)


def ranked(frontiers, area, current, grid_terrain):
    mass = masses(frontiers, area, current, grid_terrain, POSE)
    return tuple(f.id for f in by_worth(frontiers, mass))


def test_a_room_ends_at_its_doorway():
    grid = two_rooms()
    terrain = survey(grid, POSE, RADIUS_M)
    room = room_of(terrain, POSE)
    here, there = terrain.frame.cell(-1.0, 0.5), terrain.frame.cell(3.3, 0.5)
    assert room[here]
    assert not room[there]


def test_a_wide_opening_joins_what_it_opens_into():
    grid = two_rooms(door_m=2.8)
    terrain = survey(grid, POSE, RADIUS_M)
    assert room_of(terrain, POSE)[terrain.frame.cell(3.3, 0.5)]


def behind(frontier: Frontier, grid: NavigationMap, depth_m: float) -> float:
    semantic = SemanticMap.empty((), (), grid.frame)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("runtime.core.voting.brief.UNKNOWN_DEPTH_M", depth_m)
        told = compose("toilet", 0, grid, semantic, [frontier], {})
    return told.frontiers[0].unknown_m2


def test_gain_is_the_unknown_behind_the_frontier_and_no_more():
    grid = two_rooms()
    open_end, enclosed = edge(1, 3.98, grid, 4.0), edge(2, -1.5, grid, 1.5)
    assert 2.6 < behind(open_end, grid, 1.0) < 5.5  # 2.6 m wide, 1 m deep, and round the corners
    assert behind(enclosed, grid, 1.0) == 0.0
    told = compose(
        "toilet",
        0,
        grid,
        SemanticMap.empty((), (), grid.frame),
        [open_end, enclosed],
        {},
    )
    assert [f.id for f in worthwhile(told, 0.1).frontiers] == [1]
    assert worthwhile(told, 1e6) == told


def test_the_nearer_of_equals_wins_and_the_one_under_way_is_kept():
    grid = two_rooms()
    terrain = survey(grid, POSE, RADIUS_M)
    near, far = edge(1, 3.98, grid, 4.0), edge(2, 3.98, grid, 4.5)
    assert ranked([far, near], AREA, None, terrain) == (1, 2)
    assert ranked([far, near], AREA, 2, terrain) == (2, 1)
    gone = Frontier(3, near.cells_xy, near.goal_xy, math.inf)
    assert ranked([gone, near], {1: 4.0}, None, terrain) == (1,)
