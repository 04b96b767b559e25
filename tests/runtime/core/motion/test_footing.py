"""What the robot may stand on: floor that was seen, and what it has to take on trust."""

from dataclasses import replace

import numpy as np
import pytest
from pit import CAMERA, DEPTH_M, HEIGHT_M, LEVEL, RADIUS_M, TILTED, Pit

from runtime.core.mapping.grid import NavigationMap, integrate
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
