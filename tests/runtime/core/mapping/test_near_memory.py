"""What was near is kept until the place is looked at again."""

import numpy as np
import pytest

from runtime.core.mapping.near_memory import KEEP_NS, KEPT, SCAN_NS, NearMemory
from runtime.core.mapping.near_points import NearPoints
from runtime.core.types import Intrinsics, Mount, Pose, Scan

CAMERA, LEVEL = Intrinsics(262.0, 262.0, 160.0, 120.0, 320, 240), Mount()
FAR = np.full((240, 320), 4.0, np.float32)
NONE = np.zeros((0, 3), np.float32)
NOTHING = NearPoints(NONE, NONE[:, 0], NONE)


def stands(*points, drops=NONE, lowest_m=None):
    obstacles = np.array(points, np.float32).reshape(-1, 3)
    lowest = obstacles[:, 2] if lowest_m is None else np.full(len(points), lowest_m, np.float32)
    return NearPoints(obstacles, lowest, np.asarray(drops, np.float32))


def add(memory, seen, pose=Pose(0.0, 0.0, 0.0), stamp_ns=0, depth=FAR):  # noqa: B008 -- a value
    return memory.add(seen, depth, pose, CAMERA, LEVEL, stamp_ns)


def test_points_are_told_in_the_map_frame():
    near = add(NearMemory(), stands((1.0, 0.2, 0.5)), Pose(2.0, 1.0, np.pi / 2))
    assert near.obstacles == pytest.approx(np.array([[1.8, 2.0]]), abs=1e-5)


def test_what_is_gone_from_view_is_forgotten_at_once():
    memory = NearMemory()
    add(memory, stands((1.0, 0.0, 0.7)))
    assert not len(add(memory, NOTHING, stamp_ns=1).obstacles)


def test_what_left_the_image_below_is_kept_for_a_while():
    memory = NearMemory()
    add(memory, stands((1.4, 0.0, 0.25)))  # just above the lower rim
    near = add(memory, NOTHING, Pose(0.45, 0.0, 0.0), 10**9)
    assert near.obstacles == pytest.approx(np.array([[1.4, 0.0]]), abs=1e-5)
    assert len(add(memory, NOTHING, Pose(0.8, 0.0, 0.0), KEEP_NS).obstacles) == 1
    assert not len(add(memory, NOTHING, Pose(0.8, 0.0, 0.0), KEEP_NS + 1).obstacles)


def test_what_is_hidden_or_of_unknown_depth_is_kept():
    hidden, unknown = np.full_like(FAR, 0.6), np.zeros_like(FAR)
    for depth in (hidden, unknown):
        memory = NearMemory()
        add(memory, stands((1.0, 0.0, 0.7)))
        assert len(add(memory, NOTHING, stamp_ns=1, depth=depth).obstacles) == 1


def test_where_the_room_is_longer_than_the_camera_sees_its_floor_tells():
    """A tall thing goes away: at its middle nothing is read before or after, but lower there is."""
    tall, hall = stands((0.25, 0.0, 0.9), lowest_m=0.7), np.zeros_like(FAR)
    hall[140:] = 3.0
    memory = NearMemory()
    add(memory, tall)
    assert len(add(memory, NOTHING, stamp_ns=1, depth=np.zeros_like(FAR)).obstacles) == 1
    assert not len(add(memory, NOTHING, stamp_ns=2, depth=hall).obstacles)
    hall[140:] = 0.05  # hidden
    add(memory, tall)
    assert len(add(memory, NOTHING, stamp_ns=3, depth=hall).obstacles) == 1
    edge = stands((0.25, 0.0, 0.9), lowest_m=0.88)  # of a table, too near to be read
    hall[140:] = 3.0
    memory = NearMemory()
    add(memory, edge)
    assert len(add(memory, NOTHING, stamp_ns=4, depth=hall).obstacles) == 1


def test_a_jump_of_odometry_and_a_way_off_forget_all():
    for way in ([1.0], [0.4, 0.8, 1.2, 1.6]):
        memory = NearMemory()
        add(memory, stands((-1.4, 0.0, 0.5)))
        for x in way:
            near = add(memory, NOTHING, Pose(x, 0.0, 0.0), 1)
        assert not len(near.obstacles)


def test_missing_floor_is_kept_as_such():
    memory = NearMemory()
    add(memory, stands(drops=[[0.9, 0, 0]]))
    near = add(memory, stands((1.0, 0.0, 0.7)), stamp_ns=1)
    assert near.drops == pytest.approx(np.array([[0.9, 0.0]]), abs=1e-5)
    assert len(near.obstacles) == 1


def test_of_too_many_the_nearest_are_kept():
    """A low thing that left the image below, before a table whose top is all points."""
    memory = NearMemory()
    add(memory, stands((0.4, 0.0, 0.25)))
    x, y = np.meshgrid(np.arange(0.8, 2.4, 0.04), np.arange(-0.7, 0.7, 0.04))
    table = np.stack([x, y, np.full_like(x, 0.75)], axis=2).reshape(-1, 3)
    assert len(table) > KEPT
    near = add(memory, stands(*table, drops=[[0.6, 0.0, 0.0]]), stamp_ns=1)
    assert len(near.obstacles) + len(near.drops) == KEPT
    assert (np.hypot(*(near.obstacles - (0.4, 0.0)).T) < 1e-5).any()
    assert near.drops == pytest.approx(np.array([[0.6, 0.0]]), abs=1e-5)
    assert np.hypot(*near.obstacles.T).max() < np.hypot(x, y).max()


def test_a_scan_counts_until_the_next_but_not_where_it_met_the_robot_itself():
    memory, pose = NearMemory(), Pose(1.0, 0.0, 0.0)
    ranges = np.array([0.5, 0.1, 0.0, np.inf, 9.0], np.float32)
    scan = Scan((1.0, 0.0), np.array([np.pi / 2, 0.0, 0.0, 0.0, 0.0]), ranges)
    near = add(memory, stands((1.0, 0.2, 0.5)), pose)
    both = memory.with_scan(near, scan, pose, 0.18).obstacles
    assert both == pytest.approx(np.array([[2.0, 0.2], [1.0, 0.5]]), abs=1e-5)
    after = memory.with_scan(add(memory, NOTHING, pose, SCAN_NS), None, pose, 0.18)
    assert after.obstacles == pytest.approx(np.array([[1.0, 0.5]]), abs=1e-5)
    later = memory.with_scan(add(memory, NOTHING, pose, SCAN_NS + 1), None, pose, 0.18)
    assert not len(later.obstacles)
