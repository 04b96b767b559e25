"""Poses and places told in odometry's frame and on a localisation's map."""

import math

import pytest
from other_half import odometry_of, tf

from runtime.core.types import Pose
from runtime.errors import SensorError
from runtime.robot.odometry import BaseOdometry
from runtime.robot.sync import RawMessage
from runtime.robot.told_frames import SMOOTH_S, ToldFrames
from runtime.robot.transforms import Transforms

UP = (0.0, 0.0, 0.0, 1.0)
REPORT = {"state": "searching", "pose": [1.0, 2.0, 0.5], "toward_xy": (3.0, 0.0), "v_mps": 0.2}
QUARTER = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))


class Robot:
    def __init__(self, map_frame: str = "map", at: tuple[float, float] = (0.0, 0.0)) -> None:
        self.transforms = Transforms(lambda error: pytest.fail(str(error)))
        odometry = BaseOdometry("odom", tell=lambda line: None)
        odometry.read(RawMessage(1, odometry_of((*at, 0.0), UP, 1), 0.0))
        self.frames = ToldFrames(map_frame, self.transforms, odometry)

    def correct(self, at: tuple[float, float], turn: tuple, stamp_ns: int, now_s: float) -> None:
        told = tf(("map", "odom", (*at, 0.0), turn), stamp_ns=stamp_ns)
        self.transforms.file("tf", told)
        self.frames.update(now_s)


def test_without_a_localisation_nothing_is_added():
    robot = Robot()
    robot.frames.update(1.0)
    assert robot.frames.told(REPORT, 1.0) == REPORT
    unasked = Robot(map_frame="")
    unasked.correct((5.0, 0.0), UP, 1, 1.0)
    assert unasked.frames.told(REPORT, 1.0) == REPORT


def test_poses_and_places_are_told_in_both():
    robot = Robot()
    robot.correct((10.0, -1.0), QUARTER, 1, 1.0)
    told = robot.frames.told(REPORT, 1.0)
    assert {name: told[name] for name in REPORT} == REPORT
    assert told["map"] == {
        "frame": "map",
        "from_odom": [10.0, -1.0, round(math.pi / 2, 4)],
        "pose": [8.0, 0.0, round(math.pi / 2 + 0.5, 4)],  # 10 - 2, -1 + 1
        "toward_xy": [10.0, 2.0],
    }


def test_a_correction_of_metres_moves_the_map_smoothly():
    robot = Robot()
    robot.correct((0.0, 0.0), UP, 1, 1.0)
    robot.correct((4.0, 0.0), QUARTER, 2, 10.0)
    seen = [
        robot.frames.told(REPORT, 10.0 + SMOOTH_S * n / 4)["map"]["from_odom"] for n in range(6)
    ]
    assert [round(x, 3) for x, _, _ in seen] == [0.0, 1.0, 2.0, 3.0, 4.0, 4.0]
    assert seen[2][2] == pytest.approx(math.pi / 4, abs=1e-3)


def test_one_that_comes_before_the_last_was_taken_goes_on_from_there():
    robot = Robot()
    robot.correct((0.0, 0.0), UP, 1, 1.0)
    robot.correct((4.0, 0.0), UP, 2, 10.0)
    robot.correct((0.0, 0.0), UP, 3, 10.0 + SMOOTH_S / 2)
    assert robot.frames.told(REPORT, 10.0 + SMOOTH_S / 2)["map"]["from_odom"][0] == 2.0
    assert robot.frames.told(REPORT, 10.0 + 2 * SMOOTH_S)["map"]["from_odom"][0] == 0.0


def test_where_odometry_begins_far_away_the_origin_is_told_and_counts():
    robot = Robot(at=(500_000.0, 4_000_000.0))
    told = robot.frames.told(REPORT, 1.0)
    assert told["origin_xy"] == (500_000.0, 4_000_000.0)
    robot.correct((-500_000.0, -4_000_000.0), UP, 1, 1.0)
    assert robot.frames.told(REPORT, 1.0)["map"]["pose"] == [1.0, 2.0, 0.5]


def test_poses_are_taken_in_each_of_the_frames_that_they_are_told_in():
    robot = Robot(at=(500_000.0, 0.0))
    there = Pose(500_003.0, -1.0, 0.25)
    assert robot.frames.taken(there, "", 1.0) == there
    assert robot.frames.taken(there, "odom", 1.0) == there
    with pytest.raises(SensorError, match=r"^map: nobody has told where the robot is on it$"):
        robot.frames.taken(there, "map", 1.0)
    robot.correct((10.0, -1.0), QUARTER, 1, 1.0)
    report = {"pose": [3.0, -1.0, 0.25]}  # from the map's origin on
    on_map = robot.frames.told(report, 1.0)["map"]["pose"]
    back = robot.frames.taken(Pose(*on_map), "map", 1.0)
    assert (back.x_m, back.y_m) == pytest.approx((there.x_m, there.y_m), abs=1e-3)
    assert back.yaw_rad == pytest.approx(0.25, abs=1e-3)


def test_a_pose_in_a_frame_that_nobody_knows_is_not_taken():
    with pytest.raises(SensorError, match=r'^frame_id: "room": must be "odom" or "map"$'):
        Robot().frames.taken(Pose(0.0, 0.0, 0.0), "room", 1.0)
    with pytest.raises(SensorError, match=r'must be "odom"; a localisation.s map is named by bus'):
        Robot(map_frame="").frames.taken(Pose(0.0, 0.0, 0.0), "map", 1.0)
