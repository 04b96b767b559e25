"""Frames and continuity of odometry, made up by hand."""

from dataclasses import replace

import pytest
from hearings import healthy, still

from runtime.config import Config, load
from runtime.doctor.diagnosis import Diagnosis, Grade
from runtime.doctor.hearing import HeardPose
from runtime.doctor.odometry import judge_odometry

CONFIG = Config()


def found(poses: list[HeardPose], config: Config = CONFIG) -> dict[str, Diagnosis]:
    hearing = replace(healthy(CONFIG), odometry=poses)
    return {one.about: one for one in judge_odometry(hearing, config)}


def test_a_robot_that_stands():
    told = found([still(n) for n in range(20)])
    assert {one.grade for one in told.values()} == {Grade.OK}
    assert told["odometry frames"].told == '"base_link" in "odom"'
    assert found([]) == {}


@pytest.mark.parametrize(
    ("frame", "child", "grade"),
    [("odom", "base_footprint", Grade.OK), ("map", "base_link", Grade.WARNING),
     ("odom", "camera_link", Grade.OK), ("odom", "zed_left_optical_frame", Grade.OK)],
)  # fmt: skip
def test_frames(frame: str, child: str, grade: Grade):
    told = found([still(n, frame, child) for n in range(20)])
    assert told["odometry frames"].grade is grade


def test_several_that_tell_it():
    told = found([still(n, child=("a", "b")[n % 2]) for n in range(20)])
    assert told["odometry frames"].grade is Grade.BAD


def test_a_slam_has_no_child():
    slam = load(None, ["bus.topics.pose=slam/pose"])
    told = found([still(n, "odom", "") for n in range(20)], slam)
    assert told["odometry frames"].told == 'a pose in "odom"'


def test_jumps_and_a_clock_that_goes_back():
    poses = [still(n) for n in range(20)]
    poses[10] = replace(poses[10], xy=(2.0, 2.0))
    told = found(poses)["odometry goes on"]
    assert told.grade is Grade.BAD
    assert told.told.startswith("2 jumps in 20 messages")
    back = [still(n) for n in (0, 1, 2, 1, 2, 3)]
    assert found(back)["odometry goes on"].grade is Grade.BAD
