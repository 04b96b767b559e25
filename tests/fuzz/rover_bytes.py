"""What comes from a vehicle on MAVLink, as an entry point of its own: bytes -> messages -> what is
known of the vehicle, what is asked of it, where it is."""

import math
import struct
from collections.abc import Iterator
from contextlib import suppress

import mavlink_messages as told
from pymavlink.dialects.v20 import common as mavlink

from runtime.core.types import Twist
from runtime.errors import SensorError
from runtime.robot import wire
from runtime.robot.mavlink.inbox import Inbox
from runtime.robot.mavlink.odometry import VehicleOdometry
from runtime.robot.mavlink.set_points import set_point
from runtime.robot.mavlink.takeover import Takeover
from runtime.robot.mavlink.vehicle import Vehicle
from runtime.robot.odometry import BaseOdometry
from runtime.robot.sync import RawMessage

S = 10**9
CHUNK = 40  # bytes that a stream brings at once
WHOLE = mavlink.MAVLink_odometry_message(
    5_000_000, 1, 1, 1.0, 2.0, 0.0, (1.0, 0.0, 0.0, 0.0), *(0.0,) * 6, (0.0,) * 21, (0.0,) * 21
)
SAID = [
    told.position(5000, 1.0, 2.0),
    told.attitude(5000, 0.5),
    told.status(50),
    told.warning("battery low"),
    told.parameter("SERVO1_FUNCTION", 73.0),
    mavlink.MAVLink_command_ack_message(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0),
    mavlink.MAVLink_command_ack_message(mavlink.MAV_CMD_DO_SET_MODE, 2),
]
SPEAKERS = [
    [told.heartbeat(told.GUIDED, True), *SAID, told.heartbeat(told.HOLD)],
    [told.heartbeat(told.OFFBOARD, True, told.PX4), WHOLE, told.parameter("RO_YAW_P", 5.0), *SAID],
]
KINDS = sorted({message.get_msgId() for messages in SPEAKERS for message in messages})
STREAM, DATAGRAM, FRAMED = range(3)
"""What the first byte of an input says of the rest: bytes of a stream, a datagram, or payloads of
messages (each after one byte for which it is, and one for its length) that are framed and given the
right checksum here, without which nothing behind it would be reached."""


def payload_of(message) -> bytes:
    return told.packed(message)[10:-2]


def framed(kind: int, payload: bytes, number: int) -> bytes:
    """A message of MAVLink 2 around any bytes, by system 1, component 1."""
    whole = mavlink.mavlink_map[kind]
    payload = payload[: whole.unpacker.size] or b"\0"
    head = struct.pack("<BBBBBBHB", len(payload), 0, 0, number % 256, 1, 1, kind, 0)
    crc = mavlink.x25crc(head + payload)
    crc.accumulate(bytes((whole.crc_extra,)))
    return b"\xfd" + head + payload + struct.pack("<H", crc.crc)


def frames(data: bytes) -> Iterator[bytes]:
    at = number = 0
    while at + 1 < len(data):
        kind, length = KINDS[data[at] % len(KINDS)], data[at + 1]
        yield framed(kind, data[at + 2 : at + 2 + length], number)
        at, number = at + 2 + length, number + 1


def _seeds() -> Iterator[bytes]:
    for messages in SPEAKERS:
        whole = b"".join(told.packed(message) for message in messages)
        yield bytes((STREAM,)) + whole
        yield bytes((DATAGRAM,)) + whole
        parts = [(KINDS.index(m.get_msgId()), payload_of(m)) for m in messages]
        yield bytes((FRAMED,)) + b"".join(bytes((k, len(p))) + p for k, p in parts)


SEEDS = tuple(_seeds())


class Rover:
    """What `MavlinkBase` keeps of a vehicle, without its link and its thread."""

    def __init__(self) -> None:
        self.inbox, self.vehicle = Inbox(), Vehicle()
        self.takeover, self.odometry = Takeover(True), VehicleOdometry()
        self.now_s, self.heard = 10.0, 0
        self.takeover.begin(self.now_s)

    def take(self, data: bytes, datagram: bool) -> None:
        for message in self.inbox.read(data, datagram):
            self.now_s += 0.1
            if not self.vehicle.hear(message, self.now_s):
                continue
            self.heard += 1
            if message.get_type() == "HEARTBEAT":
                self.takeover.heard(self.vehicle)
            elif message.get_type() == "COMMAND_ACK":
                said = self.vehicle.said(self.now_s)
                self.takeover.acked(message.command, message.result, said)
            pose = self.odometry.hear(message, round(self.now_s * S))
            if pose is not None:
                with suppress(SensorError):  # of beyond reason, which is counted where it is filed
                    told = wire.encode_odometry(*pose)
                    BaseOdometry().read(RawMessage(pose[1], told, self.now_s))
        self._asked()

    def _asked(self) -> None:
        """What the control loop and the link's thread make of it."""
        vehicle = self.vehicle
        if vehicle.autopilot is None:
            return
        self.takeover.due(vehicle, self.now_s)
        lines = vehicle.unfit(self.now_s), self.takeover.lacks(vehicle), vehicle.said(self.now_s)
        assert not any("\n" in line for line in lines), lines
        percent = vehicle.battery_percent(self.now_s)
        assert percent is None or 0.0 <= percent <= 100.0
        point = set_point(vehicle, Twist(0.2, 0.5), 1000)
        assert math.isfinite(point.twist.v_mps + point.twist.w_radps)
        point.message.pack(mavlink.MAVLink(None))


def rover_bytes(data: bytes) -> Rover:
    """What any bytes leave behind."""
    rover, way, rest = Rover(), data[0] % 3 if data else STREAM, data[1:]
    if way == DATAGRAM:
        rover.take(rest, datagram=True)
    elif way == FRAMED:
        for message in frames(rest):
            rover.take(message, datagram=True)
    else:
        for at in range(0, len(rest), CHUNK):
            rover.take(rest[at : at + CHUNK], datagram=False)
    return rover
