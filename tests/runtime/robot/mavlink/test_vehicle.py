"""What a vehicle says of itself."""

import math
import struct

import pytest
from mavlink_messages import (
    ARDUPILOT,
    BOAT,
    GUIDED,
    HOLD,
    MANUAL,
    NOBODY,
    OFFBOARD,
    POSCTL,
    PX4,
    PX4_HOLD,
    QUADROTOR,
    ROVER,
    heard,
    heartbeat,
    parameter,
    position,
    status,
    warning,
)
from pymavlink.dialects.v20 import common as mavlink

from runtime.robot.battery import UNSURE_S
from runtime.robot.mavlink.vehicle import Autopilot, Vehicle


def met(**told) -> Vehicle:
    vehicle = Vehicle()
    assert vehicle.hear(heartbeat(**told), 10.0)
    vehicle.hear(position(), 10.0)
    return vehicle


@pytest.mark.parametrize(
    ("autopilot", "name", "mode", "known", "guided"),
    [
        (ARDUPILOT, Autopilot.ARDUPILOT, GUIDED, "GUIDED", True),
        (ARDUPILOT, Autopilot.ARDUPILOT, MANUAL, "MANUAL", False),
        (ARDUPILOT, Autopilot.ARDUPILOT, HOLD, "HOLD", False),
        (ARDUPILOT, Autopilot.ARDUPILOT, 99, "number 99", False),
        (PX4, Autopilot.PX4, OFFBOARD, "OFFBOARD", True),
        (PX4, Autopilot.PX4, POSCTL, "POSCTL", False),
        (PX4, Autopilot.PX4, PX4_HOLD, "HOLD", False),
        (PX4, Autopilot.PX4, 4 << 16 | 5 << 24, "RTL", False),
        (PX4, Autopilot.PX4, GUIDED, "number 0", False),
    ],
)
def test_a_rover_is_known_by_its_heartbeat(autopilot, name, mode, known, guided):
    vehicle = met(autopilot=autopilot, mode=mode, armed=True, system=7)
    assert (vehicle.autopilot, vehicle.system, vehicle.armed) == (name, 7, True)
    assert (vehicle.mode_name(), vehicle.guided()) == (known, guided)
    vehicle.hear(heartbeat(autopilot=autopilot, mode=mode, system=7), 11.0)
    assert not vehicle.armed


@pytest.mark.parametrize(
    ("kind", "autopilot", "why"),
    [
        (QUADROTOR, ARDUPILOT, "system 1 is a quadrotor: only rovers are driven"),
        (BOAT, ARDUPILOT, "system 1 is a surface boat: only rovers are driven"),
        (1, PX4, "system 1 is a fixed wing: only rovers are driven"),
        (ROVER, 0, "system 1 runs generic: only ArduPilot's and PX4's are driven"),
        (ROVER, 250, "system 1 runs 250: only ArduPilot's and PX4's are driven"),
    ],
)
def test_what_is_no_rover_of_ours_is_refused_by_name(kind, autopilot, why):
    vehicle = Vehicle()
    assert not vehicle.hear(heartbeat(kind=kind, autopilot=autopilot), 10.0)
    assert vehicle.autopilot is None
    assert vehicle.unfit(10.0) == why


def test_the_first_rover_is_the_vehicle_and_others_are_not_heard():
    vehicle = Vehicle()
    assert not vehicle.hear(heartbeat(autopilot=NOBODY, kind=6, system=255, component=190), 9.0)
    assert vehicle.unfit(9.0) == ""  # a ground station is nothing to tell
    vehicle.hear(heartbeat(kind=QUADROTOR, system=3), 9.0)
    assert vehicle.hear(heartbeat(system=2), 10.0)
    assert not vehicle.hear(heartbeat(mode=GUIDED, armed=True, system=4), 10.0)
    assert not vehicle.hear(
        heartbeat(autopilot=NOBODY, system=2, component=154), 10.0
    )  # its gimbal
    assert not vehicle.hear(position(system=4), 10.0)
    assert (vehicle.system, vehicle.mode, vehicle.armed) == (2, MANUAL, False)
    assert "no local position" in vehicle.unfit(10.0)
    vehicle.hear(position(system=2), 10.0)
    assert vehicle.unfit(10.0) == ""


def test_silence_and_a_position_that_does_not_come_are_told():
    vehicle = met()
    assert vehicle.unfit(12.0) == ""
    vehicle.hear(heartbeat(), 14.0)
    assert vehicle.unfit(14.0).startswith("no local position: its estimator has no origin yet")
    vehicle.hear(position(north=math.nan), 14.0)
    assert "no local position" in vehicle.unfit(14.0)
    assert vehicle.unfit(17.5) == "no heartbeat for 4 s"


def test_the_battery_as_long_as_it_is_worth_telling():
    vehicle = met()
    assert vehicle.battery_percent(10.0) is None
    vehicle.hear(status(-1), 10.0)
    assert vehicle.battery_percent(10.0) is None  # it does not know
    vehicle.hear(status(63), 10.0)
    assert vehicle.battery_percent(30.0) == 63.0
    assert vehicle.battery_percent(41.0) is None
    voltages = [65535] * 10
    given = 0, 0, 0, 32767, voltages, -1, -1, -1
    vehicle.hear(heard(mavlink.MAVLink_battery_status_message(*given, 55)), 41.0)
    assert vehicle.battery_percent(41.0) == 55.0
    vehicle.hear(heard(mavlink.MAVLink_battery_status_message(1, *given[1:], 5)), 41.0)
    assert vehicle.battery_percent(41.0) == 55.0  # another battery


def test_a_vehicle_that_begins_with_an_empty_battery_is_believed_when_it_stays_so():
    vehicle = met()
    vehicle.hear(status(0), 10.0)
    assert vehicle.battery_percent(10.5) is None
    assert vehicle.battery_percent(10.0 + UNSURE_S) == 0.0


def test_what_it_warns_of_is_kept_for_a_while():
    vehicle = met()
    vehicle.hear(warning("EKF3 IMU0 initialised", severity=6), 10.0)
    assert vehicle.said(10.0) == ""
    vehicle.hear(warning("PreArm: \n GPS 1: Bad fix\x00\x00"), 10.0)
    assert vehicle.said(19.0) == "PreArm: GPS 1: Bad fix"
    assert vehicle.said(21.0) == ""


def test_car_like_steering_and_moving_sideways_are_refused():
    vehicle = met()
    vehicle.hear(parameter("SERVO1_FUNCTION", 73.0), 10.0)
    assert vehicle.unfit(10.0) == ""
    vehicle.hear(parameter("SERVO1_FUNCTION", 26.0), 10.0)
    assert vehicle.unfit(10.0).startswith("steers like a car (SERVO1_FUNCTION 26)")
    vehicle = met()
    vehicle.hear(parameter("FRAME_TYPE", 2.0), 10.0)
    assert vehicle.unfit(10.0).startswith("moves sideways (FRAME_TYPE 2)")
    vehicle = met(autopilot=PX4)
    for number, told in (
        (6, ""),
        (5, "steers like a car (CA_AIRFRAME 5)"),
        (13, "moves sideways (CA_AIRFRAME 13)"),
    ):
        bytewise = struct.unpack("<f", struct.pack("<i", number))[0]
        vehicle.hear(parameter("CA_AIRFRAME", bytewise, mavlink.MAV_PARAM_TYPE_INT32), 10.0)
        assert vehicle.unfit(10.0).startswith(told)
        assert bool(told) == bool(vehicle.unfit(10.0))
