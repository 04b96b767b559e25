"""A base on MAVLink against the stand-in rover, over real sockets, on the wall clock."""

import random
import socket
import time
from collections.abc import Callable

import pytest
from mavlink_messages import ARDUPILOT, GUIDED, HOLD, MANUAL, QUADROTOR, heartbeat
from pymavlink.dialects.v20 import common as mavlink
from rover_double import RoverDouble, until

from hil_sim.simulation.rover_stand_in import RoverStandIn
from runtime.clock import SystemClock
from runtime.core.types import Pose, Twist
from runtime.errors import BaseError
from runtime.robot.base import BaseCondition, DriveOrder, Sent
from runtime.robot.mavlink import base as module
from runtime.robot.mavlink.base import STANDS, MavlinkBase
from runtime.robot.mavlink.links import UdpLink

CLOCK = SystemClock()
AHEAD = Twist(0.3, 0.5)


def order(twist: Twist = AHEAD, searching: bool = True, worth_s: float = 0.3) -> DriveOrder:
    return DriveOrder(twist, 0, CLOCK.now_s() + worth_s, searching)


def driving(base: MavlinkBase, what: Callable[[], object], twist: Twist = AHEAD) -> Sent:
    """Order as the control loop does, until something holds; what was sent last."""
    sent: list[Sent] = []

    def turn() -> object:
        sent.append(base.drive(order(twist)))
        return what()

    until(turn)
    return sent[-1]


def quiet(line: str) -> None:
    """Nobody reads it."""


@pytest.fixture
def rover():
    with RoverDouble() as double:
        yield double


def on(rover: RoverDouble, may_arm: bool = True, **more) -> MavlinkBase:
    return MavlinkBase(rover.link, CLOCK, may_arm, tell=quiet, **more)


def test_without_leave_a_person_has_to_switch_and_to_arm(rover):
    with on(rover, may_arm=False) as base:
        driving(base, lambda: "mode MANUAL" in base.condition().held)
        assert base.condition().held == "mode MANUAL: switch it to GUIDED, or run with --arm"
        rover.rover.switch(GUIDED)
        driving(base, lambda: "not armed" in base.condition().held)
        for _ in range(20):
            assert base.drive(order()).twist == Twist()
        assert not rover.rover.armed
        rover.rover.armed = True
        sent = driving(base, lambda: base.condition() == BaseCondition(battery_percent=80.0))
        assert sent.twist in (Twist(), AHEAD)
        assert driving(base, lambda: rover.velocities[-1].v_mps > 0) == Sent(AHEAD)


def test_with_leave_it_is_switched_and_armed_when_a_search_begins_and_driven(rover):
    with on(rover) as base:
        until(lambda: base.condition().battery_percent is not None)
        assert base.drive(order(Twist(), searching=False)).twist is None
        time.sleep(0.3)
        assert (rover.rover.mode, rover.rover.armed) == (MANUAL, False)
        assert rover.rover.ignored == 0  # whose it is now is not told to stand
        sent = driving(base, lambda: rover.velocities[-1] != Twist())
        assert sent == Sent(AHEAD)
        assert (rover.rover.mode, rover.rover.armed) == (GUIDED, True)
        assert rover.velocities[-1].v_mps == pytest.approx(AHEAD.v_mps)
        assert rover.velocities[-1].w_radps == pytest.approx(AHEAD.w_radps)
        driving(base, lambda: rover.pose.yaw_rad > 0.3)  # to the left
        until(lambda: base.drive(order(Twist(), False)) and rover.velocities[-1] == Twist())
        assert rover.rover.mode == GUIDED
        until(lambda: not rover.rover.armed)  # as it was found


def test_a_runtime_that_ends_leaves_the_rover_standing_and_as_it_was_found(rover):
    with on(rover) as base:
        driving(base, lambda: rover.velocities[-1] != Twist())
        base.drive(order(Twist(), searching=False))  # as the control loop does when it ends
    assert rover.velocities[-1] == Twist()
    assert not rover.rover.armed
    base.close()


def test_a_hand_on_the_sticks_is_told_nothing_until_it_gives_back(rover):
    with on(rover) as base:
        driving(base, lambda: rover.velocities[-1] != Twist())
        rover.rover.sticks = Twist(-0.5, 0.0)
        rover.rover.switch(MANUAL)
        driving(base, lambda: base.condition().hand)
        assert base.condition().hand == "mode MANUAL"
        time.sleep(0.1)  # what is under way
        before = rover.rover.ignored
        for searching in (True, False, True):
            sent = base.drive(order(Twist(), searching))
            assert sent == Sent(None, "a hand has the sticks: mode MANUAL")
        time.sleep(0.1)
        assert rover.rover.ignored == before
        assert rover.velocities[-1] == Twist(-0.5, 0.0)
        rover.rover.switch(HOLD)
        driving(base, lambda: base.condition().hand == "mode HOLD")
        rover.rover.switch(GUIDED)
        driving(base, lambda: rover.velocities[-1].v_mps > 0)
        assert base.condition().hand == ""


def test_a_hand_that_somebody_else_tells_of_stops_it_and_then_is_told_nothing(rover):
    """As the bus does, of cmd_vel_teleop. What was told last would be driven on for 3 s."""
    said, told = [BaseCondition()], []
    heard = lambda: rover.rover.set_points + rover.rover.ignored  # noqa: E731
    with on(rover, beside=lambda: said[0]) as base:

        def turn(searching: bool = True) -> Sent:
            sent = base.drive(order(AHEAD if searching else Twist(), searching))
            told.extend([sent.twist] if sent.twist is not None else [])
            return sent

        until(lambda: turn() and rover.velocities[-1] != Twist())
        said[0] = BaseCondition(hand="cmd_vel_teleop")
        until(lambda: turn().twist is None)
        assert told[-STANDS - 1 :] == [AHEAD, *[Twist()] * STANDS]
        until(lambda: heard() == len(told))
        assert rover.rover.velocity(time.monotonic()) == Twist()
        assert base.condition().hand == "cmd_vel_teleop"
        for searching in (True, False, True):
            assert turn(searching) == Sent(None, "a hand has the sticks: cmd_vel_teleop")
        time.sleep(0.1)
        assert heard() == len(told)
        said[0] = BaseCondition()
        until(lambda: turn() and rover.velocities[-1].v_mps > 0)


def test_what_stops_it_counts_when_the_link_has_taken_it(rover, monkeypatch):
    """A hand takes over while the link is full: it is told to stand as often as ever after that."""
    said = [BaseCondition()]
    with on(rover, beside=lambda: said[0]) as base:
        until(lambda: base.drive(order(AHEAD)) and rover.velocities[-1] != Twist())
        said[0] = BaseCondition(hand="cmd_vel_teleop")
        with monkeypatch.context() as full:
            full.setattr(UdpLink, "send", lambda link, data: "does not take more")
            for _ in range(3 * STANDS):
                assert base.drive(order(AHEAD)) == Sent(None, "does not take more")
        sent = [base.drive(order(AHEAD)).twist for _ in range(STANDS + 2)]
        assert sent == [*[Twist()] * STANDS, None, None]
        until(lambda: rover.rover.velocity(time.monotonic()) == Twist())


def test_what_a_hand_drives_when_a_search_ends_stays_armed(rover):
    said = [BaseCondition()]
    with on(rover, beside=lambda: said[0]) as base:
        driving(base, lambda: rover.velocities[-1] != Twist())
        said[0] = BaseCondition(hand="cmd_vel_teleop")
        base.drive(order(Twist(), searching=False))
    assert rover.rover.armed


def test_a_battery_that_the_vehicle_does_not_tell_of_is_asked_for_beside_it():
    with (
        RoverDouble(RoverStandIn(battery_percent=-1)) as rover,
        on(rover, beside=lambda: BaseCondition(battery_percent=33.0)) as base,
    ):
        assert base.condition().battery_percent == 33.0


def test_a_mistake_in_its_thread_ends_the_control_loop_and_the_base_can_still_be_stopped(rover):
    def mistaken(pose: Pose, stamp_ns: int) -> None:
        if rover.velocities[-1].v_mps > 0:
            raise ValueError("mistake")

    with on(rover, odometry=mistaken) as base:
        with pytest.raises(ValueError, match="mistake"):
            driving(base, lambda: base.condition() is None)
        until(lambda: base.drive(order(Twist())) and rover.velocities[-1] == Twist())


def test_a_refusal_to_arm_comes_with_what_the_vehicle_says():
    with RoverDouble(RoverStandIn(refuses="GPS 1: Bad fix")) as rover, on(rover) as base:
        driving(base, lambda: "failed" in base.condition().held)
        held = base.condition().held
        assert held.startswith("arming: failed")
        until(lambda: base.condition().said == "Arm: GPS 1: Bad fix")
        assert base.drive(order()).twist == Twist()


def test_an_estimator_without_an_origin_is_told():
    with RoverDouble(RoverStandIn(origin=False)) as rover, on(rover) as base:
        driving(base, lambda: rover.rover.armed)
        driving(base, lambda: "no local position" in base.condition().held)
        assert rover.velocities[-1] == Twist()
        rover.rover.origin = True
        driving(base, lambda: rover.velocities[-1].v_mps > 0)


def test_silence_holds_the_base_and_it_is_still_told_to_stand(rover):
    with on(rover) as base:
        driving(base, lambda: rover.velocities[-1] != Twist())
        rover.mute = True
        driving(base, lambda: "no heartbeat for" in base.condition().held)
        sent = driving(base, lambda: rover.velocities[-1] == Twist())
        assert sent.twist == Twist()
        assert "no heartbeat for" in sent.why
        rover.mute = False
        driving(base, lambda: rover.velocities[-1].v_mps > 0)


def test_when_the_runtime_is_gone_the_last_velocity_ends_by_the_vehicle_s_own_time_out(rover):
    with on(rover) as base:
        driving(base, lambda: rover.velocities[-1] != Twist())
    assert rover.velocities[-1] == AHEAD or rover.velocities[-1].v_mps > 0
    until(lambda: rover.velocities[-1] == Twist())
    assert rover.rover.mode == GUIDED


def test_odometry_is_told_in_the_map_frame(rover):
    poses: list[tuple[Pose, int]] = []
    with on(rover, odometry=lambda pose, stamp_ns: poses.append((pose, stamp_ns))) as base:
        driving(base, lambda: rover.pose.x_m > 0.3)
        until(lambda: base.drive(order(Twist(), False)) and rover.velocities[-1] == Twist())
        count = len(poses)
        until(lambda: len(poses) > count + 10)
    first, (pose, stamp_ns) = poses[0][0], poses[-1]
    assert (first.x_m, first.y_m, first.yaw_rad) == (0.0, 0.0, 0.0)
    assert pose.x_m == pytest.approx(rover.pose.x_m, abs=0.02)
    assert pose.y_m == pytest.approx(rover.pose.y_m, abs=0.02)
    assert pose.yaw_rad == pytest.approx(rover.pose.yaw_rad, abs=0.02)
    stamps = [stamp for _, stamp in poses]
    assert stamps == sorted(stamps)
    assert 0 <= time.time_ns() - stamp_ns < 5e9


def test_an_order_that_comes_too_late_is_not_sent(rover):
    with on(rover) as base:
        driving(base, lambda: rover.velocities[-1] != Twist())
        sent = base.drive(order(worth_s=-0.5))
        assert sent.twist is None
        assert sent.why.startswith("the order came 0.5")


def test_a_link_that_is_gone_is_why_nothing_is_sent_and_it_is_opened_anew(rover, monkeypatch):
    def no_link(address: object) -> None:
        raise BaseError("no way")

    with on(rover) as base:
        driving(base, lambda: rover.velocities[-1] != Twist())
        monkeypatch.setattr(module, "open_link", no_link)
        assert base._link is not None
        base._link.close()
        driving(base, lambda: base.condition().held == "no way")
        assert base.drive(order()) == Sent(None, "no way")
        monkeypatch.undo()
        driving(base, lambda: rover.velocities[-1].v_mps > 0)


def test_nobody_there_is_held_and_what_cannot_be_opened_is_opened_later():
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    with MavlinkBase(f"tcp:127.0.0.1:{port}", CLOCK, tell=quiet) as base:
        until(lambda: "refused" in base.condition().held)
        assert base.drive(order()).twist is None
        with socket.create_server(("127.0.0.1", port)) as server:
            other, _ = server.accept()
            with other:
                until(lambda: base.condition().held == f"no vehicle on tcp:127.0.0.1:{port} yet")
                message = heartbeat(kind=QUADROTOR)
                other.sendall(bytes(message.get_msgbuf()))
                until(lambda: "is a quadrotor: only rovers are driven" in base.condition().held)
            until(lambda: "tcp:127.0.0.1" in base.condition().held)


def test_what_cannot_be_read_is_counted_and_ends_nothing():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    draw, writer = random.Random(5), mavlink.MAVLink(None, 1, 1)
    with (
        MavlinkBase(f"udpin:127.0.0.1:{port}", CLOCK, tell=quiet) as base,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        message = mavlink.MAVLink_heartbeat_message(10, ARDUPILOT, 1, GUIDED, 4, 3)
        to = "127.0.0.1", port

        def speak() -> None:
            writer.seq = (writer.seq + 1) % 256
            other.sendto(message.pack(writer), to)

        until(lambda: speak() or "no local position" in base.condition().held)
        for number in range(3000):
            good = bytearray(mavlink_message(draw, number % 255).pack(writer))
            for _ in range(draw.randrange(4)):
                good[draw.randrange(len(good))] = draw.randrange(256)
            cut = good[: draw.randrange(len(good) + 1)] if draw.random() < 0.3 else good
            junk = draw.randbytes(draw.randrange(300))
            other.sendto(bytes(cut) if draw.random() < 0.8 else junk, to)
            if number % 50 == 0:
                time.sleep(0.01)  # so that most are read
        until(lambda: speak() or base.condition().bad > 100)
        assert base.drive(order()).twist in (None, Twist())
        signed = mavlink.MAVLink(None, 1, 1)
        signed.signing.secret_key, signed.signing.sign_outgoing = b"k" * 32, True
        known = mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 0, -1, 41, 0, 0, 0, 0, 0, 0)
        until(
            lambda: (
                other.sendto(known.pack(signed), to) and base.condition().battery_percent == 41.0
            )
        )


def mavlink_message(draw: random.Random, kind: int):
    """Of a kind that is read, full of anything."""
    number = draw.choice([float("nan"), float("inf"), -1e38, 0.0, 1e38])
    byte = draw.randrange(256)
    return [
        lambda: mavlink.MAVLink_heartbeat_message(byte, byte, byte, draw.randrange(2**32), byte, 3),
        lambda: mavlink.MAVLink_local_position_ned_message(byte, *[number] * 6),
        lambda: mavlink.MAVLink_attitude_message(draw.randrange(2**32), *[number] * 6),
        lambda: mavlink.MAVLink_statustext_message(byte, draw.randbytes(50)),
        lambda: mavlink.MAVLink_command_ack_message(draw.randrange(2**16), byte),
        lambda: mavlink.MAVLink_param_value_message(draw.randbytes(16), number, byte, 1, 0),
    ][kind % 6]()
