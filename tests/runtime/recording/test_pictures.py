"""What is drawn lies where it is on the map."""

import numpy as np
import pytest
from apartment import MOUNT, NO_DETECTIONS, TWO_ROOMS, Apartment
from numpy_things import base_to_map

from runtime import navigate
from runtime.core.geometry import GridFrame, optical_to_base
from runtime.core.settings import NavigateConfig
from runtime.core.types import Mount, Pose
from runtime.core.world import World
from runtime.recording.pictures import Mark, Picture, drawn, transforms
from runtime.recording.schemas import ros_definition
from runtime.robot import wire


def picture() -> Picture:
    free, occupied = np.zeros((2, 40, 60), bool)
    free[10:20, 30:35], occupied[20, 30:35] = True, True
    frame = GridFrame(-1.0, -2.0, 0.05, 40, 60)
    path_xy = np.array([[0.5, -1.4], [0.6, -1.2]])
    return Picture(7, frame, free, occupied, path_xy, (Mark((0.5, -1.0), "bed", (1.0, 0.0, 0.0)),))


def messages() -> dict:
    return {
        topic: wire.STORE.deserialize_cdr(payload, kind)
        for topic, kind, payload in drawn(picture(), "odom")
    }


def test_the_grid_holds_what_is_known_where_it_is():
    grid = messages()["map"]
    cells = grid.data.reshape(grid.info.height, grid.info.width)
    assert grid.header.frame_id == "odom"
    at = grid.info.origin.position
    rows, columns = np.nonzero(cells == 100)
    assert np.allclose(at.x + columns * 0.05, -1.0 + np.arange(30, 35) * 0.05)
    assert np.allclose(at.y + rows * 0.05, -2.0 + 20 * 0.05)
    assert (cells == 0).sum() == 50
    assert (cells == -1).sum() == cells.size - 55


def test_each_message_is_of_a_known_type():
    kinds = {topic: kind for topic, kind, _ in drawn(picture(), "odom")}
    assert kinds == {
        "map": "nav_msgs/msg/OccupancyGrid",
        "path": "nav_msgs/msg/Path",
        "scene": "visualization_msgs/msg/MarkerArray",
    }
    assert all(ros_definition(kind) for kind in kinds.values())


def test_a_picture_stays_as_it_was_when_the_map_changes():
    home, cfg = Apartment.of(TWO_ROOMS, Pose(4.0, 3.0, 0.0)), NavigateConfig()
    world = World.begin("toilet", ("toilet",), (), home.pose, 0.18, 0)
    navigate.perceive(world, home.observe(), NO_DETECTIONS, MOUNT, cfg)
    taken = Picture.of(world)
    assert taken.free.sum() == world.map.free.sum() > 500
    free, marks = taken.free.copy(), taken.marks
    assert len(marks) == len(world.frontiers) > 0
    row, col = world.map.frame.cell(4.0, 3.0)
    there = taken.frame.cell(4.0, 3.0)
    assert world.map.free[row, col]
    assert taken.free[there]
    home.pose = Pose(4.0, 3.0, 3.0)
    navigate.perceive(world, home.observe(), NO_DETECTIONS, MOUNT, cfg)
    assert np.array_equal(taken.free, free)
    assert world.map.free.sum() > free.sum()


def test_the_way_and_the_marks():
    found = messages()
    assert [p.pose.position.x for p in found["path"].poses] == [0.5, 0.6]
    first, ball, word = found["scene"].markers
    assert first.action == 3  # what was there before goes
    assert (ball.pose.position.x, ball.pose.position.y) == (0.5, -1.0)
    assert word.text == "bed"


@pytest.mark.parametrize("mount", [Mount(), Mount(0.1, -0.2, 0.5, 0.1, 0.4, -2.0)])
def test_tf_places_the_camera_as_the_core_does(mount: Mount):
    pose = Pose(1.0, 2.0, 2.5)
    payload = transforms(pose, mount, 9, ("odom", "base_link", "lens"))
    base, camera = wire.decode_transforms(payload, "tf")
    points = np.random.default_rng(0).normal(size=(5, 3))
    inside = points @ optical_to_base(mount).T + [mount.x_m, mount.y_m, mount.z_m]
    assert np.allclose(_placed(camera, points), inside)
    assert np.allclose(_placed(base, inside), base_to_map(inside, pose))


def _placed(one: wire.FrameTransform, points: np.ndarray) -> np.ndarray:
    x, y, z, w = one.quaternion
    axis = np.array([x, y, z])
    once = np.cross(axis, points)
    return points + 2 * (w * once + np.cross(axis, once)) + one.translation_m
