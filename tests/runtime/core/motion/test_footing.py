"""What the robot may stand on: floor that was seen, and what it has to take on trust."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pit import CAMERA, DEPTH_M, HEIGHT_M, LEVEL, RADIUS_M, TILTED, Pit

from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import NavigationMap, integrate
from runtime.core.motion import footing as module
from runtime.core.motion.footing import Footing, floor_from_m, footing, no_floor
from runtime.core.types import Mount, Pose

HERE = Pose(0.0, 0.0, 0.0)


def around(pit: Pit, pose: Pose = HERE) -> tuple[NavigationMap, Footing]:
    grid = NavigationMap.around(HERE, RADIUS_M)
    pit.look(grid, HERE)
    return grid, footing(grid, pose, 3.0, (CAMERA, pit.mount))


def test_floor_that_was_seen_bears_and_so_does_what_is_before_it():
    _, ground = around(Pit(None))
    ahead = np.stack([np.linspace(0.0, 2.8, 50), np.zeros(50)], axis=1)
    assert ground.bears(ahead)
    assert not ground.bears(np.array([[3.5, 0.0]]))  # behind the wall
    assert not ground.bears(np.array([[9.0, 0.0]]))  # beyond what is told of


def test_before_a_wall_that_hides_the_floor_it_is_blind_once():
    """A level camera 0.9 m before a wall sees no floor: only round the start that is passed."""
    tight = Pit(None, low=(-0.9, -3.0), high=(3.0, 3.0))
    grid, ground = around(tight)
    behind = np.array([[-0.4, 0.0], [-0.6, 0.0]])
    assert not ground.bears(behind)
    assert ground.bears(behind, unseen=True)
    assert ground.begins_blind(np.array([[-0.2, 0.0], [-0.4, 0.0], [-0.6, 0.0]]))
    assert not ground.begins_blind(np.array([[0.2, 0.0], [0.4, 0.0], [0.6, 0.0]]))
    away = Pose(1.9, 0.0, 0.0)
    left = footing(grid, away, 3.0, (CAMERA, tight.mount))
    assert not left.blind.any()
    again = footing(grid, HERE, 3.0, (CAMERA, tight.mount))
    assert not again.bears(behind, unseen=True)


@pytest.mark.parametrize("mount", [LEVEL, TILTED])
def test_nothing_bears_where_the_floor_drops(mount):
    pit = Pit((0.6, 3.0, -1.0, 1.0, 1.5), mount=mount)
    _, ground = around(pit)
    for x in (0.8, 1.2, 1.8, 2.5):
        assert not ground.bears(np.array([[x, 0.0]]), unseen=True)
    assert ground.bears(np.array([[0.0, 0.05], [-0.05, 0.0]]))
    assert ground.bears(np.array([[-1.8, 0.0], [-2.2, 0.0]]))


def test_what_a_ray_only_passes_over_does_not_bear():
    """Swept up to a thing whose foot was not in view, away from the start."""
    tight = Pit(None, low=(-3.0, -3.0), high=(0.9, 3.0))
    grid = NavigationMap.around(replace(HERE, x_m=-2.5), RADIUS_M)
    integrate(grid, tight.observe(HERE), tight.mount, RADIUS_M, HEIGHT_M, DEPTH_M)
    ground = footing(grid, HERE, 3.0, (CAMERA, tight.mount))
    assert grid.free[grid.frame.cell(0.5, 0.0)]
    assert not ground.bears(np.array([[0.5, 0.0]]), unseen=True)


def test_where_a_camera_sees_the_floor_from_follows_its_mount():
    assert floor_from_m(CAMERA, LEVEL) == pytest.approx(1.42 + 0.05, abs=0.03)
    assert floor_from_m(CAMERA, TILTED) < 0.6
    assert floor_from_m(CAMERA, Mount(pitch_rad=-1.0)) == 2.0


def test_there_is_no_floor_in_a_drop_nor_where_it_is_in_doubt():
    pit = Pit((0.6, 3.0, -1.0, 1.0, 1.5))
    grid, _ = around(pit)
    points = np.array([[[1.0, 0.0], [1.8, 0.0]], [[-1.8, 0.0], [0.0, 0.0]]])
    assert no_floor(grid, points).tolist() == [[True, True], [False, False]]


# -- cell by cell ----------------------------------------------------------------------------------

FRAME = GridFrame(-2.0, -1.0, 0.1, 20, 40)  # the origin is cell (10, 20)
PLACE = Pose(0.05, 0.05, 0.0)


def mask(*cells: tuple[int, int], shape: tuple[int, int] = FRAME.shape) -> np.ndarray:
    made = np.zeros(shape, bool)
    for cell in cells:
        made[cell] = True
    return made


def xy(*cells: tuple[int, int]) -> np.ndarray:
    return FRAME.centres(np.array(cells, np.int32).reshape(-1, 2))


def test_all_of_the_points_have_to_be_on_it():
    ground = Footing(FRAME, mask((3, 4), (3, 5)), mask((3, 6)), mask((3, 4)))
    assert ground.bears(xy((3, 4), (3, 5)))
    assert not ground.bears(xy((3, 4), (3, 6)))
    assert ground.bears(xy((3, 4), (3, 6)), unseen=True)
    assert not ground.bears(xy((3, 4), (3, 7)), unseen=True)
    assert ground.was_seen(xy((3, 4)))
    assert not ground.was_seen(xy((3, 4), (3, 5)))
    assert Footing(FRAME, mask((3, 4), (3, 5)), mask()).was_seen(xy((3, 4), (3, 5)))


def test_what_is_off_the_grid_bears_nothing_and_its_rim_does():
    ground = Footing(FRAME, np.ones(FRAME.shape, bool), mask())
    corners = [(0, 0), (0, 39), (19, 0), (19, 39)]
    assert ground.bears(xy(*corners))
    for outside in ((-1, 0), (0, -1), (20, 0), (0, 40), (-1, -1), (20, 40)):
        assert not ground.bears(xy(outside))
        assert not ground.bears(xy((5, 5), outside))


def test_a_path_begins_blind_where_it_is_so_within_sixty_centimetres():
    blind = Footing(FRAME, mask(), mask((10, 25)))
    path = xy(*[(10, 20 + n) for n in range(10)])
    assert blind.begins_blind(path)  # half a metre on
    assert not Footing(FRAME, mask(), mask((10, 27))).begins_blind(path)
    assert not blind.begins_blind(path[:0])
    assert not Footing(FRAME, mask((10, 25)), mask()).begins_blind(path)
    aside = xy((10, 20), (14, 24), (15, 25))  # 0.57 and 0.71 m
    assert Footing(FRAME, mask(), mask((14, 24))).begins_blind(aside)
    assert not Footing(FRAME, mask(), mask((15, 25))).begins_blind(aside)


def known(**cells: list[tuple[int, int]]):
    """What `footing` asks of a map."""
    evidence = np.zeros(FRAME.shape, np.int16)
    for cell in cells.get("cleared", []):
        evidence[cell] = -1
    for cell in cells.get("met", []):
        evidence[cell] = 1
    return SimpleNamespace(
        frame=FRAME,
        free=mask(*cells.get("free", [])),
        evidence=evidence,
        driven=mask(*cells.get("driven", [])).astype(np.uint8),
        backed=mask(*cells.get("backed", [])),
        began_xy=None,
        openings=SimpleNamespace(from_xy=None),
    )


ALL = [(r, c) for r in range(20) for c in range(40)]


def told(grid, pose: Pose = PLACE, range_m: float = 10.0, lens=None):
    """Cells of the whole map that are floor, blind and seen."""
    found = footing(grid, pose, range_m, lens)
    row, col = found.frame.first_row, found.frame.first_col
    masks = found.floor, found.blind, found.seen
    return [{(r + row, c + col) for r, c in np.argwhere(cells).tolist()} for cells in masks]


def test_floor_is_free_and_was_seen_driven_over_or_lies_before_what_was_seen():
    grid = known(
        free=[(1, 1), (1, 2), (1, 3), (1, 4), (1, 5)],
        cleared=[(1, 1), (2, 1)],
        driven=[(1, 2), (2, 2)],
        backed=[(1, 3), (2, 3)],
        met=[(1, 5)],
    )
    assert told(grid) == [{(1, 1), (1, 2), (1, 3)}, set(), {(1, 1), (1, 2)}]


def test_it_is_told_of_as_far_as_is_asked_and_as_the_map_goes():
    grid = known(free=ALL, cleared=ALL)
    found = footing(grid, PLACE, 0.25, None)
    assert found.floor.shape == (7, 7)
    assert (found.frame.first_row, found.frame.first_col) == (7, 17)
    assert found.bears(xy((10, 20), (7, 17), (13, 23)))
    assert not found.bears(xy((10, 24)))
    corner = footing(grid, Pose(-1.95, -0.95, 0.0), 0.2, None)
    assert corner.floor.shape == (3, 3)
    grid.free[0, 0] = False
    assert corner.bears(xy((0, 0)))  # a copy


def test_round_where_the_map_began_what_was_never_in_view_is_blind():
    grid = known(free=ALL, cleared=[(10, 21)], backed=[(10, 22)])
    grid.began_xy = (0.05, 0.05)
    floor, blind, _ = told(grid)
    assert floor == {(10, 21), (10, 22)}
    near = {(r, c) for r, c in ALL if np.hypot(r - 10, c - 20) <= 20.0}
    assert blind == near - floor
    grid.free[10, 23] = False
    assert (10, 23) not in told(grid)[1]
    assert grid.began_xy == (0.05, 0.05)


def test_how_far_it_is_blind_is_what_the_camera_s_mount_says():
    grid = known(free=ALL)
    grid.began_xy = (0.05, 0.05)
    _, blind, _ = told(grid, lens=(CAMERA, TILTED))
    reach = floor_from_m(CAMERA, TILTED) / 0.1
    assert blind == {(r, c) for r, c in ALL if np.hypot(r - 10, c - 20) <= reach}


def test_a_robot_that_has_left_where_it_began_is_told_of_nothing_blind_any_more():
    grid = known(free=ALL)
    grid.began_xy = (-1.95, 0.05)
    assert told(grid, Pose(0.0, 0.05, 0.0))[1]
    assert told(grid, Pose(0.1, 0.05, 0.0))[1] == set()
    assert grid.began_xy is None
    assert told(grid, Pose(-1.95, 0.05, 0.0))[1] == set()


@pytest.mark.parametrize(("from_x", "believed"), [(0.05, False), (0.24, False), (0.26, True)])
def test_beside_an_opening_only_what_was_seen_is_floor(from_x: float, believed: bool):
    grid = known(free=ALL, cleared=[(10, 21)], backed=[(10, 22)])
    grid.began_xy, grid.openings.from_xy = (0.05, 0.05), (from_x, 0.05)
    floor, _, seen = told(grid)
    assert seen == {(10, 21)}
    assert floor == ({(10, 21), (10, 22)} if believed else {(10, 21)})
    grid.began_xy = None
    assert told(grid)[0] == {(10, 21), (10, 22)}


def test_where_the_floor_comes_into_view_by_hand():
    """In the lowest row of pixels that is used, 119 of 120, in the column in the middle."""
    down, ahead = (119 + 0.5 - 60.0) / 97.0, 1.0
    off = (81 + 0.5 - 80.0) / 97.0
    expected = 0.88 / down * np.hypot(ahead, off) + 0.05
    assert floor_from_m(CAMERA, LEVEL) == pytest.approx(expected, rel=1e-5)
    low = floor_from_m(CAMERA, Mount(z_m=0.44))
    assert low - 0.05 == pytest.approx((floor_from_m(CAMERA, LEVEL) - 0.05) / 2)
    assert floor_from_m(CAMERA, Mount(z_m=3.0)) == 2.0
    assert floor_from_m(CAMERA, Mount(pitch_rad=-np.arctan(down) - 0.001)) == 2.0


def test_no_floor_is_a_drop_or_doubt_where_nothing_was_seen():
    grid = SimpleNamespace(
        frame=FRAME,
        drops=np.zeros(FRAME.shape, np.uint8),
        doubtful=mask((2, 3), (2, 4), (2, 5)),
        evidence=np.zeros(FRAME.shape, np.int16),
    )
    grid.drops[2, 1], grid.drops[2, 2] = 2, 1
    grid.evidence[2, 4], grid.evidence[2, 5] = -1, 1
    cells = [(2, 0), (2, 1), (2, 2), (2, 3), (2, 4), (2, 5)]
    assert no_floor(grid, xy(*cells)).tolist() == [False, True, False, True, False, True]
    grid.drops[0, 0] = grid.drops[19, 39] = 3
    outside = no_floor(grid, xy((-5, -5), (40, 60), (10, 60)).reshape(3, 1, 2))
    assert outside.tolist() == [[True], [True], [False]]


def test_just_sixty_centimetres_on_a_path_still_begins():
    around = [(r, c) for r in (9, 10) for c in (25, 26)]
    assert Footing(FRAME, mask(), mask(*around)).begins_blind(np.array([[0.0, 0.0], [0.6, 0.0]]))


def test_a_camera_whose_lowest_ray_is_level_sees_no_floor(monkeypatch):
    level = SimpleNamespace(up=np.zeros((3, 3)), reach=np.ones((3, 3)))
    monkeypatch.setattr(module, "rays", lambda intrinsics, mount, stride: level)
    assert floor_from_m(CAMERA, LEVEL) == 2.0


def test_where_the_floor_comes_into_view_of_a_tilted_camera_by_hand():
    """The lowest ray that is used, turned down by the camera's pitch."""
    pitch = TILTED.pitch_rad
    down, off = (119 + 0.5 - 60.0) / 97.0, (81 + 0.5 - 80.0) / 97.0
    ahead = np.cos(pitch) - down * np.sin(pitch)
    below = np.sin(pitch) + down * np.cos(pitch)
    expected = TILTED.z_m / below * np.hypot(ahead, off) + 0.05
    assert floor_from_m(CAMERA, TILTED) == pytest.approx(expected, rel=1e-5)
