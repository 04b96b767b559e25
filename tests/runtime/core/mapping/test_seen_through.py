"""What has gone leaves the map within so many frames of being seen through; what stands, stays.

The table of docs/realtime.md, "What has gone", is that of `test_what_has_gone_leaves`.
"""

from dataclasses import replace

import numpy as np
import pytest
from boxes import CAMERA, HERE, MOUNT, Box, depth_of, seen, wall

from runtime.core.mapping.grid import NavigationMap, integrate
from runtime.core.mapping.seen_through import unlearn
from runtime.core.mapping.solid_depth import solid
from runtime.core.types import Intrinsics, Pose

RADIUS_M, HEIGHT_M, DEPTH_M = 0.18, 1.0, 5.0
STOOD = 6  # frames, after which evidence is all that it can be


def person(x_m: float) -> tuple[Box, ...]:
    return (Box(x_m, 0.0, (0.3, 0.4), 0.0, 1.7),)


def door(x_m: float) -> tuple[Box, ...]:
    return (Box(x_m, 0.0, (0.05, 0.9), 0.0, 2.0),)


def chair(x_m: float) -> tuple[Box, ...]:
    legs = [Box(x_m + a, b, (0.04, 0.04), 0.0, 0.44) for a in (-0.2, 0.2) for b in (-0.2, 0.2)]
    back = Box(x_m + 0.2, 0.0, (0.04, 0.45), 0.44, 0.9)
    return (Box(x_m, 0.0, (0.45, 0.45), 0.42, 0.46), *legs, back)


def fresh() -> NavigationMap:
    return NavigationMap.around(HERE, RADIUS_M)


def look(grid: NavigationMap, frames: int, *boxes: Box, noisy: bool = True) -> list[int]:
    """Look so often; how many cells before the robot are occupied after each."""
    depth_m, before = depth_of(*boxes), grid.frame.cells(np.array([[0.3, -0.7], [4.6, 0.7]]))
    (top, left), (bottom, right) = before.tolist()
    left_over = []
    for n in range(frames):
        obs = seen(solid(seen(depth_m, n if noisy else None).depth_m))
        integrate(grid, obs, MOUNT, RADIUS_M, HEIGHT_M, DEPTH_M)
        left_over.append(int(grid.occupied[top:bottom, left:right].sum()))
    return left_over


@pytest.mark.parametrize(
    ("thing", "behind", "frames"),
    [
        (person(1.0), wall(4.8), 9),
        (person(1.5), wall(4.8), 9),
        (person(2.5), wall(4.8), 5),
        (person(4.0), wall(4.8), 7),
        (person(2.5), wall(9.0), 5),
        (person(4.0), wall(9.0), 7),
        (person(1.0), wall(9.0), 9),
        (person(1.5), wall(4.8, glass=True), 9),
        (person(4.0), wall(4.8, glass=True), 7),
        (door(1.5), wall(4.8), 5),
        (door(2.5), wall(9.0), 5),
        (door(4.0), wall(4.8, glass=True), 8),
        (chair(2.5), wall(4.8), 6),
        (chair(4.0), wall(4.8), 8),
    ],
)
@pytest.mark.parametrize("known", [True, False], ids=["place known", "never seen before"])
def test_what_has_gone_leaves(
    thing: tuple[Box, ...], behind: Box, frames: int, known: bool
) -> None:
    grid = fresh()
    if known:
        look(grid, 3, behind)
    assert look(grid, STOOD, behind, *thing)[-1] > 5
    assert look(grid, frames, behind)[-1] == 0


def test_it_is_floor_that_is_free_where_somebody_stood_close_by():
    grid = fresh()
    look(grid, STOOD, wall(4.0), *person(1.0))
    look(grid, 9, wall(4.0))
    assert grid.free[grid.frame.cell(0.86, 0.0)]


def test_what_the_camera_looks_over_stays():
    """From close by nothing is seen of a low box: rays pass above it."""
    grid, box = fresh(), Box(1.65, 0.0, (0.3, 0.4), 0.0, 0.2)
    look(grid, STOOD, wall(4.0), box)
    cell = grid.frame.cell(1.52, 0.0)
    assert grid.occupied[cell]
    nearer = seen(depth_of(wall(3.4), Box(1.05, 0.0, (0.3, 0.4), 0.0, 0.2)))
    obs = type(nearer)(0, nearer.rgb, nearer.depth_m, type(HERE)(0.6, 0.0, 0.0), CAMERA)
    for _ in range(30):
        integrate(grid, obs, MOUNT, RADIUS_M, HEIGHT_M, DEPTH_M)
    assert grid.occupied[cell]


def test_what_stood_on_it_was_taken_away_and_it_stays():
    grid, box = fresh(), Box(1.65, 0.0, (0.3, 0.4), 0.0, 0.45)
    look(grid, STOOD, wall(4.0), Box(1.65, 0.0, (0.3, 0.4), 0.0, 1.4))
    look(grid, 3 * STOOD, wall(4.0), box)
    assert grid.occupied[grid.frame.cell(1.52, 0.0)]


@pytest.mark.parametrize("x_m", [1.6, 2.5, 3.2])
def test_a_thin_leg_is_not_cleared_by_what_is_seen_beside_it(x_m: float):
    """Not as wide as the pixels of which evidence is made lie apart."""
    grid, leg = fresh(), Box(x_m, 0.0, (0.02, 0.012), 0.0, 0.7)
    look(grid, 40, wall(4.0), leg, noisy=False)
    assert (
        grid.occupied[grid.frame.cell(x_m - 0.01, 0.001)]
        or grid.occupied[grid.frame.cell(x_m - 0.01, -0.001)]
    )


def test_nothing_is_told_by_glass():
    """Before a pane close by no more than a strip of floor is seen over the place."""
    grid, pane = fresh(), wall(1.5, glass=True)
    stood = look(grid, STOOD, pane, *person(1.0))[-1]
    assert look(grid, 30, pane)[-1] == stood


def test_what_is_hidden_stays():
    grid = fresh()
    stood = look(grid, STOOD, wall(4.0), *person(3.0))[-1]
    screen = Box(1.5, 0.0, (0.05, 1.6), 0.0, 2.0)
    assert look(grid, 30, wall(4.0), screen)[-1] >= stood


def test_a_table_stays_though_floor_is_seen_under_it():
    grid, top = fresh(), Box(2.4, 0.0, (0.8, 1.0), 0.7, 0.73)
    before = look(grid, STOOD, wall(4.0), top)
    assert look(grid, 60, wall(4.0), top)[-1] >= 0.9 * before[-1]


@pytest.mark.parametrize("low_m", [0.55, 0.7, 0.745])
def test_a_thin_top_stays_for_a_robot_that_came_up_to_it_and_backs_away(low_m: float):
    """Whatever lies between the heights at which a cell is looked at."""
    grid, top = fresh(), Box(2.6, 0.0, (0.8, 1.0), low_m, low_m + 0.02)
    there = np.concatenate([np.linspace(0.0, 1.7, 12), np.linspace(1.7, 0.2, 20)])
    stood = []
    for n, x_m in enumerate(there.tolist()):
        boxes = wall(4.8 - x_m), replace(top, x_m=top.x_m - x_m)
        obs = seen(solid(seen(depth_of(*boxes), n).depth_m))
        obs = replace(obs, pose=Pose(x_m, 0.0, 0.0))
        integrate(grid, obs, MOUNT, RADIUS_M, HEIGHT_M, DEPTH_M)
        window = grid.frame.cells(np.array([[2.2, -0.5], [3.0, 0.5]]))
        (t, left), (b, right) = window.tolist()
        stood.append(int(grid.occupied[t:b, left:right].sum()))
    assert stood[-1] >= 0.95 * max(stood)


@pytest.mark.parametrize(
    ("pixels", "stood", "gone"), [(1, 0, True), (4, 0, False), (4, 0b111, True)]
)
def test_a_coarse_image_tells_nothing_of_flat_things_far_away(pixels: int, stood: int, gone: bool):
    """A board's edge is thinner than its pixels."""
    grid, obs = fresh(), seen(depth_of(wall(4.8)))
    k = Intrinsics(388.0 / pixels, 388.0 / pixels, 320.0 / pixels, 240.0 / pixels,
                   640 // pixels, 480 // pixels)  # fmt: skip
    coarse = replace(obs, depth_m=obs.depth_m[::pixels, ::pixels], intrinsics=k)
    cell = grid.frame.cell(2.5, 0.0)
    grid.evidence[cell], grid.stood[cell] = 20, stood
    unlearn(grid.evidence, grid.stood, grid.frame, coarse, MOUNT, DEPTH_M, 110, 2)
    assert (grid.evidence[cell] < 20) == gone
