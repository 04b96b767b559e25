"""Against a node that somebody else has written, which shares no code with us."""

import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
import zenoh
from fibonacci import FIBONACCI, sequence
from places import DOUBLES
from rosbags.interfaces import Nodetype

from hil_sim.driving.link import free_port
from runtime.clock import SystemClock
from runtime.core.geometry import GridFrame
from runtime.core.mapping.grid import MapCopy
from runtime.core.types import Twist
from runtime.loops.ros_goals import RosGoals
from runtime.robot import wire
from runtime.robot.action_server import ActionGoal, ActionServer, GoalState
from runtime.robot.base import DriveOrder
from runtime.robot.bus import Bus
from runtime.robot.dialects.dialect import Qos, RosService, RosTopic
from runtime.robot.drawn_messages import OCCUPANCY_GRID, Stamp, encode_map
from runtime.robot.ros_node import ServiceCall
from runtime.robot.session import BusConfig, session_settings

ADD = "example_interfaces/srv/AddTwoInts"
MAP = np.array([[0, 100], [-1, 0]], np.int8)

pytestmark = pytest.mark.skipif(
    find_spec("zenoh_ros2_sdk") is None,
    reason="NOT PROVEN: zenoh-ros2-sdk is not installed (pip install zenoh-ros2-sdk)",
)


@pytest.fixture
def port() -> Any:
    """Of a router."""
    port, config = free_port(), zenoh.Config()
    for name, value in session_settings(BusConfig(listen=(f"tcp/127.0.0.1:{port}",))).items():
        config.insert_json5(name, json.dumps(value))
    config.insert_json5("mode", '"router"')
    router = zenoh.open(config)
    yield port
    router.close()


def test_a_node_by_others_hears_sees_asks_and_is_heard(port: int):
    config = BusConfig(mode="client", dialect="rmw_zenoh", connect=(f"tcp/127.0.0.1:{port}",))
    for part, fields in (("Request", ("a", "b")), ("Response", ("sum",))):
        described: Any = [(name, (Nodetype.BASE, ("int64", 0))) for name in fields]
        wire.STORE.register({f"{ADD}_{part}": ([], described)})
    ending = threading.Event()
    with Bus(config, SystemClock()) as bus:
        # Of a topic below another it does not find what was kept: it looks for the name unmangled.
        kept = RosTopic("plan", OCCUPANCY_GRID, Qos(latched=True, depth=1))
        bus.publisher(kept).put(encode_map(the_map(), Stamp(5, "odom")))
        calls: list[ServiceCall] = []
        bus.node.serve(RosService("add_two_ints", ADD), calls.append)
        sent: list[ActionGoal] = []

        def want(goal: ActionGoal, accept: Callable[[bool], None]) -> None:
            accept(True)
            sent.append(goal)

        server = ActionServer(bus.node, "fibonacci", FIBONACCI, want, lambda *_: None)

        found = {"id": "0a", "result": "found", "code": 0, "sentence": "there", "at_xy": [1.5, 2.0]}
        asked: list[dict[str, Any]] = []
        goals = RosGoals(bus)

        def serve() -> None:
            while not ending.wait(0.02):
                bus.publish_state({"state": "ready"})
                bus.drive(DriveOrder(Twist(0.25, -0.5), 0, time.monotonic() + 1.0))
                while calls:
                    add(calls.pop())
                if (request := bus.request()) is not None:
                    asked.append(request.body)
                    request.reply({"accepted": True, "id": "0a"})
                    bus.publish_feedback(found)
                while sent:
                    goal = sent.pop()
                    server.begin(goal)
                    numbers = np.array(sequence(goal.message.order), np.int32)
                    server.end(goal, GoalState.SUCCEEDED, FIBONACCI.new("Result", numbers))

        serving = threading.Thread(target=serve)
        serving.start()
        try:
            peer = subprocess.run(
                [sys.executable, str(DOUBLES / "sdk_peer.py"), str(port)],
                capture_output=True, text=True, timeout=150.0, check=False,
            )  # fmt: skip
        finally:
            ending.set()
            serving.join()
            goals.close()
        assert peer.returncode == 0, peer.stderr[-2000:]
        told = json.loads(peer.stdout.splitlines()[-1])
        halt = bus.doubt(Twist())
    assert halt is not None
    assert "stopped by stop" in halt.reason  # its button
    assert told["state"] == {"state": "ready"}
    assert told["cmd_vel"] == [0.25, -0.5]
    assert told["map"] == MAP.ravel().tolist()  # it joined late
    assert told["sum"] == 42
    assert told["accepted"]
    assert told["result"] == [4, [0, 1, 1, 2, 3, 5]]
    assert asked == [{"goal": "a red mug", "settings": ["goal.keep_map=true"]}]
    assert told["find accepted"]
    assert told["found"] == [4, "found", "there", 1.5]
    assert told["cmd_vel by"] == ["rfnav"]
    assert told["topics"]["/plan"] == ["nav_msgs/msg/OccupancyGrid"]
    assert told["topics"]["/camera/color/image_raw"] == ["sensor_msgs/msg/Image"]
    assert told["topics"]["/cmd_vel_teleop"] == [
        "geometry_msgs/msg/Twist",
        "geometry_msgs/msg/TwistStamped",
    ]


def add(call: ServiceCall) -> None:
    request = wire.decode(call.payload, f"{ADD}_Request", "add")
    call.reply(wire.encode(wire.STORE.types[f"{ADD}_Response"](request.a + request.b)))


def the_map() -> MapCopy:
    frame = GridFrame(0.0, 0.0, 0.05, 2, 2)
    return MapCopy(frame, MAP == 100, MAP == 0, MAP == -1)
