"""A base on MAVLink against MAVSDK, which acts as an autopilot: another's code on the other end."""

import math
import time
from collections.abc import Callable

import pytest
from rover_double import until

from hil_sim.driving.link import free_port
from runtime.clock import SystemClock
from runtime.core.types import Pose, Twist
from runtime.robot.base import DriveOrder, Sent
from runtime.robot.mavlink.base import MavlinkBase

peer = pytest.importorskip("mavsdk_peer", reason="no mavsdk here: pip install -e '.[dev]'")

CLOCK = SystemClock()
ARDUPILOT, PX4 = 3, 12
AHEAD = Twist(0.3, 0.5)
UDP, TCP = (
    ("udpin:127.0.0.1:{}", "udpout://127.0.0.1:{}"),
    ("tcp:127.0.0.1:{}", "tcpin://127.0.0.1:{}"),
)


def driving(base: MavlinkBase, what: Callable[[], object], searching: bool = True) -> Sent:
    """Order as the control loop does, until something holds; what was sent last."""
    sent: list[Sent] = []

    def turn() -> object:
        twist = AHEAD if searching else Twist()
        sent.append(base.drive(DriveOrder(twist, 0, CLOCK.now_s() + 0.3, searching)))
        return what()

    until(turn)
    return sent[-1]


def pair(autopilot: int, ways: tuple[str, str] = UDP, **told):
    """What is not entered yet: a base, and whom it talks to."""
    port = free_port()
    mine, theirs = (way.format(port) for way in ways)
    other = peer.MavsdkPeer(theirs, autopilot, **told)
    return other, mine


def on(link: str, may_arm: bool = True, **more) -> MavlinkBase:
    return MavlinkBase(link, CLOCK, may_arm, tell=lambda line: None, **more)


@pytest.mark.parametrize("ways", [UDP, TCP], ids=["udp", "tcp"])
def test_px4_is_streamed_to_switched_armed_driven_and_put_on_hold(ways):
    other, link = pair(PX4, ways)
    with other, on(link) as base:
        driving(base, lambda: len(other.set_points) > 3)
        assert other.asked == []  # a stream comes first
        sent = driving(base, lambda: other.set_points[-1]["vx"] > 0.1)
        assert sent == Sent(AHEAD)
        assert other.asked == ["OFFBOARD", "ArmDisarm(arm=True, force=False)"]
        told = other.set_points[-1]
        assert (told["target_system"], told["target_component"]) == (1, 1)
        assert (told["coordinate_frame"], told["type_mask"]) == (8, 3527)
        assert math.hypot(told["vx"], told["vy"]) == pytest.approx(0.3)
        assert math.atan2(told["vy"], told["vx"]) == pytest.approx(-0.1)  # to the left
        driving(base, lambda: len(other.asked) > 3, searching=False)
        assert other.asked[2:] == ["HOLD", "ArmDisarm(arm=False, force=False)"]
        assert base.condition().hand == ""


def test_a_pilot_s_switch_is_a_hand_and_what_the_peer_warns_of_is_told():
    other, link = pair(PX4)
    with other, on(link) as base:
        driving(base, lambda: base.condition().held == "" and other.set_points)
        driving(base, lambda: other.set_points[-1]["vx"] > 0.1)
        other.switch("MANUAL")
        driving(base, lambda: base.condition().hand == "mode MANUAL")
        driving(base, lambda: other.set_points[-1]["vx"] < 0.01)
        other.warn("Battery unhealthy")
        other.charge(0.25)
        driving(base, lambda: base.condition().said == "Battery unhealthy")
        driving(base, lambda: base.condition().battery_percent == 25.0)
        other.switch("OFFBOARD")
        driving(base, lambda: other.set_points[-1]["vx"] > 0.1)
        assert base.condition().hand == ""
        assert other.asked.count("OFFBOARD") == 1


def test_a_peer_that_does_not_arm_is_not_driven():
    other, link = pair(PX4, armable=False)
    with other, on(link) as base:
        driving(base, lambda: base.condition().held.startswith("arming: "))
        assert "give the goal again" in base.condition().held
        assert {told["vx"] < 0.01 for told in other.set_points} == {True}


def test_without_leave_nothing_is_asked_of_the_peer():
    other, link = pair(PX4)
    with other, on(link, may_arm=False) as base:
        driving(base, lambda: len(other.set_points) > 60)
        assert other.asked == []
        assert "switch it to OFFBOARD, or run with --arm" in base.condition().held
        other.switch("OFFBOARD")
        driving(base, lambda: base.condition().held == "not armed: arm it, or run with --arm")
        assert other.asked == []


def test_ardupilot_s_set_points_are_read_as_forward_speed_and_yaw_rate():
    other, link = pair(ARDUPILOT)
    with other, on(link, may_arm=False) as base:
        driving(base, lambda: other.set_points)
        told = other.set_points[-1]
    assert (told["coordinate_frame"], told["type_mask"]) == (8, 1511)
    assert (told["vx"], told["yaw_rate"]) == (0.0, 0.0)  # it is not armed


def test_odometry_by_the_peer_s_own_encoder():
    poses: list[tuple[Pose, int]] = []
    other, link = pair(PX4, odometry=True)
    with other, on(link, odometry=lambda pose, stamp_ns: poses.append((pose, stamp_ns))):
        until(lambda: len(poses) > 3)
        other.at = 1.0, 4.0, math.pi / 2  # 2 m to the east, and turned to look there
        until(lambda: poses[-1][0].y_m != 0.0)
    assert (poses[0][0].x_m, poses[0][0].y_m, poses[0][0].yaw_rad) == (0.0, 0.0, 0.0)
    last, stamp_ns = poses[-1]
    assert (last.x_m, last.y_m) == pytest.approx((0.0, -2.0))
    assert last.yaw_rad == pytest.approx(-math.pi / 2)
    assert 0 <= time.time_ns() - stamp_ns < 5e9
