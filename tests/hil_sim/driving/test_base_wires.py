"""The stand-in on its UDP port."""

import socket

from mavlink_messages import GUIDED, packed
from pymavlink.dialects.v20 import common as mavlink

from hil_sim.driving.base_wires import MavlinkWire
from hil_sim.simulation.rover_stand_in import RoverStandIn
from runtime.core.types import Pose, Twist


def test_what_comes_is_heard_and_answered_and_what_is_due_is_sent_to_who_called():
    each: list[float] = []
    rover = RoverStandIn()
    with (
        MavlinkWire(rover, lambda rover, now_s: each.append(now_s)) as wire,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        kind, link, odometry = wire.settings
        assert (kind, odometry) == ('base.kind="mavlink"', "base.odometry=true")
        other.connect(("127.0.0.1", int(link.strip('"').rpartition(":")[2])))
        other.settimeout(10)
        wire.report(Pose(0.0, 0.0, 0.0), 0, 0.0)  # to nobody yet
        other.send(b"\x00nonsense")
        switch = 176, 0, 1.0, float(GUIDED), 0.0, 0.0, 0.0, 0.0, 0.0
        other.send(packed(mavlink.MAVLink_command_long_message(1, 1, *switch), 1, 191))
        while rover.mode != GUIDED:
            assert wire.command(5.0) == Twist()
        wire.report(Pose(0.0, 0.0, 0.0), 0, 5.0)
        told = [mavlink.MAVLink(None).parse_buffer(other.recv(300))[0] for _ in range(3)]
    assert [m.get_type() for m in told] == ["COMMAND_ACK", "HEARTBEAT", "SYS_STATUS"]
    assert [m.get_seq() for m in told] == sorted(m.get_seq() for m in told)
    assert set(each) == {5.0}
