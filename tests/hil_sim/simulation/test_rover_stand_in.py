"""ArduPilot Rover's rules, as its stand-in keeps them."""

import math

import pytest
from mavlink_messages import GUIDED, HOLD, MANUAL, heard, heartbeat
from pymavlink.dialects.v20 import common as mavlink

from hil_sim.simulation.rover_stand_in import GUID_TIMEOUT_S, STATION_S, RoverStandIn
from runtime.core.types import Pose, Twist

ARM, MODE, INTERVAL = 400, 176, 511
ACCEPTED, UNSUPPORTED, FAILED = 0, 3, 4
STILL = Twist()


def command(rover: RoverStandIn, number: int, *parameters: float) -> int:
    given = (*parameters, *[0.0] * 7)[:7]
    message = mavlink.MAVLink_command_long_message(1, 1, number, 0, *given)
    (ack,) = rover.hear(heard(message), 0.0)
    assert ack.command == number
    return ack.result


def aim(rover: RoverStandIn, now_s: float, v=0.3, yaw_rate=-0.5, frame=8, mask=1511) -> None:
    still = 0.0, 0.0, 0.0
    message = mavlink.MAVLink_set_position_target_local_ned_message(
        0, 1, 1, frame, mask, *still, v, 0.0, 0.0, *still, 0.0, yaw_rate
    )
    assert list(rover.hear(heard(message), now_s)) == []


def ready(**given) -> RoverStandIn:
    rover = RoverStandIn(**given)
    assert command(rover, MODE, 1.0, GUIDED) == ACCEPTED
    assert command(rover, ARM, 1.0) == ACCEPTED
    return rover


def texts(rover: RoverStandIn, now_s: float) -> list[str]:
    told = rover.tell(Pose(0.0, 0.0, 0.0), now_s)
    return [m.text for m in told if m.get_type() == "STATUSTEXT"]


def test_a_set_point_is_driven_until_its_time_is_over():
    rover = ready()
    aim(rover, 10.0)
    for now_s in (10.0, 10.0 + GUID_TIMEOUT_S):
        assert rover.velocity(now_s).v_mps == pytest.approx(0.3)
        assert rover.velocity(now_s).w_radps == pytest.approx(0.5)  # down is positive: to the left
    assert rover.velocity(10.1 + GUID_TIMEOUT_S) == STILL
    assert texts(rover, 14.0) == ["target not received last 3.0 secs, stopping"]
    aim(rover, 15.0)
    assert rover.velocity(15.0) != STILL


@pytest.mark.parametrize(
    "what",
    [{"frame": 0}, {"mask": 1511 & ~0b11}, {"mask": 1511 & ~(7 << 6)}, {"mask": 1511 | 0b11 << 3}],
)
def test_other_set_points_are_not_obeyed(what):
    rover = ready()
    aim(rover, 10.0, **what)
    assert rover.velocity(10.0) == STILL
    assert (rover.set_points, rover.ignored) == (0, 1)


def test_it_is_ignored_outside_guided_without_an_origin_and_unarmed():
    rover = RoverStandIn()
    command(rover, ARM, 1.0)
    aim(rover, 10.0)
    command(rover, MODE, 1.0, GUIDED)
    assert rover.velocity(10.0) == STILL  # what came before does not count
    rover = ready()
    rover.origin = False
    aim(rover, 10.0)
    assert rover.velocity(10.0) == STILL
    rover = RoverStandIn()
    command(rover, MODE, 1.0, GUIDED)
    aim(rover, 10.0)
    assert rover.velocity(10.0) == STILL


def test_backwards_and_too_fast():
    rover = ready()
    aim(rover, 10.0, v=-0.2)
    assert rover.velocity(10.0).v_mps == pytest.approx(-0.2)
    aim(rover, 10.0, v=9.0)
    assert rover.velocity(10.0).v_mps == pytest.approx(2.0)


def test_arming_can_be_refused_and_modes_that_there_are_not_are():
    rover = RoverStandIn(refuses="Compass not calibrated")
    assert command(rover, ARM, 1.0) == FAILED
    assert not rover.armed
    assert texts(rover, 0.0) == ["Arm: Compass not calibrated"]
    assert command(rover, MODE, 1.0, 77.0) == FAILED
    assert command(rover, 22) == UNSUPPORTED
    rover = ready()
    assert command(rover, ARM, 0.0) == ACCEPTED
    assert not rover.armed


def test_in_manual_the_sticks_drive():
    rover = ready(sticks=Twist(-0.4, 0.1))
    aim(rover, 10.0)
    rover.switch(MANUAL)
    assert rover.velocity(10.0) == Twist(-0.4, 0.1)
    rover.switch(GUIDED)
    assert rover.velocity(10.0) == STILL


def test_a_station_that_falls_silent_is_a_failsafe():
    rover = ready(station=255)
    aim(rover, 10.0)
    list(rover.hear(heartbeat(autopilot=8, kind=6, system=255, component=190), 10.0))
    list(rover.hear(heartbeat(autopilot=8, kind=18, system=1, component=191), 14.0))
    aim(rover, 9.9 + STATION_S)
    assert rover.velocity(9.9 + STATION_S) != STILL
    assert rover.velocity(10.1 + STATION_S) == STILL
    assert rover.mode == HOLD
    assert texts(rover, 20.0) == ["GCS Failsafe"]


def test_it_tells_where_it_is_in_north_east_down_at_the_rate_that_was_asked_for():
    rover = RoverStandIn(north_rad=math.pi / 2)  # it heads east
    for number in (32.0, 30.0):
        assert command(rover, INTERVAL, number, 40_000.0) == ACCEPTED
    told = [m for n in range(101) for m in rover.tell(Pose(1.0, 2.0, 0.5), n * 0.01)]
    kinds = [m.get_type() for m in told]
    assert 20 <= kinds.count("LOCAL_POSITION_NED") <= 26
    assert kinds.count("LOCAL_POSITION_NED") == kinds.count("ATTITUDE")
    assert kinds.count("HEARTBEAT") == 2
    place = next(m for m in told if m.get_type() == "LOCAL_POSITION_NED")
    assert (place.x, place.y) == (pytest.approx(3.0 + 2.0), pytest.approx(1.0 - 2.0))
    turn = next(m for m in told if m.get_type() == "ATTITUDE")
    assert turn.yaw == pytest.approx(math.pi / 2 - 0.5)
