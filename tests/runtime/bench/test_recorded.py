"""A recorded drive is played as the robot published it."""

import json
from pathlib import Path

import numpy as np
import pytest
from other_half import base_pose

from runtime.bench.recorded import camera_of, drive, goal_of
from runtime.config import load
from runtime.core.types import Pose
from runtime.errors import RecordingError
from runtime.recording.mcap_file import McapFile
from runtime.recording.pictures import compressed
from runtime.robot import wire
from runtime.robot.session import TopicsConfig
from runtime.robot.transforms import CameraConfig

TOPICS = TopicsConfig()
S = 10**9


def written(
    path: Path, colour: bool = True, goal: str = "sofa", altered: bool | None = None
) -> Path:
    file = McapFile(path, {"robot": "test"})
    for n in range(5):
        stamp = n * S
        if goal and n == 1:
            told = {"kind": "goal", "body": {"goal": goal}}
            payload = json.dumps(told).encode()
            file.write("/loop/request", "rfnav.Request", stamp, stamp, payload)
        odometry = wire.encode_odometry(Pose(float(n), 0.0, 0.0), stamp)
        file.write("/odom", wire.ODOMETRY, stamp, stamp, odometry)
        file.write("/cmd_vel", wire.TWIST, stamp, stamp, wire.encode_twist(0.1, 0.0))
        if colour:
            image = compressed(np.zeros((4, 4, 3), np.uint8), stamp, "camera")
            topic = "/camera/color/image_raw/compressed"
            file.write(topic, wire.COMPRESSED_IMAGE, stamp, stamp, image)
        if altered is not None:
            told = json.dumps({"altered": altered}).encode()
            file.write("/loop/frame", "rfnav.Frame", stamp, stamp, told)
    file.close()
    return path


def test_what_came_of_the_robot_is_played_and_what_it_was_told_is_not(tmp_path: Path):
    played = list(drive(written(tmp_path / "a.mcap"), TOPICS, 60.0))
    assert [m.topic for m in played] == ["odom", "camera/color/image_raw/compressed"] * 5
    assert [m.at_ns for m in played[::2]] == [n * S for n in range(5)]
    assert base_pose(played[4].payload) == Pose(2.0, 0.0, 0.0)


def test_its_images_are_read_as_a_recording_has_them_and_not_as_the_camera_sent_them():
    topics = TopicsConfig(color="oak/rgb", depth="d/compressedDepth")
    before = ["bus.compressed=['color']", "camera.depth_unit_m=0.0001", "bus.topics.color=oak/rgb"]
    config = load(None, [*before, *camera_of(topics)])
    assert (config.bus.topics.color, config.bus.topics.depth) == ("oak/rgb/compressed", "d")
    assert (config.bus.is_packed("color"), config.bus.is_packed("depth")) == (True, False)
    assert config.camera == CameraConfig()


def test_only_as_much_as_was_asked_for(tmp_path: Path):
    assert len(list(drive(written(tmp_path / "a.mcap"), TOPICS, 2.5))) == 6


def test_it_is_looked_for_what_was_looked_for(tmp_path: Path):
    assert goal_of(written(tmp_path / "a.mcap")) == "sofa"
    with pytest.raises(RecordingError, match="give --goal"):
        goal_of(written(tmp_path / "b.mcap", goal=""))


def test_a_drive_without_colour_is_told_of(tmp_path: Path):
    with pytest.raises(RecordingError, match="has no colour images"):
        list(drive(written(tmp_path / "a.mcap", colour=False), TOPICS, 60.0))


def test_images_that_are_not_as_they_came_are_not_played_as_if_they_were(tmp_path: Path):
    assert list(drive(written(tmp_path / "a.mcap", altered=False), TOPICS, 60.0))
    with pytest.raises(RecordingError, match=r"b\.mcap: its images were set upright") as caught:
        next(drive(written(tmp_path / "b.mcap", altered=True), TOPICS, 60.0))
    assert "\n" not in str(caught.value)
