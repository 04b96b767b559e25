"""What others draw, read by MCAP's own reader of ROS 2 messages."""

from typing import Any

import numpy as np
import pytest
from drawn_reader import read

from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import MapCopy
from runtime.core.types import Detections, Frontier
from runtime.robot import drawn_messages
from runtime.robot.drawn_messages import (
    DETECTIONS,
    MARKERS,
    OCCUPANCY_GRID,
    PATH,
    POINTS_MOST,
    DrawnObject,
    Stamp,
    encode_detections,
    encode_frontiers,
    encode_map,
    encode_objects,
    encode_path,
)

AT = Stamp(5_000_000_007, "odom")


def headed(message: Any, frame: str = "odom") -> None:
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (5, 7)
    assert message.header.frame_id == frame


def test_the_map_has_its_cells_where_they_are():
    free = np.zeros((3, 4), bool)
    occupied = free.copy()
    free[0, 0] = free[2, 3] = True
    occupied[1, 2] = True
    frame = GridFrame(-1.0, -2.0, 0.05, 3, 4, first_row=10, first_col=20)
    copy = MapCopy(frame, occupied, free, ~(free | occupied))
    told = read(encode_map(copy, AT), OCCUPANCY_GRID)
    headed(told)
    info = told.info
    assert (info.width, info.height) == (4, 3)
    assert info.resolution == pytest.approx(0.05)
    assert info.origin.position.x == pytest.approx(0.0)  # -1 + 20 cells
    assert info.origin.position.y == pytest.approx(-1.5)
    assert info.origin.orientation.w == 1.0
    cells = np.array(told.data, np.int8).reshape(3, 4)
    assert (cells[0, 0], cells[2, 3], cells[1, 2]) == (0, 0, 100)
    assert (cells == -1).sum() == 9


def test_a_path_looks_along_itself():
    told = read(encode_path(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]), AT), PATH)
    headed(told)
    assert [(p.pose.position.x, p.pose.position.y) for p in told.poses] == [(0, 0), (1, 0), (1, 2)]
    turns = [2 * np.arctan2(p.pose.orientation.z, p.pose.orientation.w) for p in told.poses]
    assert turns == pytest.approx([0.0, np.pi / 2, np.pi / 2])
    headed(told.poses[2])


@pytest.mark.parametrize("points", [0, 1, POINTS_MOST + 1, 10 * POINTS_MOST])
def test_a_path_is_no_longer_than_is_drawn_and_ends_where_it_ends(points: int):
    path = np.stack([np.arange(points), np.zeros(points)], axis=1).astype(float)
    told = read(encode_path(path, AT), PATH)
    assert len(told.poses) <= POINTS_MOST
    assert (points == 0) == (not told.poses)
    if points:
        assert told.poses[-1].pose.position.x == points - 1


def test_frontiers_are_markers_by_their_ids_and_what_is_gone_is_deleted():
    cells = np.array([[1.0, 2.0], [1.05, 2.0]])
    frontiers = (Frontier(7, cells, (1.0, 2.0), 3.25), Frontier(9, cells + 1, (2.0, 3.0), np.inf))
    told = read(encode_frontiers(frontiers, 7, [4], AT), MARKERS).markers
    assert [(m.ns, m.id, m.action) for m in told] == [
        ("frontiers", 7, 0),
        ("frontier names", 7, 0),
        ("frontiers", 9, 0),
        ("frontier names", 9, 0),
        ("frontiers", 4, 2),
        ("frontier names", 4, 2),
    ]
    assert [m.text for m in told[1::2][:2]] == ["7: 3.2 m", "9: no way"]
    assert [(p.x, p.y) for p in told[0].points] == [(1.0, 2.0), (1.05, 2.0)]
    assert (told[0].type, told[1].type) == (8, 9)
    assert (told[0].color.r, told[0].color.g) != (told[2].color.r, told[2].color.g)
    for marker in told:
        headed(marker)
        assert marker.color.a > 0


def test_objects_are_boxes_where_they_stand():
    thing = DrawnObject(3, "toilet", 0.875, (1.0, 2.0, 0.4), (0.5, 0.6, 0.8))
    box, name = read(encode_objects([thing], "toilet", (), AT), MARKERS).markers
    assert (box.ns, box.id, box.type) == ("objects", 3, 1)
    assert (box.pose.position.x, box.pose.position.y, box.pose.position.z) == (1.0, 2.0, 0.4)
    assert (box.scale.x, box.scale.y, box.scale.z) == (0.5, 0.6, 0.8)
    assert (name.ns, name.id, name.text) == ("object names", 3, "toilet 3 (0.88)")
    assert name.pose.position.z > 0.8
    other = read(encode_objects([thing], "bed", (), AT), MARKERS).markers[0]
    assert (other.color.r, other.color.g) != (box.color.r, box.color.g)


def test_detections_are_boxes_in_the_image():
    seen = Detections(
        np.array([[10, 20, 30, 60]], np.float32),
        np.array([0.75], np.float32),
        np.array([1], np.int32),
        np.zeros((1, 0), np.float32),
        np.zeros(0, np.float32),
    )
    told = read(
        encode_detections(seen, ("bed", "toilet"), Stamp(5_000_000_007, "lens")), DETECTIONS
    )
    headed(told, "lens")
    (one,) = told.detections
    centre = one.bbox.center.position
    assert (centre.x, centre.y, one.bbox.size_x, one.bbox.size_y) == (20, 40, 20, 40)
    (result,) = one.results
    assert (result.hypothesis.class_id, result.hypothesis.score) == ("toilet", 0.75)


def test_the_types_are_vision_msgs_own():
    assert drawn_messages.DETECTIONS == "vision_msgs/msg/Detection2DArray"
