"""A home with a hole in its floor, in PyBullet: what is seen of it, who falls, what cliff sensors
tell, and openings that come and go."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from hil_sim.scenes.format import Hole, Room, Scene, Wall
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.simulation.body import Body, opening_ahead
from hil_sim.simulation.camera import CameraModel
from hil_sim.simulation.drive import drive, ordered
from hil_sim.simulation.flooring import CLIFF_Z_M, CLIFFS
from hil_sim.simulation.noise import NONE
from hil_sim.simulation.protocol import HM3D, DifferentialDrive
from hil_sim.simulation.robot import Robot, act
from hil_sim.simulation.scene_physics import ScenePhysics
from runtime.core.types import Action, Pose, Twist

SMALL = CameraModel(160, 120)
HOLE = Hole(((3.0, 1.0), (4.0, 1.0), (4.0, 3.0), (3.0, 3.0)), 1.2)


def scene(holes: tuple[Hole, ...] = (HOLE,)) -> Scene:
    corners = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)]
    walls = tuple(Wall(a, b, 0.1) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    room = Room("room", "study", tuple(corners))
    return Scene("pit", walls, (), (room,), (), holes=holes)


@pytest.fixture(scope="module", params=["auto", "tiny"])
def world(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ScenePhysics]:
    assets = Assets(tmp_path_factory.mktemp("cache"))
    with ScenePhysics(scene(), assets, request.param) as made:
        yield made


def below(world: ScenePhysics, pose: Pose) -> float:
    """How far under the floor the lowest point in view lies, m."""
    depth = world.render(pose.x_m, pose.y_m, pose.yaw_rad, SMALL).depth_m
    rows = np.arange(SMALL.height) + 0.5 - SMALL.height / 2
    height = 0.88 - depth * (rows / SMALL.focal_px)[:, None]
    return float(-height[depth > 0].min())


def test_the_camera_looks_into_a_hole(world: ScenePhysics):
    """Over its near edge, 2 m ahead, to its far side, 3 m ahead."""
    assert below(world, Pose(1.0, 2.0, 0.0)) == pytest.approx(0.44, abs=0.05)
    assert below(world, Pose(1.0, 2.0, math.pi / 2)) == pytest.approx(0.0, abs=0.03)


def test_a_step_over_an_edge_ends_there(world: ScenePhysics):
    start = Robot(Pose(2.8, 2.0, 0.0))
    fell = act(start, Action.MOVE_FORWARD, world, HM3D)
    assert fell.fell
    assert fell.over
    assert 2.85 < fell.pose.x_m < 3.0  # a foot is over the edge
    beside = act(Robot(Pose(2.7, 2.0, math.pi / 2)), Action.MOVE_FORWARD, world, HM3D)
    assert not beside.over


def test_a_base_that_rolls_over_an_edge_stays_where_it_fell(world: ScenePhysics):
    base, rng = DifferentialDrive(), np.random.default_rng(0)
    robot = ordered(Robot(Pose(2.0, 2.0, 0.0)), Twist(0.5, 0.0), base)
    for _ in range(60):
        robot = drive(ordered(robot, Twist(0.5, 0.0), base), 0.1, world, base, NONE, rng)
    assert robot.fell
    assert robot.twist == Twist()
    assert robot.pose.x_m < 3.0
    assert robot.collisions == 0


def test_cliff_sensors_tell_which_side_of_the_rim_is_over_a_hole(world: ScenePhysics):
    whole = world.flooring.cliffs(Pose(1.0, 2.0, 0.0))
    assert whole == pytest.approx(dict.fromkeys(CLIFFS, CLIFF_Z_M))
    ahead = world.flooring.cliffs(Pose(2.88, 2.0, 0.0))
    assert math.isinf(ahead["cliff/front_left"])
    assert math.isinf(ahead["cliff/front_right"])
    left = world.flooring.cliffs(Pose(2.88, 2.0, -math.pi / 2))
    assert [topic for topic, range_m in left.items() if math.isinf(range_m)] == ["cliff/left"]


def test_an_opening_comes_and_goes(world: ScenePhysics):
    here = Pose(1.0, 0.8, 0.0)
    opening = Body("opening", 2.6, 0.45, 0.0, (0.6, 0.6, 0.8))
    assert not world.falls(2.6, 0.45)
    plain = world.render(here.x_m, here.y_m, here.yaw_rad, SMALL).depth_m
    world.populate((opening,))
    assert world.falls(2.6, 0.45)
    opened = world.render(here.x_m, here.y_m, here.yaw_rad, SMALL).depth_m
    assert (opened - plain).max() > 0.3
    world.populate(())
    assert not world.falls(2.6, 0.45)
    again = world.render(here.x_m, here.y_m, here.yaw_rad, SMALL).depth_m
    assert np.array_equal(again, plain)


def test_an_opening_lies_ahead_where_there_is_room(world: ScenePhysics):
    bare = Pose(1.0, 3.3, math.pi)  # a wall is ahead, and to the right
    opening = opening_ahead(bare, world)
    assert opening is None or math.hypot(opening.x_m - 1.0, opening.y_m - 3.3) > 2.0
    found = opening_ahead(Pose(0.6, 2.0, 0.0), world)
    assert found is not None
    assert found.x_m == pytest.approx(2.8)


def test_a_scene_without_holes_is_drawn_as_one_quad(tmp_path):
    with ScenePhysics(scene(()), Assets(tmp_path), "tiny") as bare:
        assert not bare.falls(3.5, 2.0)
        assert below(bare, Pose(1.0, 2.0, 0.0)) == pytest.approx(0.0, abs=0.03)
