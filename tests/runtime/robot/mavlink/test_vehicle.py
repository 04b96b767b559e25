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


# -- to the number ---------------------------------------------------------------------------------


def test_times_are_kept_to_just_as_long_as_they_are_worth():
    vehicle = met()
    assert vehicle.unfit(12.0) == ""
    no_position = "no local position: its estimator has no origin yet (a GPS fix, or an origin set)"
    assert vehicle.unfit(12.001) == no_position
    vehicle.hear(position(), 13.0)
    assert vehicle.unfit(13.0) == ""
    assert vehicle.unfit(13.001) == "no heartbeat for 3 s"
    vehicle.hear(warning("Low battery"), 10.0)
    assert vehicle.said(20.0) == "Low battery"
    assert vehicle.said(20.001) == ""
    vehicle.hear(status(100), 10.0)
    assert vehicle.battery_percent(40.0) == 100.0
    assert vehicle.battery_percent(40.001) is None


def test_a_position_comes_in_two_kinds_and_only_with_both_of_its_numbers():
    for north, east in ((math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (0.0, math.inf)):
        vehicle = Vehicle()
        vehicle.hear(heartbeat(), 10.0)
        assert vehicle.hear(position(north=north, east=east), 10.0)
        assert vehicle.position_s == -math.inf
    zeros, still = [0.0] * 21, (0.0,) * 6
    whole = mavlink.MAVLink_odometry_message(
        0, 1, 12, 1.0, 2.0, 0.0, [1.0, 0.0, 0.0, 0.0], *still, zeros, zeros
    )
    vehicle.hear(heard(whole), 11.0)
    assert vehicle.position_s == 11.0


def test_more_than_all_of_a_battery_is_no_level_and_severity_is_what_is_a_warning():
    vehicle = met()
    vehicle.hear(status(101), 10.0)
    assert vehicle.battery_percent(10.0) is None
    vehicle.hear(warning("note", severity=5), 10.0)
    assert vehicle.said(10.0) == ""
    assert vehicle.hear(warning("warning", severity=4), 11.0)
    assert vehicle.said(11.0) == "warning"


@pytest.mark.parametrize(
    ("mode", "known"),
    [
        (4 << 16 | 9 << 24, "AUTO 9"),
        (4 << 16, "AUTO 0"),
        (9 << 16 | 3 << 24, "number 9"),
        (3 << 16 | 5 << 24, "POSCTL"),
        (1 << 16 | 0xFFFF, "MANUAL"),
    ],
)
def test_a_mode_of_px4_is_two_numbers(mode: int, known: str):
    assert met(autopilot=PX4, mode=mode).mode_name() == known


def test_who_may_be_driving_it():
    for autopilot, held, guided, other in (
        (ARDUPILOT, HOLD, GUIDED, MANUAL),
        (PX4, PX4_HOLD, OFFBOARD, POSCTL),
    ):
        for mode, driven in ((held, False), (guided, False), (other, True)):
            assert met(autopilot=autopilot, mode=mode, armed=True).driven() is driven
            assert not met(autopilot=autopilot, mode=mode).driven()
    nobody = Vehicle(armed=True)
    assert (nobody.guided(), nobody.driven()) == (False, True)


def test_a_rover_after_a_stranger_is_all_that_is_told_of():
    vehicle = Vehicle()
    vehicle.hear(heartbeat(kind=QUADROTOR, system=3), 9.0)
    assert vehicle.stranger == "system 3 is a quadrotor: only rovers are driven"
    assert vehicle.hear(heartbeat(system=2, component=5), 10.0)
    assert (vehicle.system, vehicle.component, vehicle.stranger) == (2, 5, "")
    assert vehicle.hear(position(system=2, component=5), 10.0)
    assert not vehicle.hear(position(system=2, component=1), 10.0)


@pytest.mark.parametrize(
    ("kind", "named"), [(5, "an antenna tracker"), (6, "a gcs"), (200, "a 200"), (18, "an onboard")]
)
def test_what_it_is_is_said_as_people_say_it(kind: int, named: str):
    vehicle = Vehicle()
    vehicle.hear(heartbeat(kind=kind), 10.0)
    assert vehicle.stranger.startswith(f"system 1 is {named}")


def test_a_parameter_is_an_integer_s_bytes_of_px4_alone_and_of_integers():
    bytewise = struct.unpack("<f", struct.pack("<i", 13))[0]
    below = struct.unpack("<f", struct.pack("<i", -1_000_000_000))[0]
    integer, real = mavlink.MAV_PARAM_TYPE_INT32, mavlink.MAV_PARAM_TYPE_REAL32
    for autopilot, value, kind, known in (
        (PX4, bytewise, integer, 13.0),
        (PX4, below, integer, -1e9),
        (PX4, 2.5, real, 2.5),
        (ARDUPILOT, 26.0, integer, 26.0),
    ):
        vehicle = met(autopilot=autopilot)
        vehicle.hear(parameter("ANY", value, kind), 10.0)
        assert vehicle.parameters == {"ANY": known}


def test_what_cannot_be_driven_is_said_in_whole():
    vehicle = met()
    vehicle.hear(parameter("FRAME_TYPE", 4.0), 10.0)
    why = "moves sideways (FRAME_TYPE 4): only what turns on the spot is driven"
    assert vehicle.unfit(10.0) == why
    assert vehicle.unfit(20.0) == "no heartbeat for 10 s"
