"""A rover on MAVLink, by its stand-in on a real socket; and what is told of one."""

import time

import pytest
from rover_double import RoverDouble, until

from hil_sim.driving.link import free_port
from runtime.clock import SystemClock
from runtime.config import Config, load
from runtime.doctor.diagnosis import Diagnosis, Grade
from runtime.doctor.rover import HeardRover, judge_rover, rover_heard
from runtime.robot.base import BaseCondition


def found(heard: HeardRover) -> dict[str, Diagnosis]:
    return {one.about: one for one in judge_rover(heard)}


def config(link: str, odometry: bool = False) -> Config:
    told = f"base.odometry={str(odometry).lower()}"
    return load(None, ["base.kind=mavlink", f"base.link={link}", told])


def test_another_base_is_left_alone():
    with rover_heard(Config(), SystemClock()) as heard:
        assert heard is None


def test_one_that_speaks_is_heard_neither_armed_nor_driven_and_tells_where_it_is():
    with RoverDouble() as rover:
        with rover_heard(config(rover.link, True), SystemClock()) as heard:
            assert heard is not None
            until(lambda: heard.known and len(heard.poses) > 3)
        assert heard.poses[0].child == "base_link"
        assert set(rover.velocities) == {rover.velocities[0]}
        assert not rover.rover.armed
    told = found(heard)
    assert told["rover"].grade is Grade.WARNING  # nobody has armed it
    assert "--arm" in told["rover"].remedy
    assert told["odom"].grade is Grade.OK


def test_one_that_is_not_there_is_bad():
    link = f"udpin:127.0.0.1:{free_port()}"
    with rover_heard(config(link), SystemClock()) as heard:
        time.sleep(0.1)
    assert heard is not None
    told = found(heard)["rover"]
    assert told.grade is Grade.BAD
    assert link in told.remedy


@pytest.mark.parametrize(
    ("condition", "grade", "words"),
    [
        (BaseCondition(battery_percent=80.0), Grade.OK, "battery 80 %"),
        (BaseCondition(hand="MANUAL"), Grade.WARNING, "a hand has the sticks: MANUAL"),
        (BaseCondition(held="not armed"), Grade.WARNING, "not armed"),
    ],
)
def test_what_it_says_of_itself(condition: BaseCondition, grade: Grade, words: str):
    told = found(HeardRover("serial:ttyS0:57600", False, condition, True))
    assert list(told) == ["rover"]
    assert told["rover"].grade is grade
    assert words in told["rover"].told


def test_odometry_that_is_wanted_and_does_not_come():
    told = found(HeardRover("serial:ttyS0:57600", True, BaseCondition(), True))["odom"]
    assert told.grade is Grade.BAD
    assert "base.odometry = false" in told.remedy
