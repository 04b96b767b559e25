"""A client of the runtime's own actions over plain Zenoh, in either dialect. What it sends and
reads is made by rosbags, of the files in deploy/, without the runtime's own wire."""

import math
import struct
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from places import ROOT
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = STORE.types
PACKAGE = "rf_nav_interfaces"
ID = "unique_identifier_msgs/UUID goal_id"
FIND, GO = "FindObject", "GoToPlace"
NAMES = {FIND: "rfnav/find_object", GO: "rfnav/go_to_place"}
HASHES = {  # as rmw_zenoh_cpp has them for Jazzy; they change with the files
    f"{FIND}_SendGoal": "10d35211227ae7948f0ce00e96f299b9720147a1eb17a208dc33face6ff1c294",
    f"{FIND}_GetResult": "fdb8ae6bc7b654386e5c6473e77c2d6023aadeda86fcba042856c5d26c86a590",
    f"{FIND}_FeedbackMessage": "80388a7ef7d43b8bdba52af0f4711940040663d0794b7bc4ba2f375d39ef88b7",
    f"{GO}_SendGoal": "296c74bc74011e14458536be04f57d85c05a4d66b72099712292c385f7b76abf",
    f"{GO}_GetResult": "6967db5f760900042bfe38811b34223dc5b7fc550f01da6f785bfaddb7fd09f6",
    f"{GO}_FeedbackMessage": "34917ad16564e1686e8edf691d0cfd8621d8fc6f1648e6f6937530ba132a49d2",
}
CANCEL = (
    "action_msgs::srv::dds_::CancelGoal_/"
    "RIHS01_573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a"
)
PARTS = {"send_goal": "SendGoal", "get_result": "GetResult", "feedback": "FeedbackMessage"}
NOTHING: dict[str, Any] = {
    "goal": [], "several": "", "if_busy": "", "time_limit_s": 0.0, "distance_limit_m": 0.0,
    "money_limit_usd": 0.0, "area": [], "area_room": "", "area_place": "", "frame_id": "",
    "afterwards": "", "afterwards_place": "", "episode": "", "settings": [],
}  # fmt: skip


def _define(action: str) -> None:
    kind = f"{PACKAGE}/action/{action}"
    text = (ROOT / f"deploy/ros/{PACKAGE}/action/{action}.action").read_text()
    goal, result, feedback = text.split("---\n")
    for part, fields in {
        "Goal": goal,
        "Result": result,
        "Feedback": feedback,
        "SendGoal_Request": f"{ID}\n{kind}_Goal goal",
        "GetResult_Request": ID,
        "GetResult_Response": f"int8 status\n{kind}_Result result",
        "FeedbackMessage": f"{ID}\n{kind}_Feedback feedback",
    }.items():
        STORE.register(get_types_from_msg(fields, f"{kind}_{part}"))


_define(FIND)
_define(GO)


def a_thing(*goal: str, **more: Any) -> Any:
    """A Goal of FindObject."""
    values = NOTHING | {"goal": list(goal)} | more
    return TYPES[f"{PACKAGE}/action/{FIND}_Goal"](*values.values())


def a_pose(x_m: float, y_m: float, yaw_rad: float, frame: str) -> Any:
    """A Goal of GoToPlace."""
    point = TYPES["geometry_msgs/msg/Point"](x_m, y_m, 0.0)
    half = yaw_rad / 2
    turn = TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(half), math.cos(half))
    header = TYPES["std_msgs/msg/Header"](TYPES["builtin_interfaces/msg/Time"](0, 0), frame)
    pose = TYPES["geometry_msgs/msg/Pose"](point, turn)
    stamped = TYPES["geometry_msgs/msg/PoseStamped"](header, pose)
    return TYPES[f"{PACKAGE}/action/{GO}_Goal"](stamped, "", "", 0.0, 0.0)


class GoalClient:
    """Of one action, in one dialect."""

    def __init__(self, session: Any, spoken: str, action: str = FIND) -> None:
        self._session, self._spoken, self._action, self._count = session, spoken, action, 0
        self.fed: list[tuple[bytes, Any]] = []
        self.changed = threading.Condition()
        self._listening = session.declare_subscriber(self._key("feedback"), self._feedback)

    def send(self, id: bytes, goal: Any) -> bool:
        return bool(self._ask("send_goal", self._new("SendGoal_Request", _uuid(id), goal))[4])

    def result(self, id: bytes) -> tuple[int, Any]:
        """Status and Result, when the goal has ended."""
        return self.asked_result(id)()

    def asked_result(self, id: bytes) -> Callable[[], tuple[int, Any]]:
        """The same, asked for now and waited for then."""
        replies = self._send("get_result", self._new("GetResult_Request", _uuid(id)))

        def wait() -> tuple[int, Any]:
            (reply,) = replies
            told = self._read(reply.ok.payload.to_bytes(), "GetResult_Response")
            return told.status, told.result

        return wait

    def cancel(self, id: bytes) -> tuple[int, int]:
        """Return code, and how many goals are being ended."""
        time_ = TYPES["builtin_interfaces/msg/Time"](0, 0)
        raw = self._ask("cancel_goal", TYPES["action_msgs/msg/GoalInfo"](_uuid(id), time_))
        return raw[4], struct.unpack_from("<I", raw, 8)[0]

    def close(self) -> None:
        self._listening.undeclare()

    def _new(self, part: str, *values: Any) -> Any:
        return TYPES[f"{PACKAGE}/action/{self._action}_{part}"](*values)

    def _read(self, raw: bytes, part: str) -> Any:
        return STORE.deserialize_cdr(raw, f"{PACKAGE}/action/{self._action}_{part}")

    def _key(self, what: str) -> str:
        key = f"{NAMES[self._action]}/_action/{what}"
        if self._spoken == "ros2dds":
            return key
        if what == "cancel_goal":
            return f"0/{key}/{CANCEL}"
        kind = f"{self._action}_{PARTS[what]}"
        return f"0/{key}/{PACKAGE}::action::dds_::{kind}_/RIHS01_{HASHES[kind]}"

    def _ask(self, what: str, message: Any) -> bytes:
        for _ in range(300):
            for reply in self._send(what, message):
                if reply.ok is not None:
                    return bytes(reply.ok.payload.to_bytes())
            time.sleep(0.1)  # it is not served yet
        raise AssertionError(f"nobody answers {self._key(what)}")

    def _send(self, what: str, message: Any) -> Any:
        self._count += 1
        goes_along = None
        if self._spoken == "rmw_zenoh":
            goes_along = struct.pack("<qqB16s", self._count, 5, 16, b"a fine client...")
        payload = bytes(STORE.serialize_cdr(message, message.__msgtype__))
        asked: Any = {"payload": payload, "attachment": goes_along, "timeout": 120.0}
        return self._session.get(self._key(what), **asked)

    def _feedback(self, sample: Any) -> None:
        told = self._read(sample.payload.to_bytes(), "FeedbackMessage")
        with self.changed:
            self.fed.append((bytes(told.goal_id.uuid), told.feedback))
            self.changed.notify_all()


def _uuid(id: bytes) -> Any:
    return TYPES["unique_identifier_msgs/msg/UUID"](np.frombuffer(id, np.uint8))
