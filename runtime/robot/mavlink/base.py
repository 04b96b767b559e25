"""A rover on MAVLink as a `Base`: set-points at the rate of the control loop, a heartbeat a second,
mode and arming asked for where that is allowed, odometry where it is wanted.

One thread of its own receives and sends what has a rate of its own; `drive` sends in the thread of
the control loop. A message that cannot be read is counted and dropped; a link that is gone is
opened anew.
"""

import threading
import time
from collections.abc import Callable
from typing import Any, Final, Self

from pymavlink.dialects.v20 import common as mavlink

from runtime.clock import Clock
from runtime.core.motion.courses import STILL
from runtime.core.types import Pose
from runtime.errors import BaseError
from runtime.log import say
from runtime.robot.base import WELL, BaseCondition, DriveOrder, Sent
from runtime.robot.mavlink.addresses import MavlinkAddress
from runtime.robot.mavlink.inbox import Inbox
from runtime.robot.mavlink.links import MavlinkLink, open_link
from runtime.robot.mavlink.odometry import VehicleOdometry
from runtime.robot.mavlink.set_points import set_point
from runtime.robot.mavlink.takeover import Takeover, VehicleCommand
from runtime.robot.mavlink.vehicle import ASKED, Autopilot, Vehicle

WAIT_S: Final = 0.05  # for bytes
HEARTBEAT_S: Final = 1.0
ASK_S: Final = 2.0  # between two times that the same streams and parameters are asked for
REOPEN_S: Final = 1.0
FAREWELL_S: Final = 4.0  # at the end, for the vehicle to come to rest and be disarmed
STANDS: Final = 4  # set-points that stop what was moving when a hand takes over: some may get lost
REST_S: Final = 2.0  # after a search, in which it is told to stand; then it may be anybody's
TELL_S: Final = 1.0  # between two lines of what the vehicle warns of
POSE_HZ: Final = 25.0
SLOW_HZ: Final = 1.0
COMPONENT: Final = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER


class MavlinkBase:
    """See the module. `may_arm`: whether mode and arming may be asked for; `odometry`: who is told
    poses in the map frame and their stamps by the wall clock, None where they are not wanted;
    `beside`: who else knows of a hand and of the battery, of which the vehicle itself goes first.
    ConfigError for an address that is none."""

    def __init__(
        self,
        link: str,
        clock: Clock,
        may_arm: bool = False,
        odometry: Callable[[Pose, int], None] | None = None,
        tell: Callable[[str], None] = say,
        beside: Callable[[], BaseCondition] = lambda: WELL,
    ) -> None:
        self._address, self._clock = MavlinkAddress.parse(link), clock
        self._tell_pose, self._tell, self._beside = odometry, tell, beside
        self._lock = threading.Lock()
        self._vehicle, self._takeover = Vehicle(), Takeover(may_arm)
        self._odometry = VehicleOdometry()
        self._writer = mavlink.MAVLink(None, 1, COMPONENT)
        self._inbox = Inbox()
        self._link: MavlinkLink | None = None
        self._broken = ""  # why there is no link
        self._searching, self._rest_s = False, -1e9  # and when it ended
        self._stands = 0  # that are still owed to a base that was told to move
        self._error: Exception | None = None  # what ended the thread
        self._began_s = clock.now_s()
        self._heartbeat_s = self._ask_s = self._told_s = -1e9
        self._told = ""
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="mavlink", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- for the control loop ------------------------------------------------------------------

    def drive(self, order: DriveOrder) -> Sent:
        """See `Base`. A vehicle that is not ours to drive is told to stand: ArduPilot and PX4
        ignore that outside GUIDED and OFFBOARD, and PX4 enters OFFBOARD only while it is told
        something. In a hand ArduPilot is told nothing. Without a search both are told nothing, but
        to stand when one has just ended. While somebody else speaks of a hand both are told to
        stand if they were moving, for nothing else may, and then nothing."""
        now_s, hand = self._clock.now_s(), self._beside().hand
        if late := order.late(now_s):
            return Sent(None, late)
        with self._lock:
            vehicle, takeover = self._vehicle, self._takeover
            if order.searching is not self._searching:
                self._searching, self._rest_s = order.searching, now_s
                if order.searching:
                    takeover.begin(now_s)
                else:
                    takeover.end(vehicle, now_s, bool(hand))
            if vehicle.autopilot is None:
                return Sent(None, self._held(now_s))
            if not order.searching and now_s - self._rest_s > REST_S:
                return Sent(None, "no search: it may be somebody else's")
            if takeover.hand and vehicle.autopilot is Autopilot.ARDUPILOT:
                return Sent(None, f"a hand has the sticks: {takeover.hand}")
            if hand and not self._stands:
                return Sent(None, f"a hand has the sticks: {hand}")
            held = takeover.hand or hand or self._held(now_s)
            time_ms = round((now_s - self._began_s) * 1e3)
            point = set_point(vehicle, STILL if held else order.twist, time_ms)
            error = self._send(point.message)
            if point.twist != STILL:
                self._stands = STANDS
            elif not error:
                self._stands = max(0, self._stands - 1)
        return Sent(None, error) if error else Sent(point.twist, held or point.why)

    def condition(self) -> BaseCondition:
        """See `Base`. What ended the thread is raised here, and so ends the control loop."""
        if self._error is not None:
            raise self._error
        now_s, beside = self._clock.now_s(), self._beside()
        with self._lock:
            battery, said = self._vehicle.battery_percent(now_s), self._vehicle.said(now_s)
            hand = self._takeover.hand or beside.hand
            battery = battery if battery is not None else beside.battery_percent
            return BaseCondition(self._held(now_s), hand, battery, said, self._inbox.bad)

    def close(self) -> None:
        """Stop speaking; what is asked for is waited for a moment. Idempotent."""
        self._ending.set()
        self._thread.join(timeout=FAREWELL_S + 2 * REOPEN_S)
        self._hang_up("closed")

    # -- the thread ----------------------------------------------------------------------------

    def _run(self) -> None:
        ended_s = None
        while True:
            if self._ending.is_set():
                ended_s = ended_s if ended_s is not None else self._clock.now_s()
                over = self._clock.now_s() - ended_s > FAREWELL_S
                with self._lock:
                    if over or self._link is None or self._takeover.idle:
                        return
            try:
                self._turn()
            except BaseError as error:
                self._hang_up(str(error))
                self._ending.wait(REOPEN_S)
            except Exception as error:  # noqa: BLE001 -- raised again by `condition`
                self._error = error  # the link stays open: the base is still to be told to stand
                return

    def _turn(self) -> None:
        """Receive once, and send what is due."""
        link = self._link
        if link is None:
            link = open_link(self._address)
            with self._lock:
                self._link, self._broken = link, ""
        data = link.receive(WAIT_S)
        arrival_ns = time.time_ns()
        if data:
            for message in self._inbox.read(data, link.datagrams):
                self._hear(message, link, arrival_ns)
        self._speak()

    def _hear(self, message: Any, link: MavlinkLink, arrival_ns: int) -> None:
        now_s = self._clock.now_s()
        with self._lock:
            known = self._vehicle.autopilot is not None
            if not self._vehicle.hear(message, now_s):
                return
            link.heard_vehicle()
            kind = message.get_type()
            if kind == "HEARTBEAT":
                self._writer.srcSystem = self._vehicle.system
                self._takeover.heard(self._vehicle)
            elif kind == "COMMAND_ACK":
                said = self._vehicle.said(now_s)
                self._takeover.acked(message.command, message.result, said)
            told = self._odometry.hear(message, arrival_ns) if self._tell_pose else None
            name, system = self._vehicle.autopilot, self._vehicle.system
        if not known:
            self._tell(f"base: {name} rover, system {system}, on {self._address}")
        if told is not None and self._tell_pose is not None:
            self._tell_pose(*told)

    def _speak(self) -> None:
        """What has a rate of its own, and what is asked for."""
        now_s = self._clock.now_s()
        with self._lock:
            if now_s - self._heartbeat_s >= HEARTBEAT_S:
                self._heartbeat_s = now_s
                self._send(_heartbeat())
            vehicle = self._vehicle
            if vehicle.autopilot is None:
                return
            if now_s - self._ask_s >= ASK_S:
                self._ask_s = now_s
                self._ask(vehicle, now_s)
            command = self._takeover.due(vehicle, now_s)
            if command is not None:
                self._send(_command(vehicle, command))
            said = vehicle.said(now_s)
        if said != self._told and now_s - self._told_s >= TELL_S:
            self._told, self._told_s = said, now_s
            if said:
                self._tell(f"base: the vehicle says: {said}")

    def _ask(self, vehicle: Vehicle, now_s: float) -> None:
        """For the streams and the parameters that do not come."""
        pose_hz = POSE_HZ if self._tell_pose else SLOW_HZ
        rates = {
            mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: pose_hz,
            mavlink.MAVLINK_MSG_ID_ATTITUDE: pose_hz,
            mavlink.MAVLINK_MSG_ID_SYS_STATUS: SLOW_HZ,
        }
        if now_s - vehicle.position_s > ASK_S or vehicle.battery_percent(now_s) is None:
            for number, hz in rates.items():
                wanted = mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, (float(number), 1e6 / hz)
                self._send(_command(vehicle, VehicleCommand(*wanted, 0)))
        assert vehicle.autopilot is not None
        for name in ASKED[vehicle.autopilot]:
            if name not in vehicle.parameters:
                to = vehicle.system, vehicle.component
                self._send(mavlink.MAVLink_param_request_read_message(*to, name.encode(), -1))

    # -- inside --------------------------------------------------------------------------------

    def _held(self, now_s: float) -> str:
        """Holding the lock: why it cannot be driven."""
        vehicle = self._vehicle
        if vehicle.autopilot is None or self._broken:
            nobody = f"no vehicle on {self._address} yet"
            return self._broken or vehicle.stranger or nobody
        return vehicle.unfit(now_s) or self._takeover.lacks(vehicle)

    def _send(self, message: Any) -> str:
        """Holding the lock: why it was not sent; "" when it was."""
        if self._link is None:
            return self._broken or "no link"
        data = message.pack(self._writer)
        self._writer.seq = (self._writer.seq + 1) % 256
        return self._link.send(data)

    def _hang_up(self, why: str) -> None:
        with self._lock:
            link, self._link, self._broken = self._link, None, why
        self._inbox.clear()
        if link is not None:
            link.close()


def _heartbeat() -> Any:
    kind, none = mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID
    return mavlink.MAVLink_heartbeat_message(kind, none, 0, 0, mavlink.MAV_STATE_ACTIVE, 3)


def _command(vehicle: Vehicle, command: VehicleCommand) -> Any:
    given = (*command.parameters, *[0.0] * 7)[:7]
    to = vehicle.system, vehicle.component, command.number, command.sent
    return mavlink.MAVLink_command_long_message(*to, *given)
