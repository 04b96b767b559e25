"""A tiny home of builtin meshes in PyBullet: what is seen, and what stops the robot."""

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hil_sim.driving.camera_process import CameraProcess, Glance
from hil_sim.driving.link import HarnessError
from hil_sim.scenes.colours import rgb_of
from hil_sim.scenes.format import Door, Room, Scene, SceneError, SceneObject, Wall, room_at
from hil_sim.scenes.furniture.assets import Assets
from hil_sim.simulation import protocol as protocols
from hil_sim.simulation.body import Body, body_of
from hil_sim.simulation.camera import HM3D_CAMERA, CameraModel
from hil_sim.simulation.scene_physics import ScenePhysics
from hil_sim.simulation.shell import wall_pieces
from runtime.core.types import Pose

SMALL = CameraModel(160, 120)


def scene() -> Scene:
    """4 m x 3 m and 2 m x 3 m, a door between; a box in the first room, a shelf above the head."""
    outer = [(0.0, 0.0), (6.0, 0.0), (6.0, 3.0), (0.0, 3.0)]
    walls = tuple(
        Wall(a, b, 0.1, "outer") for a, b in zip(outer, outer[1:] + outer[:1], strict=True)
    )
    return Scene(
        "tiny",
        (*walls, Wall((4.0, 0.0), (4.0, 3.0), 0.1)),
        (Door((4.0, 1.0), (4.0, 2.0), 2.0),),
        (
            Room("a", "bedroom", ((0, 0), (4, 0), (4, 3), (0, 3)), "#b58a5b", "#cc4444"),
            Room("b", "kitchen", ((4, 0), (6, 0), (6, 3), (4, 3)), "#d8d4cb", "#44cc44"),
        ),
        (
            SceneObject("box", "other", "builtin:box", (2.5, 2.5, 0.0), 0.0, (0.4, 0.4, 0.4)),
            SceneObject("rug", "other", "builtin:rug", (1.5, 0.9, 0.0), 0.0, (1.0, 0.8, 0.01)),
            SceneObject("shelf", "other", "builtin:wall_shelf", (0.2, 1.5, 1.3), math.pi / 2),
        ),
    )


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ScenePhysics]:
    with ScenePhysics(scene(), Assets(tmp_path_factory.mktemp("cache")), "tiny") as made:
        yield made


def test_depth_of_a_wall_is_exact(world: ScenePhysics):
    depth = world.render(1.0, 1.5, math.pi / 2, SMALL).depth_m
    assert depth[60, 80] == pytest.approx(3.0 - 0.05 - 1.5, abs=0.01)
    assert depth[118, 80] == pytest.approx(
        0.88 * SMALL.focal_px / 58.5, abs=0.02
    )  # floor, by similar triangles


def test_depth_is_along_the_optical_axis(world: ScenePhysics):
    depth = world.render(1.0, 1.5, math.pi / 2, SMALL).depth_m
    assert np.ptp(depth[60, 20:140]) < 0.02  # a wall seen straight on is equally deep everywhere


def test_a_pitched_camera_sees_the_floor_nearer(world: ScenePhysics):
    level = world.render(1.0, 1.5, 0.0, SMALL).depth_m
    down = world.render(1.0, 1.5, 0.0, SMALL, pitch_rad=math.radians(30)).depth_m
    assert down[110, 80] < level[110, 80]


def test_through_the_door_one_sees_the_other_room(world: ScenePhysics):
    assert world.render(1.0, 1.5, 0.0, SMALL).depth_m[60, 80] == pytest.approx(4.95, abs=0.02)
    assert world.render(1.0, 0.5, 0.0, SMALL).depth_m[60, 80] == pytest.approx(2.95, abs=0.02)


def test_segmentation_names_the_object(world: ScenePhysics):
    frame = world.render(1.2, 2.5, 0.0, SMALL)
    assert frame.segmentation[108, 80] == 0
    assert set(np.unique(frame.segmentation)) <= {-1, 0, 1, 2}
    assert frame.depth_m[108, 80] == pytest.approx(2.3 - 1.2, abs=0.02)
    assert frame.segmentation[60, 80] == -1


def test_each_side_of_a_wall_has_its_rooms_colour(world: ScenePhysics):
    red = world.render(1.0, 1.5, math.pi / 2, SMALL).rgb[50, 80].astype(int)
    green = world.render(5.0, 1.5, math.pi / 2, SMALL).rgb[50, 80].astype(int)
    assert red[0] > red[1] + 30
    assert green[1] > green[0] + 30


def test_the_robot_stops_before_a_wall_and_does_not_slide(world: ScenePhysics):
    x, y, hit = world.move(1.0, 1.5, math.radians(60), 3.0)
    assert hit
    assert 3.0 - 0.05 - 0.18 - 0.04 < y <= 3.0 - 0.05 - 0.18 + 1e-6
    assert math.atan2(y - 1.5, x - 1.0) == pytest.approx(math.radians(60), abs=1e-6)


def test_furniture_stops_it_but_a_rug_and_a_high_shelf_do_not(world: ScenePhysics):
    assert world.move(1.5, 2.5, 0.0, 1.5)[2]
    assert world.move(1.5, 0.5, math.pi / 2, 0.8) == pytest.approx((1.5, 1.3, False))
    assert not world.collides(0.3, 1.5)


def test_it_passes_the_door_and_not_the_wall_beside_it(world: ScenePhysics):
    assert world.move(3.0, 1.5, 0.0, 2.0) == pytest.approx((5.0, 1.5, False))
    assert world.move(3.0, 0.6, 0.0, 2.0)[2]


def test_free_moves_end_exactly_where_they_should(world: ScenePhysics):
    x, y, hit = world.move(1.0, 1.5, 0.3, 0.25)
    assert not hit
    assert (x, y) == pytest.approx((1.0 + 0.25 * math.cos(0.3), 1.5 + 0.25 * math.sin(0.3)))


def test_a_person_and_a_closed_door_are_seen_and_in_the_way(world: ScenePhysics):
    person = Body("person", 2.2, 1.5, 0.0, (0.4, 0.4, 1.7))
    door = body_of(scene().doors[0])
    before = world.render(1.0, 1.5, 0.0, SMALL)
    try:
        world.populate((person, door))
        seen = world.render(1.0, 1.5, 0.0, SMALL)
        assert seen.depth_m[60, 80] == pytest.approx(1.0, abs=0.02)
        assert seen.segmentation[60, 80] == -1
        assert world.move(1.0, 1.5, 0.0, 2.0)[0] == pytest.approx(2.0 - 0.18, abs=0.03)
        assert world.scan(Pose(1.0, 1.5, 0.0))[180] == pytest.approx(1.05, abs=0.02)
        world.populate((door,))
        assert world.render(1.0, 1.5, 0.0, SMALL).depth_m[60, 80] == pytest.approx(3.0, abs=0.05)
        assert world.move(3.0, 1.5, 0.0, 2.0)[2]
    finally:
        world.populate(())
    assert world.move(3.0, 1.5, 0.0, 2.0) == pytest.approx((5.0, 1.5, False))
    after = world.render(1.0, 1.5, 0.0, SMALL)
    np.testing.assert_array_equal(before.depth_m, after.depth_m)


def test_a_scan_measures_the_walls_around(world: ScenePhysics):
    ranges = world.scan(Pose(1.0, 1.5, math.pi / 2))
    assert len(ranges) == 360
    assert ranges[180] == pytest.approx(1.45, abs=0.02)  # ahead, along +y
    assert ranges[270] == pytest.approx(0.95, abs=0.02)  # left, along -x
    assert ranges[90] == pytest.approx(4.95, abs=0.02)  # right, through the door
    assert ranges[0] == pytest.approx(1.45, abs=0.02)  # behind


def test_it_backs_up_as_carefully_as_it_drives(world: ScenePhysics):
    x, _, hit = world.move(1.0, 1.5, 0.0, -2.0)
    assert hit
    assert 0.05 + 0.18 <= x < 0.05 + 0.18 + 0.04


def test_a_camera_sees_from_another_process_what_the_world_shows(world: ScenePhysics):
    protocol = replace(protocols.HM3D, width=160, height=120)
    with CameraProcess(scene(), protocol, "e", 0, "tiny") as camera:
        camera.look(Glance(1, Pose(1.2, 2.5, 0.0), 0.0))
        until_s = time.monotonic() + 30
        while (sight := camera.seen()) is None:
            assert time.monotonic() < until_s
            time.sleep(0.01)
    frame = world.render(1.2, 2.5, 0.0, SMALL)
    np.testing.assert_array_equal(sight.segmentation, frame.segmentation)
    np.testing.assert_array_equal(sight.depth_m, protocol.sensed(frame.depth_m))


def test_a_camera_says_in_one_line_why_it_cannot_open():
    lamp = SceneObject("lamp", "lamp", "builtin:lampp", (1.0, 1.0, 0.0))
    home = replace(scene(), objects=(lamp,))
    with pytest.raises(HarnessError, match=r"^camera: tiny: objects\[0\] \(lamp\): unknown mesh"):
        CameraProcess(home, protocols.HM3D, "e", 0, "tiny").__enter__()


def test_obstacle_triangles_lie_where_the_furniture_stands(world: ScenePhysics):
    triangles = world.obstacle_triangles()
    inside = (triangles[..., 0] > 0.5) & (triangles[..., 0] < 3.5)
    inside &= (triangles[..., 1] > 0.5) & (triangles[..., 1] < 2.8) & (triangles[..., 2] < 1.0)
    corners = triangles[inside]
    assert corners.min(axis=0) == pytest.approx([2.3, 2.3, 0.0], abs=1e-3)
    assert corners.max(axis=0) == pytest.approx([2.7, 2.7, 0.4], abs=1e-3)  # and not the rug


def test_walls_are_split_around_doors_with_a_lintel_above():
    pieces = [p for p in wall_pieces(scene()) if abs(p.centre_m[0] - 4.0) < 1e-6]
    spans = sorted(
        (p.centre_m[1] - p.half_m[0], p.centre_m[1] + p.half_m[0], p.centre_m[2] - p.half_m[2])
        for p in pieces
        if abs(p.yaw_rad - math.pi / 2) < 1e-6
    )
    assert spans == [
        pytest.approx((-0.05, 1.0, 0.0)),
        pytest.approx((1.0, 2.0, 2.0)),
        pytest.approx((2.0, 3.05, 0.0)),
    ]


def test_rooms_by_point_and_colours_by_text():
    assert room_at(scene(), 1.0, 1.0).name == "a"
    assert room_at(scene(), 9.0, 1.0) is None
    assert rgb_of("#ff0080") == pytest.approx((1.0, 0.0, 128 / 255))
    assert rgb_of("oak") == (0.6, 0.6, 0.6)


def test_an_unknown_mesh_is_named_with_its_place(tmp_path: Path):
    lamp = SceneObject("lamp", "lamp", "builtin:lampp", (1.0, 1.0, 0.0))
    with pytest.raises(SceneError, match=r"tiny: objects\[3\] \(lamp\): unknown mesh"):
        ScenePhysics(replace(scene(), objects=(*scene().objects, lamp)), Assets(tmp_path), "tiny")


def test_the_camera_is_the_protocols():
    assert (HM3D_CAMERA.width, HM3D_CAMERA.height, HM3D_CAMERA.z_m) == (640, 480, 0.88)
    assert HM3D_CAMERA.focal_px == pytest.approx(388.2, abs=0.1)


@pytest.mark.slow
def test_egl_and_tiny_agree(tmp_path: Path):
    with ScenePhysics(scene(), Assets(tmp_path), "tiny") as tiny:
        a = tiny.render(1.2, 2.3, 0.2, SMALL)
    with ScenePhysics(scene(), Assets(tmp_path), "auto") as other:
        if other.renderer != "egl":
            pytest.skip("no EGL on this machine")
        b = other.render(1.2, 2.3, 0.2, SMALL)
    same = a.segmentation == b.segmentation
    assert same.mean() > 0.97
    assert np.median(np.abs(a.depth_m - b.depth_m)) < 0.01
