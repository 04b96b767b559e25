"""A base on MAVLink turn by turn: in no thread, on a clock and a link that a test holds."""

import threading
from types import SimpleNamespace
from typing import Any

import pytest
from manual_clock import ManualClock
from mavlink_messages import (
    ARDUPILOT,
    GUIDED,
    HOLD,
    MANUAL,
    OFFBOARD,
    PX4,
    ROVER,
    packed,
)
from pymavlink.dialects.v20 import common as mavlink

from runtime.core.types import Pose, Twist
from runtime.errors import BaseError
from runtime.robot.base import BaseCondition, DriveOrder, Sent
from runtime.robot.mavlink import base as module
from runtime.robot.mavlink.base import FAREWELL_S, REOPEN_S, STANDS, WAIT_S, MavlinkBase

AHEAD = Twist(0.3, 0.5)
ADDRESS = "udpin:127.0.0.1:14550"
SYSTEM, COMPONENT = 7, 3  # the vehicle's


class Line:
    """What a test says that came, and what was sent."""

    def __init__(self, datagrams: bool = True) -> None:
        self.datagrams, self.full = datagrams, ""
        self.comes: list[bytes | Exception] = []
        self.sent: list[Any] = []
        self.waits: list[float] = []
        self.known, self.closed = 0, 0
        self._reader = mavlink.MAVLink(None)

    def receive(self, timeout_s: float) -> bytes:
        self.waits.append(timeout_s)
        came = self.comes.pop(0) if self.comes else b""
        if isinstance(came, Exception):
            raise came
        return came

    def heard_vehicle(self) -> None:
        self.known += 1

    def send(self, data: bytes) -> str:
        if not self.full:
            self.sent.extend(self._reader.parse_buffer(data))
        return self.full

    def close(self) -> None:
        self.closed += 1

    def took(self, kind: str = "") -> list[Any]:
        """What was sent since this was asked last; of that kind alone."""
        sent, self.sent = self.sent, []
        return [message for message in sent if kind in ("", message.get_type())]


class Idle:
    """A thread that does nothing."""

    def __init__(self, **how: Any) -> None:
        self.how, self.started = how, 0
        self.joins: list[float] = []

    def start(self) -> None:
        self.started += 1

    def join(self, timeout: float) -> None:
        self.joins.append(timeout)


class Ending:
    """Whether it is to end: as a test says, or once it has waited."""

    def __init__(self) -> None:
        self.ends, self.asked, self.waits = False, 0, list[float]()

    def is_set(self) -> bool:
        self.asked += 1
        assert self.asked < 1000  # it goes round without an end
        return self.ends

    def set(self) -> None:
        self.ends = True

    def wait(self, timeout: float) -> None:
        self.waits.append(timeout)


class Rover:
    """A base whose turns are called by a test, and the vehicle that it hears."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **how: Any) -> None:
        self.clock, self.line, self.said = ManualClock(1000.0), Line(), list[str]()
        self.opened: list[str] = []
        self.closed: Exception | None = None
        self.arrival_ns = 5_000_000_000
        names = {"Lock": threading.Lock, "Event": Ending, "Thread": Idle}
        monkeypatch.setattr(module, "threading", SimpleNamespace(**names))
        monkeypatch.setattr(module, "open_link", self.open_link)
        monkeypatch.setattr(module, "time", SimpleNamespace(time_ns=lambda: self.arrival_ns))
        self.base = MavlinkBase(ADDRESS, self.clock, tell=self.said.append, **how)

    def open_link(self, address: object) -> Line:
        self.opened.append(str(address))
        if self.closed is not None:
            raise self.closed
        return self.line

    def hears(self, *messages: Any) -> None:
        """A turn of its thread, for each."""
        for message in messages or (None,):
            came = packed(message, SYSTEM, COMPONENT) if message is not None else b""
            self.line.comes.append(came)
            self.base._turn()

    def beats(self, mode: int = GUIDED, armed: bool = True, autopilot: int = ARDUPILOT) -> None:
        flags = 1 | (128 if armed else 0)
        self.hears(mavlink.MAVLink_heartbeat_message(ROVER, autopilot, flags, mode, 4, 3))

    def stands_at(self, north: float = 0.0) -> None:
        place = north, 0.0, 0.0, 0.0, 0.0, 0.0
        self.hears(mavlink.MAVLink_local_position_ned_message(0, *place))

    def is_ready(self) -> None:
        self.beats()
        self.stands_at()
        self.line.took()

    def order(self, twist: Twist = AHEAD, searching: bool = True, worth_s: float = 0.3) -> Sent:
        return self.base.drive(DriveOrder(twist, 0, self.clock.now_s() + worth_s, searching))


@pytest.fixture
def rover(monkeypatch) -> Rover:
    return Rover(monkeypatch)


SET_POINT = "SET_POSITION_TARGET_LOCAL_NED"


def test_its_thread_is_named_and_ends_with_the_process_and_so_does_its_link(rover: Rover):
    thread: Any = rover.base._thread
    assert thread.how == {"target": rover.base._run, "name": "mavlink", "daemon": True}
    assert thread.started == 1
    assert rover.base.condition().held == f"no vehicle on {ADDRESS} yet"
    assert rover.order() == Sent(None, f"no vehicle on {ADDRESS} yet")
    rover.hears()
    assert rover.opened == [ADDRESS]
    assert rover.line.waits == [WAIT_S]
    rover.base.close()
    assert thread.joins == [FAREWELL_S + 2 * REOPEN_S]
    assert rover.base._ending.is_set()
    assert rover.line.closed == 1
    assert rover.base.condition().held == "closed"
    rover.base.close()
    assert rover.line.closed == 1


def test_it_says_once_a_second_who_it_is_from_the_first_turn_on(rover: Rover):
    rover.hears()
    (beat,) = rover.line.took()
    kind = mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID
    told = beat.type, beat.autopilot, beat.base_mode, beat.custom_mode, beat.system_status
    assert told == (*kind, 0, 0, mavlink.MAV_STATE_ACTIVE)
    assert beat.mavlink_version == 3
    assert (beat.get_srcSystem(), beat.get_srcComponent()) == (1, 191)
    rover.clock.advance(0.75)
    rover.hears()
    assert rover.line.took() == []
    rover.clock.advance(0.25)
    rover.hears()
    assert [message.get_type() for message in rover.line.took()] == ["HEARTBEAT"]
    rover.beats()
    rover.clock.advance(1.0)
    rover.hears()
    assert {message.get_srcSystem() for message in rover.line.took()} == {SYSTEM}


def test_messages_are_numbered_one_after_the_other(rover: Rover):
    for _ in range(300):
        rover.hears()
        rover.clock.advance(1.0)
    assert [message.get_seq() for message in rover.line.took()] == [n % 256 for n in range(300)]


def test_who_is_met_is_told_once(rover: Rover):
    rover.beats()
    rover.beats()
    assert rover.said == [f"base: ArduPilot rover, system {SYSTEM}, on {ADDRESS}"]
    assert rover.line.known == 2
    rover.line.comes.append(packed(mavlink.MAVLink_statustext_message(4, b"x"), SYSTEM + 1))
    rover.base._turn()
    assert rover.line.known == 2  # somebody else's
    assert rover.base.condition().said == ""


@pytest.mark.parametrize(("wanted", "hz"), [(True, 25.0), (False, 1.0)])
def test_streams_are_asked_for_until_they_come_and_parameters_once_they_are_told(
    monkeypatch, wanted: bool, hz: float
):
    how: dict[str, Any] = {"odometry": lambda pose, stamp_ns: None} if wanted else {}
    rover = Rover(monkeypatch, **how)
    rover.beats()
    asked = rover.line.took("COMMAND_LONG")
    assert [one.command for one in asked] == [mavlink.MAV_CMD_SET_MESSAGE_INTERVAL] * 3
    assert [(one.param1, one.param2) for one in asked] == [
        (mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED, 1e6 / hz),
        (mavlink.MAVLINK_MSG_ID_ATTITUDE, 1e6 / hz),
        (mavlink.MAVLINK_MSG_ID_SYS_STATUS, 1e6),
    ]
    others = [(o.param3, o.param4, o.param5, o.param6, o.param7) for o in asked]
    assert others == [(0.0,) * 5] * 3
    assert [(o.target_system, o.target_component, o.confirmation) for o in asked] == [
        (SYSTEM, COMPONENT, 0)
    ] * 3
    rover.clock.advance(1.75)
    rover.hears()
    assert {message.get_type() for message in rover.line.took()} == {"HEARTBEAT"}
    rover.clock.advance(0.25)
    rover.hears()
    requests = [message for message in rover.line.took() if message.get_type()[:5] == "PARAM"]
    assert [one.param_id for one in requests] == ["SERVO1_FUNCTION", "FRAME_TYPE"]
    assert [(o.target_system, o.target_component, o.param_index) for o in requests] == [
        (SYSTEM, COMPONENT, -1)
    ] * 2
    nothing = 0, 0, 0, 0, 12000, -1
    rover.hears(mavlink.MAVLink_sys_status_message(*nothing, 60, 0, 0, 0, 0, 0, 0))
    rover.hears(mavlink.MAVLink_param_value_message(b"FRAME_TYPE", 0.0, 9, 1, 0))
    rover.stands_at()
    rover.clock.advance(2.0)
    rover.line.took()
    rover.hears()
    sent = rover.line.took()
    assert [one.get_type() for one in sent] == ["HEARTBEAT", "PARAM_REQUEST_READ"]
    assert sent[1].param_id == "SERVO1_FUNCTION"
    rover.clock.advance(2.0)
    rover.hears()
    assert rover.line.took("COMMAND_LONG") != []  # no position for long


def test_a_velocity_goes_out_with_the_time_since_it_began(rover: Rover):
    rover.is_ready()
    rover.clock.advance(1.5)
    assert rover.order() == Sent(AHEAD)
    (told,) = rover.line.took(SET_POINT)
    assert told.time_boot_ms == 1500
    assert (told.vx, told.yaw_rate) == pytest.approx((0.3, -0.5))
    assert (told.target_system, told.target_component) == (SYSTEM, COMPONENT)
    assert rover.base.condition() == BaseCondition()
    late = rover.order(worth_s=-0.5)
    assert late == Sent(None, "the order came 0.50 s too late")
    assert rover.line.took() == []


def test_without_leave_it_is_told_what_is_missing_and_to_stand(rover: Rover):
    rover.beats(MANUAL, armed=False)
    assert rover.base.condition().held.startswith("no local position")
    rover.stands_at()
    why = "mode MANUAL: switch it to GUIDED, or run with --arm"
    assert rover.order() == Sent(Twist(), why)
    assert rover.base.condition().held == why
    rover.line.took()
    rover.hears()
    assert rover.line.took() == []


def test_with_leave_a_search_asks_for_mode_and_arming_and_gives_them_back(monkeypatch):
    rover = Rover(monkeypatch, may_arm=True)
    rover.beats(MANUAL, armed=False)
    rover.stands_at()
    rover.order(Twist(), searching=False)
    rover.line.took()
    rover.hears()
    assert rover.line.took() == []
    rover.order()
    rover.hears()
    (asked,) = rover.line.took("COMMAND_LONG")
    assert (asked.command, asked.param1, asked.param2) == (mavlink.MAV_CMD_DO_SET_MODE, 1.0, 15.0)
    denied = mavlink.MAV_RESULT_DENIED
    rover.hears(mavlink.MAVLink_statustext_message(4, b"no GPS"))
    rover.hears(mavlink.MAVLink_command_ack_message(mavlink.MAV_CMD_DO_SET_MODE, denied))
    why = "GUIDED: denied (no GPS); see to it, then give the goal again"
    assert rover.base.condition().held == why


def test_after_a_search_it_is_told_to_stand_for_a_moment_and_then_nothing(rover: Rover):
    rover.is_ready()
    assert rover.order(Twist(), searching=False) == Sent(
        None, "no search: it may be somebody else's"
    )
    rover.order()
    assert rover.order(Twist(), searching=False) == Sent(Twist())
    rover.clock.advance(module.REST_S)
    assert rover.order(Twist(), searching=False) == Sent(Twist())
    rover.clock.advance(0.125)
    rover.line.took()
    nobody = Sent(None, "no search: it may be somebody else's")
    assert rover.order(Twist(), searching=False) == nobody
    assert rover.line.took() == []


def test_what_the_vehicle_warns_of_is_told_once_and_not_more_often_than_once_a_second(rover: Rover):
    rover.is_ready()
    del rover.said[:]
    rover.hears()
    for text in (b"one", b"two"):
        rover.hears(mavlink.MAVLink_statustext_message(4, text))
        rover.hears()
    assert rover.said == ["base: the vehicle says: one"]
    assert rover.base.condition().said == "two"
    rover.clock.advance(0.75)
    rover.hears()
    assert len(rover.said) == 1
    rover.clock.advance(0.25)
    rover.hears()
    rover.hears()
    assert rover.said[1:] == ["base: the vehicle says: two"]
    rover.clock.advance(20.0)
    rover.hears()
    assert rover.base.condition().said == ""
    rover.clock.advance(1.0)
    rover.hears(mavlink.MAVLink_statustext_message(4, b"two"))
    assert rover.said[1:] == ["base: the vehicle says: two"] * 2


def test_poses_are_told_with_when_they_came(monkeypatch):
    told: list[tuple[Pose, int]] = []
    rover = Rover(monkeypatch, odometry=lambda pose, stamp_ns: told.append((pose, stamp_ns)))
    rover.beats()
    rover.hears(mavlink.MAVLink_attitude_message(0, *[0.0] * 6))
    assert told == []
    rover.stands_at()
    rover.stands_at(2.0)
    assert told == [(Pose(0.0, 0.0, 0.0), 5_000_000_000), (Pose(2.0, 0.0, 0.0), 5_000_000_000)]


def test_who_else_knows_of_a_hand_and_of_the_battery_is_asked_where_the_vehicle_does_not(
    monkeypatch,
):
    beside = [BaseCondition("held", "a hand", 33.0, "said", 4)]
    rover = Rover(monkeypatch, beside=lambda: beside[0])
    rover.is_ready()
    assert rover.base.condition() == BaseCondition("", "a hand", 33.0, "", 0)
    nothing = 0, 0, 0, 0, 12000, -1
    rover.hears(mavlink.MAVLink_sys_status_message(*nothing, 60, 0, 0, 0, 0, 0, 0))
    assert rover.base.condition().battery_percent == 60.0
    hand = Sent(None, "a hand has the sticks: a hand")
    assert rover.order() == hand  # it was never told to move
    beside[0] = BaseCondition()
    assert rover.order() == Sent(AHEAD)
    rover.beats(HOLD)
    assert rover.order() == Sent(None, "a hand has the sticks: mode HOLD")
    assert rover.base.condition().hand == "mode HOLD"
    beside[0] = BaseCondition(hand="a hand")
    assert rover.base.condition().hand == "mode HOLD"


def test_what_was_moving_is_told_to_stand_a_few_times_when_a_hand_takes_over(monkeypatch):
    beside = [BaseCondition()]
    rover = Rover(monkeypatch, beside=lambda: beside[0])
    rover.is_ready()
    assert rover.order() == Sent(AHEAD)
    assert [rover.order(Twist()) for _ in range(STANDS - 1)] == [Sent(Twist())] * (STANDS - 1)
    beside[0] = BaseCondition(hand="a hand")
    assert rover.order() == Sent(Twist(), "a hand")
    assert rover.order() == Sent(None, "a hand has the sticks: a hand")
    beside[0] = BaseCondition()
    assert [rover.order(Twist()) for _ in range(STANDS)] == [Sent(Twist())] * STANDS
    beside[0] = BaseCondition(hand="a hand")
    assert rover.order() == Sent(None, "a hand has the sticks: a hand")


def test_what_px4_does_not_do_is_told_and_in_a_hand_it_is_told_to_stand(rover: Rover):
    rover.beats(OFFBOARD, autopilot=PX4)
    rover.stands_at()
    assert rover.order(Twist(-0.2, 0.0)) == Sent(Twist(), "PX4 takes no velocity backwards")
    rover.beats(MANUAL, autopilot=PX4)
    assert rover.order() == Sent(Twist(), "mode number 0")


def test_a_link_that_is_full_is_told(rover: Rover):
    rover.is_ready()
    rover.line.full = "does not take more"
    assert rover.order() == Sent(None, "does not take more")


def test_without_a_link_nothing_is_taken_for_sent(rover: Rover):
    rover.is_ready()
    rover.base._hang_up("")
    assert rover.order() == Sent(None, "no link")


def test_what_is_broken_in_a_datagram_takes_nothing_of_the_next(rover: Rover):
    rover.line.comes.append(b"\xfd\x09\x00")
    rover.base._turn()
    rover.beats()
    assert len(rover.said) == 1


def test_what_cannot_be_read_is_counted(rover: Rover):
    rover.is_ready()
    rover.line.comes.append(b"\x00")
    rover.base._turn()
    assert rover.base.condition().bad == 1


def test_a_stream_is_read_across_what_came_at_once(monkeypatch):
    rover = Rover(monkeypatch)
    rover.line = Line(datagrams=False)
    data = packed(mavlink.MAVLink_heartbeat_message(ROVER, PX4, 1, OFFBOARD, 4, 3), SYSTEM)
    rover.line.comes = [data[:7], data[7:]]
    rover.base._turn()
    assert rover.said == []
    rover.base._turn()
    assert rover.said == [f"base: PX4 rover, system {SYSTEM}, on {ADDRESS}"]


# -- its thread ------------------------------------------------------------------------------------


def test_a_link_that_breaks_is_opened_anew_a_moment_later(rover: Rover):
    ending: Any = rover.base._ending
    rover.is_ready()
    assert rover.order() == Sent(AHEAD)
    rover.line.comes = [b"\xfd\x00", BaseError("broken"), ValueError("mistake")]
    first, opened = rover.line, []

    def wait(timeout_s: float) -> None:
        ending.waits.append(timeout_s)
        assert (rover.base._link, first.closed) == (None, 1)
        opened.append(rover.base.condition().held)
        assert rover.order() == Sent(None, "broken")
        rover.line = Line()
        rover.line.comes = [ValueError("mistake")]

    ending.wait = wait
    rover.base._run()
    assert (ending.waits, opened) == ([REOPEN_S], ["broken"])
    assert rover.opened == [ADDRESS] * 2
    with pytest.raises(ValueError, match="mistake"):
        rover.base.condition()
    assert rover.line.closed == 0  # the base is still to be told to stand
    assert rover.order(Twist()).twist == Twist()


def test_what_is_left_of_a_broken_stream_is_not_read_with_the_next(rover: Rover):
    rover.line = Line(datagrams=False)
    data = packed(mavlink.MAVLink_heartbeat_message(ROVER, PX4, 1, OFFBOARD, 4, 3), SYSTEM)
    rover.line.comes = [data[:7]]
    rover.base._turn()
    rover.base._hang_up("broken")
    rover.line = Line(datagrams=False)
    rover.line.comes = [data]
    rover.base._turn()
    assert rover.said == [f"base: PX4 rover, system {SYSTEM}, on {ADDRESS}"]


def test_at_the_end_it_goes_at_once_where_nothing_is_asked_for(rover: Rover):
    rover.is_ready()
    rover.base._ending.set()
    before = len(rover.line.waits)
    rover.base._run()
    assert len(rover.line.waits) == before


def test_at_the_end_it_goes_at_once_where_there_is_no_link(monkeypatch):
    rover = Rover(monkeypatch, may_arm=True)
    rover.base._takeover._disarm_s = 0.0
    assert not rover.base._takeover.idle
    rover.base._ending.set()
    rover.base._run()
    assert rover.opened == []


def test_at_the_end_what_is_asked_for_is_waited_for_but_not_for_long(monkeypatch):
    rover = Rover(monkeypatch, may_arm=True)
    rover.is_ready()
    rover.base._takeover._disarm_s = 1e9
    rover.base._ending.set()
    turns: list[float] = []

    def receive(timeout_s: float) -> bytes:
        rover.clock.advance(0.5)
        turns.append(rover.clock.now_s() - 1000.0)
        return b""

    monkeypatch.setattr(rover.line, "receive", receive)
    rover.base._run()
    assert turns[-1] == FAREWELL_S + 0.5
