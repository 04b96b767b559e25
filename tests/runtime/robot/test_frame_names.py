"""Frames as the robot calls them."""

from runtime.core.types import Pose
from runtime.robot import wire
from runtime.robot.frame_names import FrameNames


def test_the_newest_message_names_the_frame_and_damage_names_none():
    names = FrameNames()
    assert names.of("odom", "odom") == "odom"
    names.note("odom", wire.encode_odometry(Pose(0, 0, 0), 5, "/odom_combined"))
    assert names.of("odom", "odom") == "odom_combined"
    assert names.of("color", "camera") == "camera"
    names.note("odom", b"\x00\x01")
    assert names.of("odom", "odom") == "odom"
    names.note("odom", wire.encode_odometry(Pose(0, 0, 0), 5, ""))
    assert names.of("odom", "odom") == "odom"
