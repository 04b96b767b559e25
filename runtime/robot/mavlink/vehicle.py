"""What a vehicle has said of itself on MAVLink. No thread, no clock, no socket."""

import math
import struct
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final

from pymavlink.dialects.v20 import common as mavlink

from runtime.robot.battery import Charge

SILENT_S: Final = 3.0  # without a heartbeat, which comes once a second
POSITION_S: Final = 2.0  # without a local position the estimator has none
BATTERY_S: Final = 30.0  # how long a battery's level is worth telling
SAID_S: Final = 10.0  # how long a warning is


class Autopilot(StrEnum):
    """Whose rules hold."""

    ARDUPILOT = "ArduPilot"
    PX4 = "PX4"


AUTOPILOTS: Final = {
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: Autopilot.ARDUPILOT,
    mavlink.MAV_AUTOPILOT_PX4: Autopilot.PX4,
}
GUIDED: Final = {Autopilot.ARDUPILOT: 15, Autopilot.PX4: 6 << 16}  # custom_mode
GUIDED_NAME: Final = {Autopilot.ARDUPILOT: "GUIDED", Autopilot.PX4: "OFFBOARD"}
PX4_HOLD: Final = 4 << 16 | 3 << 24
HOLD: Final = {Autopilot.ARDUPILOT: 4, Autopilot.PX4: PX4_HOLD}
_ARDUPILOT_MODES: Final = {
    0: "MANUAL", 1: "ACRO", 3: "STEERING", 4: "HOLD", 5: "LOITER", 6: "FOLLOW", 7: "SIMPLE",
    8: "DOCK", 9: "CIRCLE", 10: "AUTO", 11: "RTL", 12: "SMART_RTL", 15: "GUIDED",
    16: "INITIALISING",
}  # fmt: skip
_PX4_MODES: Final = {
    1: "MANUAL", 2: "ALTCTL", 3: "POSCTL", 4: "AUTO", 5: "ACRO", 6: "OFFBOARD", 7: "STABILIZED",
}  # fmt: skip
_PX4_AUTO_MODES: Final = {2: "TAKEOFF", 3: "HOLD", 4: "MISSION", 5: "RTL", 6: "LAND"}
YAW_GAIN: Final = "RO_YAW_P"  # PX4: yaw rate in rad/s a rad of error
_CAR, _SIDEWAYS = "steers like a car", "moves sideways"
# What of a rover's parameters tells that it is none that turns on the spot: name, value, how.
UNFIT: Final = {
    Autopilot.ARDUPILOT: (
        ("SERVO1_FUNCTION", 26, _CAR),
        *(("FRAME_TYPE", number, _SIDEWAYS) for number in (1, 2, 3, 4)),
    ),
    Autopilot.PX4: (("CA_AIRFRAME", 5, _CAR), ("CA_AIRFRAME", 13, _SIDEWAYS)),
}
ASKED: Final = {  # the parameters that are read of a vehicle
    Autopilot.ARDUPILOT: ("SERVO1_FUNCTION", "FRAME_TYPE"),
    Autopilot.PX4: ("CA_AIRFRAME", YAW_GAIN),
}


@dataclass
class Vehicle:
    """The first rover that was heard; times are monotonic seconds. `stranger`: what else speaks
    there, as long as no rover does."""

    autopilot: Autopilot | None = None
    system: int = 0
    component: int = 0
    heartbeat_s: float = -math.inf
    mode: int = -1
    armed: bool = False
    position_s: float = -math.inf
    stranger: str = ""
    parameters: dict[str, float] = field(default_factory=dict)
    _charge: Charge = field(default_factory=Charge)
    _said: tuple[str, float] = ("", -math.inf)

    def hear(self, message: Any, now_s: float) -> bool:
        """Take a message in; whether it is the vehicle's."""
        kind = message.get_type()
        source = message.get_srcSystem(), message.get_srcComponent()
        if kind == "HEARTBEAT" and self.autopilot is None:
            self._meet(message)
        if self.autopilot is None or source != (self.system, self.component):
            return False
        if kind == "HEARTBEAT":
            self.heartbeat_s, self.mode = now_s, message.custom_mode
            self.armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        elif kind in ("LOCAL_POSITION_NED", "ODOMETRY") and math.isfinite(message.x + message.y):
            self.position_s = now_s
        elif kind == "SYS_STATUS" or (kind == "BATTERY_STATUS" and message.id == 0):
            if 0 <= message.battery_remaining <= 100:
                self._charge.tell(float(message.battery_remaining), now_s)
        elif kind == "STATUSTEXT" and message.severity <= mavlink.MAV_SEVERITY_WARNING:
            self._said = " ".join(message.text.split()), now_s
        elif kind == "PARAM_VALUE":
            self.parameters[message.param_id] = self._value(message)
        return True

    def mode_name(self) -> str:
        """As people say it."""
        main, sub = self.mode >> 16 & 0xFF, self.mode >> 24 & 0xFF
        if self.autopilot is Autopilot.ARDUPILOT:
            return _ARDUPILOT_MODES.get(self.mode, f"number {self.mode}")
        if _PX4_MODES.get(main) == "AUTO":
            return _PX4_AUTO_MODES.get(sub, f"AUTO {sub}")
        return _PX4_MODES.get(main, f"number {main}")

    def guided(self) -> bool:
        """Whether it is in the mode in which it obeys set-points."""
        return self.autopilot is not None and self.mode == GUIDED[self.autopilot]

    def driven(self) -> bool:
        """Whether a pilot, or a mission, may be driving it: it is armed in a mode of theirs."""
        held = self.autopilot is not None and self.mode == HOLD[self.autopilot]
        return self.armed and not held and not self.guided()

    def battery_percent(self, now_s: float) -> float | None:
        """None when it is not known, or no longer."""
        return self._charge.percent(now_s, BATTERY_S)

    def said(self, now_s: float) -> str:
        """What it warned of lately."""
        return self._said[0] if now_s - self._said[1] <= SAID_S else ""

    def unfit(self, now_s: float) -> str:
        """Why it cannot be driven, whatever its mode; "" when it can."""
        if self.autopilot is None:
            return self.stranger
        silent_s = now_s - self.heartbeat_s
        if silent_s > SILENT_S:
            return f"no heartbeat for {silent_s:.0f} s"
        for name, value, how in UNFIT[self.autopilot]:
            if self.parameters.get(name) == value:
                return f"{how} ({name} {value}): only what turns on the spot is driven"
        if now_s - self.position_s > POSITION_S:
            return (
                "no local position: its estimator has no origin yet (a GPS fix, or an origin set)"
            )
        return ""

    def _meet(self, heartbeat: Any) -> None:
        """Somebody speaks for the first time."""
        if heartbeat.autopilot == mavlink.MAV_AUTOPILOT_INVALID:
            return  # a ground station, a camera
        system = heartbeat.get_srcSystem()
        autopilot = AUTOPILOTS.get(heartbeat.autopilot)
        if heartbeat.type != mavlink.MAV_TYPE_GROUND_ROVER:
            self.stranger = f"system {system} is {_type(heartbeat.type)}: only rovers are driven"
        elif autopilot is None:
            name = _name("MAV_AUTOPILOT", heartbeat.autopilot)
            self.stranger = f"system {system} runs {name}: only ArduPilot's and PX4's are driven"
        else:
            self.autopilot, self.stranger = autopilot, ""
            self.system, self.component = system, heartbeat.get_srcComponent()

    def _value(self, message: Any) -> float:
        """PX4 sends an integer's bytes as those of a float; ArduPilot its value."""
        value = float(message.param_value)
        if self.autopilot is Autopilot.PX4 and message.param_type == mavlink.MAV_PARAM_TYPE_INT32:
            return float(struct.unpack("<i", struct.pack("<f", value))[0])
        return value


def _type(number: int) -> str:
    name = _name("MAV_TYPE", number)
    return f"a{'n' * (name[0] in 'aeio')} {name}"


def _name(enum: str, number: int) -> str:
    """A value of an enum, in words."""
    entry = mavlink.enums[enum].get(number)
    return entry.name.removeprefix(f"{enum}_").lower().replace("_", " ") if entry else str(number)
