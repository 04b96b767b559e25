"""A node of ROS 2 by somebody else: zenoh-ros2-sdk (ROBOTIS), which speaks as rmw_zenoh does with
code of its own. Run as `sdk_peer.py PORT`, of a router; prints as JSON what came of it.

Without a network it finds no message definitions, so they are here. Of types that have no others in
them it computes the hash itself; of the rest it is told what ROS 2's packages carry.
"""

import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

PORT = int(sys.argv[1])
os.environ["ZENOH_CONFIG_OVERRIDE"] = 'mode="client";scouting/multicast/enabled=false'

from zenoh_ros2_sdk import ROS2Publisher, ROS2ServiceClient, ROS2Subscriber  # noqa: E402
from zenoh_ros2_sdk.discovery import get_topic_info, get_topic_names_and_types  # noqa: E402
from zenoh_ros2_sdk.qos import QosDurability, QosProfile  # noqa: E402

PATIENCE_S = 20.0
LINE = "=" * 80
TWIST = f"""Vector3 linear
Vector3 angular
{LINE}
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
HEADER = f"""{LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
POSE = f"""{LINE}
MSG: geometry_msgs/Pose
Point position
Quaternion orientation
{LINE}
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
{LINE}
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""
MAP = f"""std_msgs/Header header
MapMetaData info
int8[] data
{LINE}
MSG: nav_msgs/MapMetaData
builtin_interfaces/Time map_load_time
float32 resolution
uint32 width
uint32 height
geometry_msgs/Pose origin
{HEADER}{POSE}"""
HASHES = {
    "twist": "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    "map": "RIHS01_8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7",
    "send_goal": "RIHS01_d1a57fb2a4afe8c21e34fb10db206f16ce6729b28531141472df92277c55b557",
    "find send_goal": "RIHS01_10d35211227ae7948f0ce00e96f299b9720147a1eb17a208dc33face6ff1c294",
    "find get_result": "RIHS01_fdb8ae6bc7b654386e5c6473e77c2d6023aadeda86fcba042856c5d26c86a590",
    "get_result": "RIHS01_1b0de0d5d29dc955d92f546706568428632771db13ec84c15ec1c1a59f424a57",
}
POINTS = f"""{LINE}
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
"""
FIND_GOAL = f"""uint8[16] goal_id
string[] goal
string several
string if_busy
float32 time_limit_s
float32 distance_limit_m
float32 money_limit_usd
geometry_msgs/Point[] area
string area_room
string area_place
string frame_id
string afterwards
string afterwards_place
string episode
string[] settings
{POINTS}"""
FIND_RESULT = f"""int8 status
uint16 code
string result
string cause
string sentence
float32 elapsed_s
float32 driven_m
float32 usd
geometry_msgs/Point[] at
string frame_id
string details
{POINTS}"""
ROUTER = {"domain_id": 0, "router_port": PORT}
ID = list(range(16))
told: dict[str, Any] = {}


def until(what: Callable[[], Any]) -> Any:
    by_s = time.monotonic() + PATIENCE_S
    while not (found := what()) and time.monotonic() < by_s:
        time.sleep(0.05)
    return found


def listen(
    topic: str, kind: str, definition: str, hashed: str | None = None, qos: Any = None
) -> list:
    heard: list[Any] = []
    ROS2Subscriber(topic, kind, heard.append, definition, type_hash=hashed, qos=qos, **ROUTER)
    return heard


def reports_and_commands() -> None:
    states = listen("/rfnav/state", "std_msgs/msg/String", "string data")
    commands = listen("/cmd_vel", "geometry_msgs/msg/Twist", TWIST, HASHES["twist"])
    told["state"] = until(lambda: states) and json.loads(states[0].data)
    told["cmd_vel"] = until(lambda: commands) and [commands[0].linear.x, commands[0].angular.z]


def late_map() -> None:
    kept = QosProfile(durability=QosDurability.TRANSIENT_LOCAL, history_depth=1)
    maps = listen("/plan", "nav_msgs/msg/OccupancyGrid", MAP, HASHES["map"], kept)
    told["map"] = until(lambda: maps) and [int(v) for v in maps[0].data]


def stop_button() -> None:
    button = ROS2Publisher("/stop", "std_msgs/msg/Bool", "bool data", **ROUTER)
    for _ in range(20):
        button.publish(data=True)
        time.sleep(0.05)


def graph() -> None:
    told["topics"] = dict(get_topic_names_and_types(**ROUTER))
    info = get_topic_info("/cmd_vel", verbose=True, **ROUTER)
    told["cmd_vel by"] = sorted(one.node_name for one in info.publishers) if info else None


def service() -> None:
    add = ROS2ServiceClient(
        "/add_two_ints",
        "example_interfaces/srv/AddTwoInts",
        "int64 a\nint64 b",
        "int64 sum",
        **ROUTER,
    )
    reply = until(lambda: add.call(a=2, b=40))
    told["sum"] = int(reply.sum) if reply else None


def action() -> None:
    """Its services: flat as they are on the wire."""
    within, kind = "/fibonacci/_action", "example_interfaces/action/Fibonacci"
    send = ROS2ServiceClient(
        f"{within}/send_goal", f"{kind}_SendGoal", "uint8[16] goal_id\nint32 order",
        "bool accepted\nint32 sec\nuint32 nanosec", type_hash=HASHES["send_goal"], **ROUTER,
    )  # fmt: skip
    ask = ROS2ServiceClient(
        f"{within}/get_result", f"{kind}_GetResult", "uint8[16] goal_id",
        "int8 status\nint32[] sequence", type_hash=HASHES["get_result"], **ROUTER,
    )  # fmt: skip
    import numpy as np

    goal_id = np.array(ID, np.uint8)
    reply = until(lambda: send.call(goal_id=goal_id, order=5))
    told["accepted"] = bool(reply.accepted) if reply else None
    result = ask.call(goal_id=goal_id)
    told["result"] = [int(result.status), [int(n) for n in result.sequence]] if result else None


def find() -> None:
    """A goal of one of the runtime's own actions."""
    import numpy as np

    within, kind = "/rfnav/find_object/_action", "rf_nav_interfaces/action/FindObject"
    send = ROS2ServiceClient(
        f"{within}/send_goal", f"{kind}_SendGoal", FIND_GOAL,
        "bool accepted\nint32 sec\nuint32 nanosec", type_hash=HASHES["find send_goal"], **ROUTER,
    )  # fmt: skip
    ask = ROS2ServiceClient(
        f"{within}/get_result", f"{kind}_GetResult", "uint8[16] goal_id", FIND_RESULT,
        type_hash=HASHES["find get_result"], **ROUTER,
    )  # fmt: skip
    goal_id = np.array(ID[::-1], np.uint8)
    said = {"goal": ["a red mug"], "settings": ["goal.keep_map=true"], "area": []}
    said |= dict.fromkeys(("time_limit_s", "distance_limit_m", "money_limit_usd"), 0.0)
    texts = "several", "if_busy", "area_room", "area_place", "frame_id", "afterwards"
    said |= dict.fromkeys((*texts, "afterwards_place", "episode"), "")
    reply = until(lambda: send.call(goal_id=goal_id, **said))
    told["find accepted"] = bool(reply.accepted) if reply else None
    got = ask.call(goal_id=goal_id)
    told["found"] = [int(got.status), got.result, got.sentence, got.at[0].x] if got else None


def main() -> None:
    for part in (reports_and_commands, late_map, graph, service, action, find, stop_button):
        part()
    print(json.dumps(told), flush=True)
    os._exit(0)  # its session has no other end


main()
