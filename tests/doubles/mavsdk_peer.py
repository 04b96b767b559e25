"""MAVSDK as an autopilot: another's MAVLink on the other end of the wire. It answers as its own
rules have it, and shows nothing of how a vehicle behaves."""

import ctypes
import json
import math
import threading
from typing import Any

from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.cmavsdk_loader import _cmavsdk_lib as library
from mavsdk.logging import log_subscribe
from mavsdk.plugins import telemetry_server as telemetry
from mavsdk.plugins.action_server import ActionServer, AllowableFlightModes, FlightMode
from mavsdk.plugins.mavlink_direct_server import MavlinkDirectServer, MavlinkMessage

ROVER = 10
LOCAL_FRD, BODY_FRD = 20, 12  # MAV_FRAME
TELL_S = 0.05
MODES = {"MANUAL": FlightMode.MANUAL, "OFFBOARD": FlightMode.OFFBOARD}


class MavsdkPeer:
    """`autopilot`: whose it says it is, once; what it says later is MAVSDK's own. `set_points`:
    their fields, as MAVSDK reads them; `asked`: modes and armings. `odometry`: whether it tells
    ODOMETRY, of a place and a yaw, or only a local position."""

    def __init__(self, url: str, autopilot: int, armable: bool = True, odometry: bool = False):
        self.set_points: list[dict[str, Any]] = []
        self.asked: list[str] = []
        self.at = 1.0, 2.0, 0.0  # north m, east m, yaw rad
        self._odometry = odometry
        log_subscribe(lambda *_: True)
        configuration = Configuration.create_with_component_type(ComponentType.AUTOPILOT)
        library.mavsdk_configuration_set_mav_type.argtypes = [ctypes.c_void_p, ctypes.c_uint8]
        library.mavsdk_configuration_set_mav_type(configuration._handle, ROVER)
        self._mavsdk = Mavsdk(configuration)
        self._mavsdk.add_any_connection(url)
        component = self._mavsdk.server_component(0)
        self._action, self._direct = ActionServer(component), MavlinkDirectServer(component)
        self._telemetry = telemetry.TelemetryServer(component)
        self._action.set_allowable_flight_modes(AllowableFlightModes(True, True, True))
        self._action.set_armable(armable, False)
        self._action.set_disarmable(True, False)
        self._action.subscribe_arm_disarm(lambda result, what, _: self.asked.append(str(what)))
        self._action.subscribe_flight_mode_change(
            lambda result, mode, _: self.asked.append(FlightMode(mode).name)
        )
        self._direct.subscribe_message(
            "SET_POSITION_TARGET_LOCAL_NED",
            lambda message, _: self.set_points.append(json.loads(message.fields_json)),
        )
        self._heartbeat = {"type": ROVER, "autopilot": autopilot, "base_mode": 1}
        self._heartbeat |= {"custom_mode": 0, "system_status": 4, "mavlink_version": 3}
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._tell)

    def __enter__(self) -> "MavsdkPeer":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()
        self._mavsdk.destroy()

    def switch(self, mode: str) -> None:
        """As the pilot does."""
        self._action.set_flight_mode_internal(MODES[mode])

    def warn(self, text: str) -> None:
        kind = telemetry.StatusTextType.CRITICAL
        self._telemetry.publish_status_text(telemetry.StatusText(kind, text))

    def charge(self, fraction: float) -> None:
        self._telemetry.publish_battery(telemetry.Battery(12.0, fraction))

    def _tell(self) -> None:
        fields = json.dumps(self._heartbeat)
        number = 0
        while not self._ending.wait(TELL_S):
            number += 1
            if number % 20 == 1 and not self.set_points:
                self._direct.send_message(MavlinkMessage("HEARTBEAT", 1, 1, 0, 0, fields))
            if self._odometry:
                told = MavlinkMessage("ODOMETRY", 1, 1, 0, 0, self._told(number))
                self._direct.send_message(told)
                continue
            north, east, _ = self.at
            place = telemetry.PositionNed(north, east, 0.0), telemetry.VelocityNed(0.0, 0.0, 0.0)
            self._telemetry.publish_position_velocity_ned(telemetry.PositionVelocityNed(*place))

    def _told(self, number: int) -> str:
        north, east, yaw = self.at
        fields: dict[str, Any] = {"time_usec": number * 50_000, "frame_id": LOCAL_FRD}
        fields |= {"child_frame_id": BODY_FRD, "x": north, "y": east, "z": 0.0}
        fields["q"] = [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]
        fields |= dict.fromkeys(("vx", "vy", "vz", "rollspeed", "pitchspeed", "yawspeed"), 0.0)
        fields |= {"pose_covariance": [0.0] * 21, "velocity_covariance": [0.0] * 21}
        return json.dumps(fields | {"reset_counter": 0, "estimator_type": 1, "quality": 50})
