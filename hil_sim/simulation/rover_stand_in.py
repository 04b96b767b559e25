"""A stand-in for an ArduPilot Rover: the rules of its GUIDED mode on MAVLink, and nothing of its
controllers, its estimator or its radio.

The rules are those of Rover's source (GCS_MAVLink_Rover.cpp, mode_guided.cpp): set-points are
ignored outside GUIDED and without an origin of the estimator; a velocity that no other follows for
3 s ends; a station that falls silent for 5 s is a failsafe; arming can be refused, and says why.
Where the rover is, and what becomes of the velocity, is the physics' business.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from pymavlink.dialects.v20 import common as mavlink

from runtime.core.types import Pose, Twist

MANUAL, HOLD, GUIDED = 0, 4, 15
MODES: Final = frozenset({0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 15})
GUID_TIMEOUT_S: Final = 3.0
STATION_S: Final = 5.0
SPEED_MPS: Final = 2.0  # WP_SPEED: set-points are cut to it
SKID_STEERING: Final = 73.0  # SERVO1_FUNCTION: ThrottleLeft
FRAMES: Final = (1, 7, 8, 9)  # LOCAL_NED, LOCAL_OFFSET_NED, BODY_NED, BODY_OFFSET_NED
X_Y, VX_VY, ACCELERATION, YAW, YAW_RATE = 0b11, 0b11 << 3, 0b111 << 6, 1 << 10, 1 << 11
HEARTBEAT, STATUS, POSITION, ATTITUDE = 0, 1, 32, 30  # message numbers
STILL: Final = Twist()


@dataclass
class RoverStandIn:
    """`origin`: whether its estimator has one; `refuses`: why it does not arm; `sticks`: what the
    pilot's say, obeyed in MANUAL; `station`: the system whose heartbeats are watched, None for
    nobody's; `north_rad`: where it heads at the start, clockwise from north; `every_s`: between two
    messages of a number."""

    origin: bool = True
    refuses: str = ""
    sticks: Twist = STILL
    station: int | None = None
    north_rad: float = 0.7
    battery_percent: int = 80
    boot_s: float = 0.0
    mode: int = MANUAL
    armed: bool = False
    every_s: dict[int, float] = field(default_factory=lambda: {HEARTBEAT: 1.0, STATUS: 1.0})
    set_points: int = 0  # that were obeyed
    ignored: int = 0
    _target: tuple[Twist, float] | None = None
    _station_s: float | None = None
    _texts: list[tuple[int, str]] = field(default_factory=list)
    _sent_s: dict[int, float] = field(default_factory=dict)

    def hear(self, message: Any, now_s: float) -> Iterator[Any]:
        """A message, and what is answered."""
        kind = message.get_type()
        if kind == "HEARTBEAT" and message.get_srcSystem() == self.station:
            self._station_s = now_s
        elif kind == "SET_POSITION_TARGET_LOCAL_NED":
            obeyed = self._aim(message, now_s)
            self.set_points, self.ignored = self.set_points + obeyed, self.ignored + (not obeyed)
        elif kind == "COMMAND_LONG":
            result = self._command(message)
            yield mavlink.MAVLink_command_ack_message(message.command, result)
        elif kind == "PARAM_REQUEST_READ" and message.param_id == "SERVO1_FUNCTION":
            name, real = b"SERVO1_FUNCTION", mavlink.MAV_PARAM_TYPE_INT16
            yield mavlink.MAVLink_param_value_message(name, SKID_STEERING, real, 900, 300)

    def velocity(self, now_s: float) -> Twist:
        """What it drives now."""
        if self._station_s is not None and now_s - self._station_s > STATION_S:
            self._station_s = None
            self._warn("GCS Failsafe")
            self.switch(HOLD)
        if self._target is not None and now_s - self._target[1] > GUID_TIMEOUT_S:
            self._target = None
            self._warn(f"target not received last {GUID_TIMEOUT_S} secs, stopping")
        if not self.armed:
            return STILL
        if self.mode == MANUAL:
            return self.sticks
        return self._target[0] if self.mode == GUIDED and self._target else STILL

    def switch(self, mode: int) -> None:
        """To another mode, by the pilot's switch or a command."""
        self.mode, self._target = mode, None

    def tell(self, pose: Pose, now_s: float) -> Iterator[Any]:
        """What is due to be sent. `pose`: seen from the start, x forward, y left."""
        time_ms = round((now_s - self.boot_s) * 1e3)
        if self._due(HEARTBEAT, now_s):
            armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
            flags = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed
            whose = mavlink.MAV_TYPE_GROUND_ROVER, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
            yield mavlink.MAVLink_heartbeat_message(*whose, flags, self.mode, 4, 3)
        if self._due(STATUS, now_s):
            yield mavlink.MAVLink_sys_status_message(
                0, 0, 0, 0, 12000, -1, self.battery_percent, 0, 0, 0, 0, 0, 0
            )
        yaw_rad = math.remainder(self.north_rad - pose.yaw_rad, math.tau)
        if self._due(ATTITUDE, now_s):
            yield mavlink.MAVLink_attitude_message(time_ms, 0.0, 0.0, yaw_rad, 0.0, 0.0, 0.0)
        if self.origin and self._due(POSITION, now_s):
            c, s = math.cos(self.north_rad), math.sin(self.north_rad)
            north, east = c * pose.x_m + s * pose.y_m, s * pose.x_m - c * pose.y_m
            place = 3.0 + north, east - 2.0, 0.0  # the origin lies elsewhere
            yield mavlink.MAVLink_local_position_ned_message(time_ms, *place, 0.0, 0.0, 0.0)
        while self._texts:
            severity, text = self._texts.pop(0)
            yield mavlink.MAVLink_statustext_message(severity, text.encode()[:50])

    def _aim(self, message: Any, now_s: float) -> bool:
        """Whether a set-point is obeyed. Only forward speed with a yaw rate is: nobody here sends
        another."""
        mask = message.type_mask
        if self.mode != GUIDED or not self.origin or message.coordinate_frame not in FRAMES:
            return False
        wanted = not mask & (VX_VY | YAW_RATE)
        if not wanted or not mask & X_Y or not mask & ACCELERATION or not mask & YAW:
            return False
        speed = min(math.hypot(message.vx, message.vy), SPEED_MPS)
        turn_left = -message.yaw_rate  # down is positive
        self._target = Twist(math.copysign(speed, message.vx), turn_left), now_s
        return True

    def _command(self, message: Any) -> int:
        """Its result."""
        if message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            self.every_s[int(message.param1)] = message.param2 / 1e6
        elif message.command == mavlink.MAV_CMD_DO_SET_MODE:
            mode = int(message.param2)
            if mode not in MODES or (mode == GUIDED and self.armed and not self.origin):
                return int(mavlink.MAV_RESULT_FAILED)
            self.switch(mode)
        elif message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            if message.param1 and self.refuses:
                self._texts.append((mavlink.MAV_SEVERITY_CRITICAL, f"Arm: {self.refuses}"))
                return int(mavlink.MAV_RESULT_FAILED)
            self.armed = bool(message.param1)
        else:
            return int(mavlink.MAV_RESULT_UNSUPPORTED)
        return int(mavlink.MAV_RESULT_ACCEPTED)

    def _warn(self, text: str) -> None:
        self._texts.append((mavlink.MAV_SEVERITY_WARNING, text))

    def _due(self, number: int, now_s: float) -> bool:
        every_s = self.every_s.get(number)
        if every_s is None or now_s - self._sent_s.get(number, -math.inf) < every_s:
            return False
        self._sent_s[number] = now_s
        return True
