"""What is on each topic of a recording: ROS 2 types for what came over the wire and for pictures of
the map, JSON schemas for what is ours."""

import functools
from collections.abc import Mapping
from typing import Any, Final

from runtime.robot import wire

OCCUPANCY_GRID: Final = "nav_msgs/msg/OccupancyGrid"
PATH: Final = "nav_msgs/msg/Path"
MARKERS: Final = "visualization_msgs/msg/MarkerArray"

_NUMBER: Final = {"type": ["number", "string"]}  # a word where it is not finite
_INTEGER: Final = {"type": "integer"}
_TEXT: Final = {"type": "string"}
_FLAG: Final = {"type": "boolean"}
_ANY: Final[dict[str, Any]] = {}
_LIST: Final = {"type": "array"}
_MAYBE: Final = {"type": ["object", "null"]}
_TABLE: Final = {"type": "object"}
_PLACE: Final = {"type": ["array", "null"], "items": {"type": "number"}}


def _object(
    meaning: str, since: Mapping[str, Any] | None = None, **properties: Any
) -> dict[str, Any]:
    """`since`: properties that older recordings lack."""
    known, every = list(properties), {**properties, **(since or {})}
    return {"type": "object", "description": meaning, "properties": every, "required": known}


_POSE: Final = _object("In the map frame.", x_m=_NUMBER, y_m=_NUMBER, yaw_rad=_NUMBER)
_TWIST: Final = _object("What the base was sent.", v_mps=_NUMBER, w_radps=_NUMBER) | {
    "type": ["object", "null"]
}
_NEWEST: Final = {
    "type": ["object", "null"],
    "properties": {"pose": _POSE, "stamp_ns": _INTEGER, "arrival_s": _NUMBER},
}

JSON_SCHEMAS: Final[dict[str, dict[str, Any]]] = {
    "rfnav.Configuration": _object(
        "What the runtime was started with.", values=_TABLE, lockstep=_FLAG,
        since={"harness": _FLAG},
    ),
    "rfnav.Request": _object(
        "A query to the runtime.", kind=_TEXT, body=_TABLE, now_s=_NUMBER
    ),
    "rfnav.Order": _object("How a goal was understood.", goal=_TABLE, rooms=_LIST),
    "rfnav.Frame": _object(
        "An observation that the loop consumed; the images of it were written just before.",
        stamp_ns=_INTEGER, color_stamp_ns=_INTEGER, arrival_s=_NUMBER, now_s=_NUMBER, pose=_POSE,
        intrinsics=_TABLE, mount=_MAYBE, since={"scan": _MAYBE, "altered": _FLAG},
    ),
    "rfnav.Heard": _object("A value that the loop was given in passing.", name=_TEXT, value=_ANY),
    "rfnav.Detections": _object(
        "What was seen in the frame before.", boxes_px=_TABLE, scores=_TABLE, labels=_TABLE,
        embeddings=_TABLE, rooms=_TABLE, scene=_TABLE, depths_m=_TABLE, since={"features": _TABLE},
    ),
    "rfnav.Ballot": _object(
        "Votes as they came in, with what each expert said.", votes=_LIST, missing=_LIST,
        latency_s=_TABLE, rehearsal=_TEXT,
    ),
    "rfnav.Question": _object("What the experts were asked.", why=_TEXT, brief=_TABLE),
    "rfnav.Decision": _object(
        "A decision that was adopted.", frontier={"type": ["integer", "null"]}, rule=_TEXT,
        chosen=_LIST, why=_TEXT, in_words=_ANY, stamp_ns=_INTEGER,
    ),
    "rfnav.Command": _object(
        "What the loop wants of the base after a frame.", step=_INTEGER, action=_TEXT, mode=_TEXT,
        reason=_TEXT, toward_xy=_PLACE, frontiers=_LIST, objects=_INTEGER,
    ),
    "rfnav.Plan": _object("What the control loop follows.", number=_INTEGER, course=_TEXT,
                          frame_s=_NUMBER, limits=_TABLE),
    "rfnav.Rest": _object("The base was brought to rest.", state=_TEXT),
    "rfnav.Tick": _object(
        "A turn of the control loop: what it knew and what it sent.", now_s=_NUMBER,
        late_s=_NUMBER, odometry=_NEWEST, frame_s=_ANY, plan=_INTEGER, stopping=_FLAG,
        withdrawn=_FLAG, sent=_TWIST, halt=_TEXT,
        since={"asked": _TWIST, "base": _TABLE, "felt": _TABLE},
    ),
    "rfnav.Halt": _object(
        "The base is held, or no longer.", kind=_TEXT, reason=_TEXT, driving=_FLAG
    ),
    "rfnav.Recorder": _object("What was lost so far.", dropped=_TABLE, backlog_bytes=_INTEGER),
}  # fmt: skip


@functools.cache
def ros_definition(kind: str) -> str:
    """The definition of a ROS 2 type, with those that it is made of, as `ros2msg` has it."""
    text, _ = wire.STORE.generate_msgdef(kind, ros_version=2)
    return text
